#include "identify/problem.h"

#include <algorithm>
#include <filesystem>
#include <map>
#include <utility>

#include "costs/evaluation_journal.h"
#include "identify/fingerprint.h"
#include "sim/error.h"

namespace clothid {
namespace {

// A forward sweep carries one column per parameter, and its Jacobian is kept: with more of them the adjoint starts
// alone.
constexpr int kMaxFirstSensitivities = 12;

std::vector<std::string> FittedNames(const std::vector<RecordedMotion>& motions, const FitOptions& options) {
  if (!options.parameters.empty()) return options.parameters;
  const bool has_obstacles = std::any_of(motions.begin(), motions.end(),
                                         [](const RecordedMotion& motion) { return !motion.scene.obstacles.empty(); });
  return has_obstacles ? std::vector<std::string>{"mu", "k_stretch"} : std::vector<std::string>{"k_stretch"};
}

// The scene that gives start and bounds of `name`: the first that has it; for "mu" the first with an obstacle. Where
// none has it, the first scene, whose error message lists the names it knows.
const Scene& SceneOf(const std::string& name, const std::vector<RecordedMotion>& motions) {
  for (const RecordedMotion& motion : motions) {
    if (HasParameter(motion.scene, name) && (name != "mu" || !motion.scene.obstacles.empty())) return motion.scene;
  }
  return motions.front().scene;
}

void CheckOverrides(const std::map<std::string, double>& values, const std::vector<std::string>& names,
                    const std::string& flag) {
  for (const auto& [name, value] : values) {
    if (std::find(names.begin(), names.end(), name) == names.end()) {
      throw Error(ErrorKind::kUsage, flag + ": '" + name + "' is not among the fitted parameters");
    }
  }
}

// "mu" is the friction of every obstacle, so it cannot be fitted beside the friction of one of them.
void CheckOverlap(const std::vector<std::string>& names) {
  if (std::find(names.begin(), names.end(), "mu") == names.end()) return;
  for (const std::string& name : names) {
    if (name.rfind("mu.", 0) == 0) {
      throw Error(ErrorKind::kUsage,
                  "--fit: 'mu' sets the friction of every obstacle, so '" + name + "' cannot be fitted beside it");
    }
  }
}

std::shared_ptr<EvaluationJournal> OpenJournal(const FitOptions& options, const std::string& fingerprint,
                                               int recording) {
  const std::string tag = options.journal_tag.empty() ? "" : options.journal_tag + "_";
  const std::string name = kJournalPrefix + tag + std::to_string(recording + 1) + ".bin";
  return std::make_shared<EvaluationJournal>((std::filesystem::path(options.journal_folder) / name).string(),
                                             fingerprint);
}

}  // namespace

bool HasParameter(const Scene& scene, const std::string& name) {
  const std::string prefix = "mu.";
  if (name.rfind(prefix, 0) != 0) return true;
  const std::vector<std::string> names = scene.obstacle_names();
  return std::find(names.begin(), names.end(), name.substr(prefix.size())) != names.end();
}

FitProblem::FitProblem(const std::vector<RecordedMotion>& motions, const FitOptions& options) {
  if (motions.empty()) throw Error(ErrorKind::kUsage, "--target: expected at least one recording");
  options.Validate();
  const std::vector<std::string> names = FittedNames(motions, options);
  CheckOverlap(names);
  CheckOverrides(options.overrides.start, names, "--start");
  CheckOverrides(options.overrides.lower_bounds, names, "--lower");
  CheckOverrides(options.overrides.upper_bounds, names, "--upper");
  for (const std::string& name : names) {
    blocks_.push_back(MakeParameterBlock(name, SceneOf(name, motions), options.overrides));
  }
  if (std::all_of(blocks_.begin(), blocks_.end(), [](const ParameterBlock& block) { return block.frozen; })) {
    throw Error(ErrorKind::kUsage, "--fit: every parameter is frozen by the scene");
  }

  RolloutCostOptions cost_options;
  cost_options.jacobian = options.jacobian;
  cost_options.adjoint = options.adjoint;
  cost_options.loss = options.loss;
  cost_options.cancel = options.cancel;
  cost_options.starts_with_sensitivities =
      options.method == FitMethod::kLevenbergMarquardt && num_blocks() <= kMaxFirstSensitivities;
  cost_options.keep_factors = options.method == FitMethod::kLbfgs && options.jacobian == JacobianMethod::kAdjoint &&
                              options.adjoint.method == AdjointMethod::kReduced;
  const bool has_journal = !options.journal_folder.empty();
  const std::string fingerprint = has_journal ? FitFingerprint(motions, blocks_, options) : std::string();
  for (const RecordedMotion& motion : motions) {
    std::vector<int> indices;
    std::vector<ParameterBlock> blocks;
    for (int i = 0; i < num_blocks(); ++i) {
      if (!HasParameter(motion.scene, blocks_[i].name)) continue;
      indices.push_back(i);
      blocks.push_back(blocks_[i]);
    }
    if (has_journal) cost_options.journal = OpenJournal(options, fingerprint, num_recordings());
    costs_.push_back(std::make_unique<RolloutCost>(motion, std::move(blocks), cost_options));
    block_indices_.push_back(std::move(indices));
  }
}

void FitProblem::SetStart(const Eigen::VectorXd& coordinates) {
  for (int i = 0; i < num_blocks(); ++i) {
    // A start that stays keeps its last digit, which it would lose on the way through the coordinate.
    if (blocks_[i].ToCoordinate(blocks_[i].start) != coordinates[i])
      blocks_[i].start = blocks_[i].ToValue(coordinates[i]);
  }
}

Eigen::VectorXd FitProblem::StartCoordinates() const {
  Eigen::VectorXd coordinates(num_blocks());
  for (int i = 0; i < num_blocks(); ++i) coordinates[i] = blocks_[i].ToCoordinate(blocks_[i].start);
  return coordinates;
}

Eigen::VectorXd FitProblem::Values(const Eigen::VectorXd& coordinates) const {
  Eigen::VectorXd values(num_blocks());
  for (int i = 0; i < num_blocks(); ++i) values[i] = blocks_[i].ToValue(coordinates[i]);
  return values;
}

Eigen::VectorXd FitProblem::CoordinatesOf(int recording, const Eigen::VectorXd& coordinates) const {
  return coordinates(block_indices_[recording]);
}

void FitProblem::SetPrecision(Precision precision) {
  for (const auto& cost : costs_) cost->SetPrecision(precision);
}

void FitProblem::Restart() {
  for (const auto& cost : costs_) cost->Restart();
}

void FitProblem::CheckJournals() const {
  for (const auto& cost : costs_) cost->CheckJournal();
}

std::unique_ptr<ceres::Problem> FitProblem::MakeCeresProblem(ceres::EvaluationCallback* callback,
                                                             Eigen::VectorXd* coordinates) {
  ceres::Problem::Options options;
  options.cost_function_ownership = ceres::DO_NOT_TAKE_OWNERSHIP;
  options.evaluation_callback = callback;
  auto problem = std::make_unique<ceres::Problem>(options);
  for (int i = 0; i < num_blocks(); ++i) {
    double* coordinate = coordinates->data() + i;
    problem->AddParameterBlock(coordinate, 1);
    problem->SetParameterLowerBound(coordinate, 0, blocks_[i].ToCoordinate(blocks_[i].lower_bound));
    problem->SetParameterUpperBound(coordinate, 0, blocks_[i].ToCoordinate(blocks_[i].upper_bound));
    if (blocks_[i].frozen) problem->SetParameterBlockConstant(coordinate);
  }
  for (int r = 0; r < num_recordings(); ++r) {
    std::vector<double*> parameters;
    for (int i : block_indices_[r]) parameters.push_back(coordinates->data() + i);
    if (!parameters.empty()) problem->AddResidualBlock(costs_[r].get(), nullptr, parameters);
  }
  return problem;
}

int FindFreeBlock(const FitProblem& problem, const std::string& name, const std::string& flag) {
  for (int i = 0; i < problem.num_blocks(); ++i) {
    if (problem.blocks()[i].name != name) continue;
    if (problem.blocks()[i].frozen) throw Error(ErrorKind::kUsage, flag + ": '" + name + "' is frozen by the scene");
    return i;
  }
  throw Error(ErrorKind::kUsage, flag + ": '" + name + "' is not among the fitted parameters");
}

}  // namespace clothid

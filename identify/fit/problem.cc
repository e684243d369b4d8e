#include "identify/fit/problem.h"

#include <algorithm>
#include <chrono>
#include <filesystem>
#include <map>
#include <utility>

#include "costs/rows/evaluation_journal.h"
#include "identify/base/fingerprint.h"
#include "identify/fit/prior_costs.h"
#include "sim/base/error.h"
#include "sim/base/phase_seconds.h"
#include "sim/base/text_file.h"

namespace clothid {
namespace {

// Columns of a forward sweep, one per parameter, with which it is still cheap. With more of them the adjoint starts
// alone.
constexpr int kFewBlocks = 12;

std::vector<std::string> FittedNames(const std::vector<RecordedMotion>& motions, const FitOptions& options) {
  if (!options.parameters.empty()) return options.parameters;
  const bool has_obstacles = std::any_of(motions.begin(), motions.end(),
                                         [](const RecordedMotion& motion) { return !motion.scene.obstacles.empty(); });
  std::vector<std::string> names;
  if (has_obstacles) names.emplace_back("mu");
  if (motions.front().scene.membrane == MembraneLaw::kArap) {
    names.emplace_back("k_stretch");
  } else {
    names.insert(names.end(), {"k_warp", "k_weft"});
  }
  return names;
}

// "mu" is in every scene, but says something only where there are obstacles.
bool TellsOf(const RecordedMotion& motion, const std::string& name) {
  return HasParameter(motion.scene, name) && (name != "mu" || !motion.scene.obstacles.empty());
}

// The recording that gives start and bounds of `name`: the first that has it. Where none has it, the first one, whose
// error message lists the names it knows.
const RecordedMotion& RecordingOf(const std::string& name, const std::vector<RecordedMotion>& motions) {
  const auto found =
      std::find_if(motions.begin(), motions.end(), [&](const RecordedMotion& motion) { return TellsOf(motion, name); });
  return found == motions.end() ? motions.front() : *found;
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

// Expands groups of names, and refuses names that would not come out.
std::vector<std::string> Expand(const std::vector<std::string>& names, const std::string& flag) {
  const std::vector<std::string> expanded = ExpandAlignmentNames(names);
  for (const std::string& name : expanded) {
    if (BaseName(name) != name) {
      throw Error(ErrorKind::kUsage, flag + ": '" + Printable(name) +
                                         "': expected a name without '@'; --each makes one parameter per recording");
    }
    if (std::count(expanded.begin(), expanded.end(), name) > 1) {
      throw Error(ErrorKind::kUsage, flag + ": '" + Printable(name) + "' is given twice");
    }
  }
  return expanded;
}

// One block per recording that has the parameter. Where none has it, that of the first, or its error message.
std::vector<ParameterBlock> BlocksOfEach(const std::string& name, const std::vector<RecordedMotion>& motions,
                                         const ParameterOverrides& overrides) {
  std::vector<ParameterBlock> blocks;
  for (std::size_t r = 0; r < motions.size(); ++r) {
    if (!TellsOf(motions[r], name) && &RecordingOf(name, motions) != &motions[r]) continue;
    const std::string suffix = motions.size() > 1 ? "@" + std::to_string(r + 1) : "";
    blocks.push_back(MakeParameterBlock(name + suffix, motions[r], overrides));
    blocks.back().recording = static_cast<int>(r);
  }
  return blocks;
}

std::vector<ParameterBlock> MakeBlocks(const std::vector<RecordedMotion>& motions, const FitOptions& options) {
  std::vector<std::string> names = Expand(FittedNames(motions, options), "--fit");
  const std::vector<std::string> each = Expand(options.each, "--each");
  const auto contains = [](const std::vector<std::string>& list, const std::string& name) {
    return std::find(list.begin(), list.end(), name) != list.end();
  };
  for (const std::string& name : each) {
    if (!contains(names, name)) names.push_back(name);
  }
  CheckOverlap(names);
  std::vector<ParameterBlock> blocks;
  for (const std::string& name : names) {
    if (!contains(each, name)) {
      blocks.push_back(MakeParameterBlock(name, RecordingOf(name, motions), options.overrides));
      continue;
    }
    const std::vector<ParameterBlock> own = BlocksOfEach(name, motions, options.overrides);
    blocks.insert(blocks.end(), own.begin(), own.end());
  }
  return blocks;
}

template <typename Value>
void CheckOverrides(const std::map<std::string, Value>& values, const std::vector<ParameterBlock>& blocks,
                    const std::string& flag) {
  for (const auto& [name, value] : values) {
    const bool is_known = std::any_of(blocks.begin(), blocks.end(), [&given = name](const ParameterBlock& block) {
      const std::vector<std::string> names = OverrideNames(block.name);
      return std::find(names.begin(), names.end(), given) != names.end();
    });
    if (!is_known) {
      throw Error(ErrorKind::kUsage, flag + ": '" + name + "' is not among the fitted parameters");
    }
  }
}

std::shared_ptr<EvaluationJournal> OpenJournal(const FitOptions& options, const std::string& fingerprint,
                                               int recording) {
  const std::string tag = options.journal_tag.empty() ? "" : options.journal_tag + "_";
  const std::string name = kJournalPrefix + tag + std::to_string(recording + 1) + ".bin";
  return std::make_shared<EvaluationJournal>((std::filesystem::path(options.journal_folder) / name).string(),
                                             fingerprint, options.journal_room);
}

std::shared_ptr<EvaluationTracker> MakeTracker(const ProgressObserver& observer) {
  return std::make_shared<EvaluationTracker>(observer, SteadySeconds);
}

// What the costs of all recordings share.
RolloutCostOptions CostOptions(const FitOptions& options) {
  RolloutCostOptions cost_options;
  cost_options.jacobian = options.jacobian;
  cost_options.adjoint = options.adjoint;
  cost_options.loss = options.loss;
  cost_options.cancel = options.cancel;
  return cost_options;
}

}  // namespace

bool HasParameter(const Scene& scene, const std::string& name) {
  const std::string prefix = "mu.", base = BaseName(name);
  for (const ParameterKind kind : kMaterialKinds) {
    if (base == ParameterName({kind}, {})) return scene.has(kind);
  }
  if (base.rfind("wind.", 0) == 0) {
    const int knot = ParseParameter(base, scene.obstacle_names()).knot;
    return knot < scene.wind.profile.num_knots();
  }
  if (base.rfind(prefix, 0) != 0) return true;
  const std::vector<std::string> names = scene.obstacle_names();
  return std::find(names.begin(), names.end(), base.substr(prefix.size())) != names.end();
}

bool Concerns(const ParameterBlock& block, const RecordedMotion& motion, int recording) {
  return (block.recording == kEveryRecording || block.recording == recording) && HasParameter(motion.scene, block.name);
}

FitProblem::FitProblem(const std::vector<RecordedMotion>& motions, const FitOptions& options, const FitProblem* whole) {
  if (motions.empty()) throw Error(ErrorKind::kUsage, "--target: expected at least one recording");
  options.Validate();
  blocks_ = MakeBlocks(motions, options);
  CheckOverrides(options.overrides.start, blocks_, "--start");
  CheckOverrides(options.overrides.lower_bounds, blocks_, "--lower");
  CheckOverrides(options.overrides.upper_bounds, blocks_, "--upper");
  CheckOverrides(options.overrides.priors, blocks_, "--prior");
  if (std::all_of(blocks_.begin(), blocks_.end(), [](const ParameterBlock& block) { return block.frozen; })) {
    throw Error(ErrorKind::kUsage, "--fit: every parameter is frozen by the scene");
  }
  if (options.wind_smoothness > 0.0) LinkKnots(motions, options.wind_smoothness, &blocks_);
  for (const ParameterBlock& block : blocks_) {
    priors_.push_back(MakePriorCost(block));
    links_.push_back(MakeLinkCost(block));
  }
  if (options.on_progress) tracker_ = MakeTracker(options.on_progress);
  OpenJournals(motions, options, whole);
  for (const RecordedMotion& motion : motions) {
    RolloutCostOptions cost_options = CostOptions(options);
    cost_options.num_threads = std::max(1, options.num_threads / static_cast<int>(motions.size()));
    if (!journals_.empty()) cost_options.journal = journals_[num_recordings()];
    AddCost(motion, std::move(cost_options));
  }
}

void FitProblem::OpenJournals(const std::vector<RecordedMotion>& motions, const FitOptions& options,
                              const FitProblem* whole) {
  if (options.journal_folder.empty()) return;
  if (whole != nullptr) {
    journals_ = whole->journals_;
    return;
  }
  const std::string fingerprint = FitFingerprint(motions, blocks_, options);
  for (int r = 0; r < static_cast<int>(motions.size()); ++r) journals_.push_back(OpenJournal(options, fingerprint, r));
}

void FitProblem::AddCost(const RecordedMotion& motion, RolloutCostOptions cost_options) {
  std::vector<int> indices;
  std::vector<ParameterBlock> blocks;
  for (int i = 0; i < num_blocks(); ++i) {
    if (!Concerns(blocks_[i], motion, num_recordings())) continue;
    indices.push_back(i);
    blocks.push_back(blocks_[i]);
  }
  cost_options.starts_with_sensitivities = static_cast<int>(indices.size()) <= kFewBlocks;
  if (tracker_ != nullptr) {
    cost_options.on_step = [tracker = tracker_, recording = num_recordings()](const PassStep& step) {
      tracker->AddStep(recording, step);
    };
  }
  costs_.push_back(std::make_unique<RolloutCost>(motion, std::move(blocks), cost_options));
  loose_costs_.push_back(costs_.back()->AtPrecision(Precision::kLoose));
  if (tracker_ != nullptr) tracker_->AddRecording(costs_.back()->model().num_steps());
  block_indices_.push_back(indices);
  const int num_unknowns = costs_.back()->model().num_start_unknowns();
  for (int i = 0; i < num_unknowns; ++i) indices.push_back(num_coordinates() + i);
  num_start_unknowns_ += num_unknowns;
  coordinate_indices_.push_back(std::move(indices));
}

MeasuredConstant FitProblem::MeasuredOf(int block) const {
  for (int r = 0; r < num_recordings(); ++r) {
    if (std::count(block_indices_[r].begin(), block_indices_[r].end(), block) == 0) continue;
    const MeasuredConstant* measured = MeasuredOfAnyCloth(blocks_[block].name, costs_[r]->model().scene());
    return measured == nullptr ? MeasuredConstant() : *measured;
  }
  return {};
}

bool FitProblem::has_few_blocks() const {
  return std::all_of(block_indices_.begin(), block_indices_.end(),
                     [](const std::vector<int>& blocks) { return static_cast<int>(blocks.size()) <= kFewBlocks; });
}

void FitProblem::SetStart(const Eigen::VectorXd& coordinates) {
  for (int i = 0; i < num_blocks(); ++i) {
    // A start that stays keeps its last digit, which it would lose on the way through the coordinate.
    if (blocks_[i].ToCoordinate(blocks_[i].start) != coordinates[i])
      blocks_[i].start = blocks_[i].ToValue(coordinates[i]);
  }
  start_unknowns_ = coordinates.tail(coordinates.size() - num_blocks());
}

Eigen::VectorXd FitProblem::StartCoordinates() const {
  Eigen::VectorXd coordinates = Eigen::VectorXd::Zero(num_coordinates());
  for (int i = 0; i < num_blocks(); ++i) coordinates[i] = blocks_[i].ToCoordinate(blocks_[i].start);
  coordinates.tail(start_unknowns_.size()) = start_unknowns_;
  return coordinates;
}

Eigen::VectorXd FitProblem::Values(const Eigen::VectorXd& coordinates) const {
  Eigen::VectorXd values(num_blocks());
  for (int i = 0; i < num_blocks(); ++i) values[i] = blocks_[i].ToValue(coordinates[i]);
  return values;
}

Eigen::VectorXd FitProblem::CoordinatesOf(int recording, const Eigen::VectorXd& coordinates) const {
  if (coordinates.size() == num_coordinates()) return coordinates(coordinate_indices_[recording]);
  const std::vector<int>& indices = block_indices_[recording];
  Eigen::VectorXd own = Eigen::VectorXd::Zero(static_cast<Eigen::Index>(coordinate_indices_[recording].size()));
  own.head(static_cast<Eigen::Index>(indices.size())) = coordinates(indices);
  return own;
}

void FitProblem::Restart() {
  for (const auto& cost : costs_) cost->Restart();
}

void FitProblem::Forget() {
  for (const auto& cost : costs_) cost->Forget();
}

void FitProblem::CheckJournals() const {
  for (const auto& cost : costs_) cost->CheckJournal();
}

std::unique_ptr<ceres::Problem> FitProblem::MakeCeresProblem(ceres::EvaluationCallback* callback,
                                                             Eigen::VectorXd* coordinates, Precision precision) {
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
    if (priors_[i] != nullptr) problem->AddResidualBlock(priors_[i].get(), nullptr, coordinate);
  }
  for (int i = 0; i < num_blocks(); ++i) {
    if (links_[i] == nullptr) continue;
    double* const other = coordinates->data() + blocks_[i].linked_to;
    problem->AddResidualBlock(links_[i].get(), nullptr, coordinates->data() + i, other);
  }
  for (int r = 0; r < num_recordings(); ++r) {
    std::vector<double*> parameters;
    for (int i : block_indices_[r]) parameters.push_back(coordinates->data() + i);
    if (const int size = costs_[r]->model().num_start_unknowns(); size > 0) {
      parameters.push_back(coordinates->data() + coordinate_indices_[r][block_indices_[r].size()]);
      problem->AddParameterBlock(parameters.back(), size);
      problem->SetParameterBlockConstant(parameters.back());
    }
    const std::unique_ptr<RolloutCost>& own = precision == Precision::kFull ? costs_[r] : loose_costs_[r];
    if (!parameters.empty()) problem->AddResidualBlock(own.get(), nullptr, parameters);
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

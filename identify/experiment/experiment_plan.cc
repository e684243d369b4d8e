#include "identify/experiment/experiment_plan.h"

#include <algorithm>
#include <cmath>
#include <memory>
#include <optional>

#include "identify/base/output_folder.h"
#include "identify/base/parallel_for.h"
#include "identify/experiment/candidate.h"
#include "identify/experiment/cloth_information.h"
#include "identify/experiment/expectation.h"
#include "identify/experiment/improvement.h"
#include "identify/experiment/pair.h"
#include "identify/experiment/prediction_width.h"
#include "sim/base/error.h"

namespace clothid {
namespace {

// One plan, from its scenes to what is expected of each.
class Planner {
 public:
  explicit Planner(const PlanOptions& options) : options_(options), candidates_(ReadCandidates(options)) {
    if (options.predicted_path.empty()) return;
    predicted_.emplace(ReadPredicted(options));
    plan_.predicted = predicted_->name();
    plan_.believed_width = predicted_->BelievedWidth();
  }

  Plan Run() {
    SimulateAll();
    for (const Candidate& candidate : candidates_) {
      for (const ParameterBlock& block : candidate.blocks) AddName(block.name);
    }
    for (const std::vector<ClothInformation>& cloths : cloths_) {  // those of a recording itself as well
      for (const ParameterBlock& block : cloths.front().blocks) AddName(block.name);
    }
    plan_.candidates.resize(candidates_.size());
    planned_.resize(candidates_.size());
    for (std::size_t c = 0; c < candidates_.size(); ++c) Describe(c);
    for (std::size_t a = 0; a < candidates_.size(); ++a) {
      for (std::size_t b = a + 1; b < candidates_.size(); ++b) DescribePair(a, b);
    }
    for (CandidatePlan& candidate : plan_.candidates) {
      if (candidate.failure.empty()) SortImprovements(candidate.worst_told, &candidate.improvements);
    }
    return std::move(plan_);
  }

 private:
  void AddName(const std::string& name) {
    if (std::find(plan_.parameters.begin(), plan_.parameters.end(), name) == plan_.parameters.end()) {
      plan_.parameters.push_back(name);
    }
  }

  // The nominal cloths first: the others need to know of them, and they take the longest.
  void SimulateAll() {
    const int num_candidates = static_cast<int>(candidates_.size());
    cloths_.assign(candidates_.size(), std::vector<ClothInformation>(static_cast<std::size_t>(1 + options_.num_draws)));
    Simulate(0, num_candidates);
    Simulate(num_candidates, options_.num_draws * num_candidates);
  }

  // `count` cloths from `first` on, those of the same number side by side.
  void Simulate(int first, int count) {
    const int num_candidates = static_cast<int>(candidates_.size()),
              num_all = (1 + options_.num_draws) * num_candidates;
    ParallelFor(
        count, options_.fit.num_threads,
        [&](int task) {
          const int cloth = (first + task) / num_candidates;
          const auto candidate = static_cast<std::size_t>((first + task) % num_candidates);
          std::vector<ClothInformation>& own = cloths_[candidate];
          if (cloth > 0 && !own.front().failure.empty()) return;  // nothing is said of such a candidate
          own[static_cast<std::size_t>(cloth)] = InformCloth(options_, candidates_[candidate], cloth, own.front());
        },
        [&](int, int num_done) {
          if (options_.on_progress) options_.on_progress(first + num_done, num_all);
        });
  }

  void DescribeRecording(std::size_t c) {
    CandidatePlan& candidate = plan_.candidates[c];
    const ClothInformation& nominal = cloths_[c].front();
    const Scene& scene = candidates_[c].scene;
    candidate.duration = scene.duration;
    candidate.time_step = scene.time_step;
    candidate.num_frames = nominal.recording.num_frames();
    candidate.num_points = nominal.recording.num_points();
    candidate.num_nodes = static_cast<int>(scene.mesh.num_nodes());
    candidate.start = nominal.recording.start_source;
    candidate.map = nominal.map;
    candidate.motion = {nominal.recording.scene, nominal.recording.times, nominal.nodes, {}};
    for (const ObservedPoint& point : nominal.recording.points) candidate.motion.seen.push_back(point.nodes[0]);
    for (std::size_t i = 0; i < nominal.blocks.size(); ++i) {
      const auto column = static_cast<Eigen::Index>(i);
      const double per_unit = std::pow(UnitOf(nominal.blocks[i]), -2);
      candidate.map.columns.push_back(IndexOf(nominal.blocks[i].name));
      candidate.map.per_node.col(column) *= per_unit;
      candidate.map.per_frame.col(column) *= per_unit;
      candidate.map.of_forces[column] *= per_unit;
    }
    for (const ClothInformation& cloth : cloths_[c]) {
      if (!cloth.failure.empty()) candidate.failed_cloths.push_back(cloth.failure);
    }
    candidate.num_cloths = static_cast<int>(cloths_[c].size() - candidate.failed_cloths.size());
  }

  void Describe(std::size_t c) {
    CandidatePlan& candidate = plan_.candidates[c];
    candidate.name = candidates_[c].name;
    candidate.failure = cloths_[c].front().failure;
    if (!candidate.failure.empty()) return;
    DescribeRecording(c);
    const std::vector<ClothRows> rows = PlannedRows(cloths_[c]);
    planned_[c] = std::make_unique<Expectation>(rows, cloths_[c].front().step_errors);
    if (predicted_) candidate.prediction_width = predicted_->Width(rows, cloths_[c].front().step_errors);
    const Expectation& planned = *planned_[c];
    for (const std::string& name : plan_.parameters) {
      ExpectedParameter missing;
      missing.name = name;
      missing.not_told = "its scene does not have it";
      candidate.parameters.push_back(missing);
    }
    double worst = -1.0;
    for (int i = 0; i < static_cast<int>(planned.blocks().size()); ++i) {
      const int index = IndexOf(planned.blocks()[static_cast<std::size_t>(i)].name);
      ExpectedParameter& expected = candidate.parameters[static_cast<std::size_t>(index)];
      expected = planned.Parameter(i);
      const double share = planned.Widths(0.0)[i] / StdBefore(planned.blocks()[static_cast<std::size_t>(i)]);
      if (!(share > worst)) continue;  // also where it is frozen
      worst = share;
      candidate.worst_told = index;
    }
    SetKnownStart(c);
    candidate.improvements = FindImprovements(plan_.parameters, cloths_[c], planned);
  }

  void SetKnownStart(std::size_t c) {
    std::vector<ClothRows> known;
    for (const ClothInformation& cloth : cloths_[c]) {
      const auto rows = cloth.improved.find(ImprovementKind::kKnownStart);
      if (cloth.failure.empty() && rows != cloth.improved.end()) {
        known.push_back(RowsOf(cloth, rows->second));
      }
    }
    if (known.empty()) return;
    const Expectation expectation(known, {});
    for (int i = 0; i < static_cast<int>(expectation.blocks().size()); ++i) {
      const int index = IndexOf(expectation.blocks()[static_cast<std::size_t>(i)].name);
      plan_.candidates[c].parameters[static_cast<std::size_t>(index)].known_start_std = expectation.Std(i);
    }
  }

  void DescribePair(std::size_t a, std::size_t b) {
    if (planned_[a] == nullptr || planned_[b] == nullptr) return;
    const JointCloths joint = JoinCloths(options_, candidates_[a], candidates_[b], cloths_[a], cloths_[b]);
    const Expectation expectation(joint.cloths, joint.step_errors);
    PairPlan pair;
    pair.first = static_cast<int>(a);
    pair.second = static_cast<int>(b);
    pair.num_cloths = static_cast<int>(joint.cloths.size());
    if (predicted_) pair.prediction_width = predicted_->Width(joint.cloths, joint.step_errors);
    for (int i = 0; i < static_cast<int>(expectation.blocks().size()); ++i) {
      pair.parameters.push_back(expectation.Parameter(i));
    }
    for (const auto& [own, other] : {std::pair(a, b), std::pair(b, a)}) {
      plan_.candidates[own].improvements.push_back(
          FindPartner(plan_.parameters, *planned_[own], expectation, static_cast<int>(other)));
    }
    plan_.pairs.push_back(std::move(pair));
  }

  int IndexOf(const std::string& name) const {
    return static_cast<int>(std::find(plan_.parameters.begin(), plan_.parameters.end(), name) -
                            plan_.parameters.begin());
  }

  const PlanOptions& options_;
  const std::vector<Candidate> candidates_;
  std::vector<std::vector<ClothInformation>> cloths_;  // per candidate, the nominal one first
  std::vector<std::unique_ptr<Expectation>> planned_;  // per candidate; null: it failed
  std::optional<MotionToPredict> predicted_;           // none: nothing is
  Plan plan_;
};

}  // namespace

bool Plan::has_any() const {
  return std::any_of(candidates.begin(), candidates.end(),
                     [](const CandidatePlan& candidate) { return candidate.failure.empty(); });
}

Plan PlanExperiment(const PlanOptions& options) {
  options.Validate();
  std::unique_ptr<OutputFolder> folder;
  Planner planner(options);
  if (!options.output.empty()) {
    for (const std::string& path : options.scene_paths) {
      ExpectNotReplaced("--scenes", path, options.output,
                        [](const std::string& name) { return name == kPlanFile || name == kPlanPageFile; });
    }
    folder = std::make_unique<OutputFolder>(options.output);
  }
  Plan plan = planner.Run();
  if (folder != nullptr && plan.has_any() && !options.fit.is_cancelled()) {
    folder->Write(kPlanFile, PlanJson(options, plan));
    folder->Write(kPlanPageFile, PlanHtml(options, plan));
    folder->Commit();
  }
  return plan;
}

}  // namespace clothid

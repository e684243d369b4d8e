#include "identify/card/card_of_fit.h"

#include <algorithm>
#include <cmath>
#include <map>
#include <optional>

#include "costs/prediction/parameter_block.h"
#include "identify/base/version.h"
#include "identify/card/seen_ranges.h"
#include "identify/verdict/told.h"

namespace clothid {
namespace {

// The parameter of the whole cloth, of all recordings or of the first; -1: it is not fitted.
int FindFitted(const FitSummary& summary, const std::string& name) {
  for (int i = 0; i < static_cast<int>(summary.parameters.size()); ++i) {
    const FittedParameter& parameter = summary.parameters[static_cast<std::size_t>(i)];
    if (!parameter.frozen && (parameter.name == name || parameter.name == name + "@1")) return i;
  }
  return -1;
}

void TakeEstimate(const FitSummary& summary, const FitChecks& checks, int index, CardConstant* constant) {
  constant->value = summary.parameters[static_cast<std::size_t>(index)].value;
  if (!HasInterval(summary, checks, index)) return;
  const ParameterUncertainty& uncertainty = summary.uncertainty->parameters[static_cast<std::size_t>(index)];
  if (!(uncertainty.lower95 < uncertainty.upper95)) return;
  constant->known_by = KnownBy::kFitted;
  constant->lower95 = uncertainty.lower95;
  constant->upper95 = uncertainty.upper95;
}

// Of repetitions.
void TakeMean(const Repetitions& repetitions, const std::string& name, CardConstant* constant) {
  for (const PooledParameter& pooled : repetitions.parameters) {
    if (pooled.name != name || !pooled.is_pooled() || !(pooled.lower95 < pooled.upper95)) continue;
    constant->value = pooled.mean;
    constant->known_by = KnownBy::kFitted;
    constant->lower95 = pooled.lower95;
    constant->upper95 = pooled.upper95;
    constant->scatter = pooled.effects.tau;
  }
}

// What was believed before, which this fit did not look at, is not lost.
void TakePrior(const Scene& scene, CardConstant* constant) {
  const auto range = scene.parameters.find(RowOf(constant->kind).name);
  if (range != scene.parameters.end() && range->second.prior.is_given()) constant->Believe(range->second.prior);
}

// What the scene has of the cloth; bending by edges is of its mesh.
bool HasConstant(const Scene& scene, ParameterKind kind) {
  if (!IsOfFabric(kind) || !scene.has(kind)) return false;
  return RowOf(kind).term != ParameterTerm::kBending || scene.bending.law == BendingLaw::kPatches;
}

CardRecording DescribeRecording(const RecordedMotion& motion) {
  const Mesh& mesh = motion.scene.mesh;
  CardRecording recording;
  recording.name = motion.name;
  recording.sha256 = motion.sha256;
  recording.kind = IsTensileCurve(motion)     ? "tensile curve"
                   : motion.forces.is_empty() ? "motion"
                                              : "motion with forces";
  recording.num_nodes = mesh.num_nodes();
  for (int f = 0; f < mesh.num_faces(); ++f) {
    for (int side = 0; side < 3; ++side) recording.edge_length += RestLength(mesh, f, side) / (3.0 * mesh.num_faces());
  }
  recording.time_step = motion.scene.time_step;
  for (Eigen::Index reading = 0; reading < motion.forces.values.cols(); ++reading) {
    for (int group = 0; group < motion.forces.num_groups(); ++group) {
      const Eigen::Vector3d force = motion.forces.values.col(reading).segment<3>(3 * static_cast<Eigen::Index>(group));
      const double size = force.array().isNaN().select(0.0, force.array()).matrix().norm();
      recording.load = std::isnan(recording.load) ? size : std::max(recording.load, size);
    }
  }
  return recording;
}

}  // namespace

bool IsTensileCurve(const RecordedMotion& motion) {
  const auto is_seen_whole = [&](Eigen::Index point) {
    return (motion.positions.middleRows<3>(3 * point).array().isFinite().colwise().count() == 3).any();
  };
  if (motion.forces.is_empty() || !motion.clouds.empty()) return false;
  for (int point = 0; point < motion.num_points(); ++point) {
    if (is_seen_whole(point)) return false;
  }
  return true;
}

FabricCard CardOfFit(const FitSummary& summary, const FitChecks& checks, const std::vector<RecordedMotion>& motions,
                     const std::vector<Eigen::MatrixXd>& nodes) {
  const Scene& scene = motions.front().scene;
  const Parameters nominal = scene.nominal_parameters();
  std::map<ParameterKind, SeenRange> seen;
  FabricCard card;
  for (std::size_t r = 0; r < motions.size(); ++r) {
    card.recordings.push_back(DescribeRecording(motions[r]));
    for (const auto& [kind, range] : SeenRanges(motions[r].scene, nodes[r])) seen[kind].Extend(range);
  }
  card.program = Version() + " (git " + GitHash() + ")";
  card.membrane = scene.membrane;
  card.bend_poisson = scene.bending.poisson;
  for (const ParameterKind kind : MaterialKinds()) {
    const int index = FindFitted(summary, RowOf(kind).name);
    if (!HasConstant(scene, kind) || (index < 0 && !scene.has_term(kind))) continue;
    CardConstant constant;
    constant.kind = kind;
    constant.value = GetParameter(nominal, {kind});
    if (index >= 0) {
      TakeEstimate(summary, checks, index, &constant);
    } else {
      TakePrior(scene, &constant);
    }
    if (checks.repetitions) TakeMean(*checks.repetitions, RowOf(kind).name, &constant);
    constant.seen_from = seen[kind].from;
    constant.seen_to = seen[kind].to;
    card.constants.push_back(constant);
  }
  const bool is_calibrated = checks.held_bands && checks.held_bands->calibration;
  const double factor = is_calibrated ? checks.held_bands->calibration->factor : 1.0;
  for (const LastingForce& force : checks.missing_forces) {
    card.missing_forces.push_back({factor * force.size, force.time, force.length, factor});
  }
  return card;
}

FabricCard PooledCard(const std::vector<FabricCard>& cards, const Repetitions& repetitions) {
  FabricCard pooled = cards.front();
  pooled.recordings.clear();
  for (const FabricCard& card : cards) {
    pooled.recordings.insert(pooled.recordings.end(), card.recordings.begin(), card.recordings.end());
  }
  for (CardConstant& constant : pooled.constants) {
    TakeMean(repetitions, RowOf(constant.kind).name, &constant);
    SeenRange seen;
    for (const FabricCard& card : cards) {
      const CardConstant* other = card.Find(constant.kind);
      if (other != nullptr) seen.Extend({other->seen_from, other->seen_to});
    }
    constant.seen_from = seen.from;
    constant.seen_to = seen.to;
  }
  return pooled;
}

}  // namespace clothid

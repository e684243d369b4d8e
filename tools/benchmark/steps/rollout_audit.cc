#include "tools/benchmark/steps/rollout_audit.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <vector>

#include "sim/cloth/cloth_model.h"
#include "sim/rollout/record_reader.h"
#include "sim/rollout/simulator.h"
#include "sim/step/step_problem.h"
#include "sim/step/step_solver.h"

namespace clothid {
namespace {

constexpr double kRoundings = 8.0;  // of a position, in units of eps

double Rounding(const Eigen::VectorXd& positions) {
  return kRoundings * std::numeric_limits<double>::epsilon() * positions.lpNorm<Eigen::Infinity>();
}

// Where the pair of `features` is in `pairs`, or their end.
std::vector<PairCandidate>::iterator FindPair(const PairFeatures& features, std::vector<PairCandidate>* pairs) {
  return std::find_if(pairs->begin(), pairs->end(),
                      [&](const PairCandidate& pair) { return pair.features == features; });
}

// Gives the step of `work` the pairs that were recorded beside those that thinning accepts, and `point` their impulses
// r = d (u + gap_speed n) - F. False: one of them is none that the step could have.
bool TakePairs(const std::vector<PairContact>& recorded, const Eigen::VectorXd& velocities, StepWorkspace* work,
               StepPoint* point) {
  bool are_known = true;
  for (const PairContact& contact : recorded) {
    const PairCandidate& pair = contact.candidate;
    if (FindPair(pair.features, &work->pairs) != work->pairs.end()) {
      are_known = are_known && pair.has_friction;
      continue;
    }
    are_known = are_known && !pair.has_friction && FindPair(pair.features, &work->left_out) != work->left_out.end();
    work->pairs.push_back(pair);
  }
  std::sort(work->pairs.begin(), work->pairs.end(),
            [](const PairCandidate& a, const PairCandidate& b) { return a.features < b.features; });
  point->pairs.impulses.setZero(3, static_cast<Eigen::Index>(work->pairs.size()));
  for (const PairContact& contact : recorded) {
    const PairCandidate& pair = *FindPair(contact.candidate.features, &work->pairs);
    point->pairs.impulses.col(&pair - work->pairs.data()) =
        pair.weight * (pair.RelativeVelocity(velocities) + pair.gap_speed * pair.geometry.normal) - contact.force;
  }
  return are_known;
}

// Whether a pair comes nearer, by its frozen normal, than the law lets it.
bool IsPairTooDeep(const StepProblem& problem, const StepPoint& point, double tolerance) {
  return std::any_of(problem.pairs().begin(), problem.pairs().end(), [&](const PairCandidate& pair) {
    const double least = -pair.gap_speed - tolerance * point.scale / pair.weight;
    const double rounding = Rounding(point.positions) / problem.time_step();
    return !(pair.geometry.normal.dot(pair.RelativeVelocity(point.velocities)) >= least - rounding);
  });
}

// Whether a node of the contact set ends deeper than the law lets it.
bool IsTooDeep(const StepProblem& problem, const StepPoint& point, const StepRecord& record, double tolerance,
               const Scene& scene) {
  for (std::size_t i = 0; i < problem.candidates().size(); ++i) {
    const ContactCandidate& candidate = problem.candidates()[i];
    const SceneObstacle& obstacle = scene.obstacles[candidate.obstacle];
    const double speed_error = tolerance * point.scale / problem.weight(static_cast<int>(i));
    const double least = candidate.gap - record.time_step * (candidate.gap_speed + speed_error);
    // Where the obstacle moves, from the plane that the step has in its place.
    const double moved = record.time_step *
                         candidate.normal.dot(point.velocities.segment<3>(3 * problem.free_block(static_cast<int>(i))) -
                                              candidate.target);
    const double gap = obstacle.moves() ? candidate.gap - record.time_step * candidate.gap_speed + moved
                                        : obstacle.shape->Closest(record.positions.segment<3>(3 * candidate.node)).gap -
                                              obstacle.contact_distance;
    if (!(gap >= least - Rounding(record.positions))) return true;
  }
  return false;
}

void AuditRecord(const StepRecord& record, const SolveStart& start, const Parameters& parameters, Simulator* simulator,
                 RolloutAudit* audit) {
  const ClothModel& model = simulator->model();
  const StepProblem problem(model, parameters, start, record.times(), &simulator->step_workspace());
  const Eigen::VectorXd velocities = model.Gather(record.velocities);
  StepPoint point;
  bool are_known = true;
  if (model.scene().self_contact) {
    are_known = TakePairs(RestoreContacts(record, start.positions, {}, parameters, model).pairs, velocities,
                          &simulator->step_workspace(), &point);
  }
  problem.Evaluate(velocities, &point);
  const double tolerance = StepSolver::Tolerance(problem, model.scene().solver.step_tolerance, point);
  const double off = (point.positions - record.positions).lpNorm<Eigen::Infinity>();
  audit->inconsistent += !(off <= Rounding(record.positions)) || !are_known ||
                         NumDifferences(RecordContacts(problem.ContactsAt(point)), record.contacts) > 0;
  audit->unsolved += !(point.relative_residual <= tolerance);
  audit->worst_residual = std::max(audit->worst_residual, point.relative_residual / tolerance);
  audit->loosest_tolerance = std::max(audit->loosest_tolerance, tolerance);
  audit->too_deep +=
      IsTooDeep(problem, point, record, tolerance, model.scene()) || IsPairTooDeep(problem, point, tolerance);
}

double Penetration(const StepRecord& record, const Parameters& parameters, const ClothModel& model) {
  double deepest = 0.0;
  if (!model.has_contact()) return deepest;
  ContactCandidate candidate;
  // Of a solve that starts where this one ends.
  const SolveTimes next{record.time_step, record.time + record.time_step};
  const std::vector<ObstacleMotion> motions = ObstacleMotions(model.scene(), parameters, next);
  for (const int node : model.free_nodes()) {
    FindCandidate(model, node, record.positions, record.time_step, motions, &candidate);
    deepest = std::max(deepest, -candidate.gap);
  }
  return deepest;
}

int MissingSteps(const Rollout& rollout, int num_steps) {
  if (!rollout.ok()) return 0;
  double solved = 0.0;  // s
  for (const StepRecord& record : rollout.records) {
    if (record.stage == Stage::kOnly) solved += record.time_step;
    if (record.stage == Stage::kSecond) solved += record.time_step / kStageShare;
  }
  const int by_time = static_cast<int>(std::lround(solved / rollout.time_step));
  return num_steps - std::min(rollout.num_steps(), by_time);
}

}  // namespace

RolloutAudit AuditRollout(const Rollout& rollout, int num_steps, Simulator* simulator) {
  RolloutAudit audit;
  audit.missing_steps = MissingSteps(rollout, num_steps);
  RecordReader reader(rollout, simulator);
  for (std::size_t i = 0; i < rollout.records.size(); ++i) {
    const StepRecord& record = rollout.records[i];
    if (!record.positions.allFinite() || !record.velocities.allFinite()) {
      ++audit.not_finite;
      return audit;
    }
    AuditRecord(record, reader.start(static_cast<int>(i)), rollout.parameters, simulator, &audit);
    audit.penetration = std::max(audit.penetration, Penetration(record, rollout.parameters, simulator->model()));
  }
  audit.self_contact = AuditSelfContact(rollout, simulator);
  return audit;
}

}  // namespace clothid

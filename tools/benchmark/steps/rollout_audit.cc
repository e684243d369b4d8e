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

// Whether a pair comes nearer, by its frozen normal, than the law lets it.
bool IsPairTooDeep(const StepProblem& problem, const StepPoint& point, double tolerance) {
  const std::vector<PairCandidate>& pairs = problem.contacts().pairs();
  return std::any_of(pairs.begin(), pairs.end(), [&](const PairCandidate& pair) {
    const double least = -pair.gap_speed - tolerance * point.scale / pair.weight;
    const double rounding = Rounding(point.positions) / problem.time_step();
    return !(pair.geometry.normal.dot(pair.RelativeVelocity(point.velocities)) >= least - rounding);
  });
}

// Whether a node of the contact set ends deeper than the law lets it.
bool IsTooDeep(const StepProblem& problem, const StepPoint& point, const StepRecord& record, double tolerance,
               const Scene& scene) {
  const StepContacts& contacts = problem.contacts();
  for (std::size_t i = 0; i < contacts.candidates().size(); ++i) {
    const int index = static_cast<int>(i);
    const ContactCandidate& candidate = contacts.candidates()[i];
    const SceneObstacle& obstacle = scene.obstacles[candidate.obstacle];
    const double speed_error = tolerance * point.scale / contacts.weight(index);
    const double least = candidate.gap - record.time_step * (candidate.gap_speed + speed_error);
    // Where the obstacle moves, from the plane that the step has in its place.
    const Eigen::Vector3d velocity = point.velocities.segment<3>(3 * contacts.free_block(index));
    const double moved = record.time_step * candidate.normal.dot(velocity - candidate.target);
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
  const ContactSet recorded = RestoreContacts(record, start.positions, {}, parameters, model);
  const bool are_known = simulator->step_workspace().contacts.Restore(recorded, velocities, &point);
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

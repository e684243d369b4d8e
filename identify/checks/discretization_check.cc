#include "identify/checks/discretization_check.h"

#include <limits>
#include <string>
#include <utility>

#include "datasets/motion/refined_motion.h"
#include "identify/uncertainty/discretization_error.h"

namespace clothid {
namespace {

constexpr double kUnknown = std::numeric_limits<double>::quiet_NaN();

// The fits of one check, one after the other.
class Repeater {
 public:
  Repeater(const FitOptions& options, const FitProblem& problem, FitSummary* summary)
      : options_(options), problem_(problem), summary_(summary) {}

  std::optional<RepeatedFit> Repeat(const std::vector<RecordedMotion>& motions, const std::string& tag,
                                    bool from_bases = false) {
    if (options_.is_cancelled()) return std::nullopt;
    const RepeatedFit fit = RepeatFit(motions, options_, tag, problem_, summary_->coordinates, from_bases);
    summary_->statistics += fit.statistics;
    if (fit.status == FitStatus::kInterrupted) return std::nullopt;
    return fit;
  }

 private:
  const FitOptions& options_;
  const FitProblem& problem_;
  FitSummary* summary_;
};

std::vector<RecordedMotion> WithStep(std::vector<RecordedMotion> motions, double factor) {
  for (RecordedMotion& motion : motions) motion.scene.time_step *= factor;
  return motions;
}

std::vector<RecordedMotion> Refined(const std::vector<RecordedMotion>& motions) {
  std::vector<RecordedMotion> refined;
  for (const RecordedMotion& motion : motions) refined.push_back(RefineMotion(motion));
  return refined;
}

// The estimate of parameter i, where there is one.
double Coordinate(const std::optional<RepeatedFit>& fit, Eigen::Index i) {
  return fit && fit->has_estimate() ? fit->coordinates[i] : kUnknown;
}

// A fit at twice the step that did not converge tells no order.
double ConvergedCoordinate(const std::optional<RepeatedFit>& fit, Eigen::Index i) {
  return fit && fit->status == FitStatus::kConverged ? Coordinate(fit, i) : kUnknown;
}

void AddErrors(const DiscretizationCheck& check, const FitProblem& problem, FitSummary* summary) {
  if (!summary->uncertainty) return;
  const Eigen::VectorXd q = summary->coordinates.head(problem.num_blocks());
  std::vector<DiscretizationError> step, mesh;
  for (Eigen::Index i = 0; i < q.size(); ++i) {
    if (check.half_step && check.half_step->has_estimate()) {
      step.push_back(ErrorOfStep(q[i], Coordinate(check.half_step, i), ConvergedCoordinate(check.double_step, i)));
    }
    if (check.fine_mesh) mesh.push_back(ErrorOfMesh(q[i], Coordinate(check.fine_mesh, i)));
  }
  AddDiscretizationErrors(problem.blocks(), q, step, mesh, &*summary->uncertainty);
}

}  // namespace

DiscretizationCheck CheckDiscretization(const std::vector<RecordedMotion>& motions, const FitOptions& options,
                                        const DiscretizationParts& parts, const FitProblem& problem,
                                        FitSummary* summary, DiscretizationCheck known) {
  DiscretizationCheck check = std::move(known);
  Repeater repeater(options, problem, summary);
  for (std::optional<RepeatedFit>* fit : {&check.half_step, &check.double_step}) {
    if (!*fit || !(*fit)->has_estimate()) continue;
    (*fit)->changes = ChangesBetween(problem, summary->coordinates.head(problem.num_blocks()), (*fit)->coordinates);
  }
  if (parts.step && !check.half_step) {
    check.half_step = repeater.Repeat(WithStep(motions, 0.5), "half_step");
    check.double_step = repeater.Repeat(WithStep(motions, 2.0), "double_step");
  }
  if (parts.mesh) check.fine_mesh = repeater.Repeat(Refined(motions), "fine_mesh", /*from_bases=*/true);
  AddErrors(check, problem, summary);
  return check;
}

}  // namespace clothid

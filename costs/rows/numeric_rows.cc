#include "costs/rows/numeric_rows.h"

#include "costs/rows/compressed_jacobian.h"
#include "costs/rows/evaluated_residuals.h"

namespace clothid {

ResidualRows NumericRows(const RolloutEvaluation& evaluation, const std::vector<int>& active, int num_rows,
                         const RolloutCostOptions& options, const RecordingModel& model, const RunRollout& run) {
  const Observation& observation = model.observation();
  const double step = ForwardDifferenceStep(model.SolverAt(evaluation.precision));
  Eigen::MatrixXd jacobian(observation.num_residuals(), static_cast<Eigen::Index>(active.size()));
  for (Eigen::Index i = 0; i < jacobian.cols(); ++i) {
    Eigen::VectorXd shifted = evaluation.coordinates;
    shifted[active[i]] += step;
    Eigen::MatrixXd predicted;
    ForceTrack forces;
    run(shifted, static_cast<int>(jacobian.cols() - 1 - i), &predicted, &forces);
    jacobian.col(i) = ResidualChange(observation, evaluation, predicted, forces.predicted) / step;
  }
  Eigen::VectorXd weights;
  const Eigen::VectorXd weighted = WeightedResiduals(options.loss, observation, evaluation, &weights);
  CompressedJacobian compressed(static_cast<int>(active.size()));
  compressed.Add(weights.asDiagonal() * jacobian, weighted);
  return CompressedRows(active, num_rows, &compressed);
}

}  // namespace clothid

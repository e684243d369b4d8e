#include "costs/rows/forward_rows.h"

#include <stdexcept>
#include <utility>

#include "costs/rows/compressed_jacobian.h"
#include "sim/base/phase_seconds.h"

namespace clothid {
namespace {

// Takes the frames of a sweep one by one.
class FrameCollector {
 public:
  FrameCollector(const Observation& observation, const RobustLoss& loss, Eigen::Index num_columns, bool keeps_jacobian,
                 ForwardRows* result)
      : observation_(observation), loss_(loss), compressed_(static_cast<int>(num_columns)), result_(result) {
    result_->predicted.resize(observation.num_predicted(), observation.num_frames());
    result_->forces.resize(3 * observation.forces().num_groups(), observation.forces().num_readings());
    frame_scores_.setZero(num_columns, observation.num_frames());
    if (keeps_jacobian) result_->jacobian.resize(observation.num_residuals(), num_columns);
  }

  void AddFrame(int frame, const Eigen::VectorXd& points, const Eigen::VectorXd& residuals,
                const Eigen::MatrixXd& jacobian) {
    const int first_row = observation_.first_row(frame);
    const int reading = frame - observation_.num_frames();
    (reading < 0 ? result_->predicted.col(frame) : result_->forces.col(reading)) = points;
    Eigen::VectorXd weights;
    LossWeights(loss_, observation_, first_row, residuals, &weights);
    const Eigen::VectorXd weighted = residuals.cwiseProduct(weights);
    compressed_.Add(weights.asDiagonal() * jacobian, weighted);
    // Forces count with the frame that is nearest in time: what errors share there is in one score.
    const int score = reading < 0 ? frame : observation_.forces().nearest_frame(reading);
    frame_scores_.col(score) += jacobian.transpose() * weights.cwiseProduct(weighted);
    if (result_->jacobian.size() > 0) result_->jacobian.middleRows(first_row, jacobian.rows()) = jacobian;
  }

  void Finish(const SweepColumns& columns, int num_rows) {
    result_->rows = CompressedRows(columns.blocks, num_rows, &compressed_);
    result_->rows.along = DigestOf(columns.combinations);
    result_->rows.frame_scores = std::move(frame_scores_);
  }

 private:
  const Observation& observation_;
  const RobustLoss& loss_;
  CompressedJacobian compressed_;
  Eigen::MatrixXd frame_scores_;
  ForwardRows* result_;
};

}  // namespace

ForwardRows SweepForward(const Eigen::VectorXd& coordinates, const SweepColumns& columns, const PassOptions& pass,
                         const RobustLoss& loss, int num_rows, bool keeps_jacobian, RecordingModel* model,
                         CostStatistics* statistics, const Rollout* rollout) {
  const ScopedTimer timer(&statistics->derivative_seconds);
  const auto num_columns = static_cast<Eigen::Index>(columns.blocks.size()) + columns.combinations.cols();
  ForwardRows result;
  FrameCollector collector(model->observation(), loss, num_columns, keeps_jacobian, &result);
  const auto add_frame = [&](int frame, const Eigen::VectorXd& points, const Eigen::VectorXd& residuals,
                             const Eigen::MatrixXd& jacobian) {
    collector.AddFrame(frame, points, residuals, jacobian);
  };
  ++statistics->sweeps;
  if (rollout != nullptr) {
    model->PushForward(*rollout, coordinates, columns, add_frame, pass.precision, pass.passes_left);
  } else {
    ++statistics->rollouts;
    const SensitivityResult swept = model->PushForward(coordinates, columns, add_frame, pass);
    statistics->counts += swept.counts;
    if (swept.failure) throw std::runtime_error(swept.failure->ToString());
    result.counts = swept.counts;
  }
  collector.Finish(columns, num_rows);
  return result;
}

}  // namespace clothid

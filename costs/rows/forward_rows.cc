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
  FrameCollector(const Observation& observation, const RobustLoss& loss, const std::vector<int>& active,
                 bool keeps_jacobian, ForwardRows* result)
      : observation_(observation), loss_(loss), compressed_(static_cast<int>(active.size())), result_(result) {
    const Eigen::Index num_active = static_cast<Eigen::Index>(active.size());
    result_->predicted.resize(observation.num_predicted(), observation.num_frames());
    result_->forces.resize(3 * observation.forces().num_groups(), observation.forces().num_readings());
    frame_scores_.setZero(num_active, observation.num_frames());
    if (keeps_jacobian) result_->jacobian.resize(observation.num_residuals(), num_active);
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

  void Finish(const std::vector<int>& active, int num_rows) {
    result_->rows = CompressedRows(active, num_rows, &compressed_);
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

ForwardRows SweepForward(const Eigen::VectorXd& coordinates, const std::vector<int>& active, const PassOptions& pass,
                         const RobustLoss& loss, int num_rows, bool keeps_jacobian, RecordingModel* model,
                         CostStatistics* statistics, const Eigen::MatrixXd* follow) {
  const ScopedTimer timer(&statistics->derivative_seconds);
  ForwardRows result;
  FrameCollector collector(model->observation(), loss, active, keeps_jacobian, &result);
  const auto add_frame = [&](int frame, const Eigen::VectorXd& points, const Eigen::VectorXd& residuals,
                             const Eigen::MatrixXd& jacobian) {
    collector.AddFrame(frame, points, residuals, jacobian);
  };
  ++statistics->rollouts;
  ++statistics->sweeps;
  const SensitivityResult swept = model->PushForward(coordinates, active, add_frame, pass, follow);
  statistics->counts += swept.counts;
  if (swept.failure) throw std::runtime_error(swept.failure->ToString());
  result.counts = swept.counts;
  collector.Finish(active, num_rows);
  return result;
}

}  // namespace clothid

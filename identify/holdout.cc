#include "identify/holdout.h"

#include <limits>

#include "costs/recording_model.h"
#include "identify/problem.h"

namespace clothid {
namespace {

double RmseAt(const Eigen::VectorXd& coordinates, RecordingModel* model, std::string* failure) {
  const Rollout rollout = model->Simulate(coordinates, nullptr);
  if (!rollout.ok()) {
    *failure = model->name() + ": " + rollout.failure->ToString();
    return std::numeric_limits<double>::quiet_NaN();
  }
  return model->observation().Compare(model->observation().Predict(rollout)).rmse();
}

}  // namespace

Holdout EvaluateHoldout(const RecordedMotion& motion, const std::vector<ParameterBlock>& blocks,
                        const Eigen::VectorXd& values) {
  std::vector<ParameterBlock> own;
  std::vector<double> start, estimate;
  for (std::size_t i = 0; i < blocks.size(); ++i) {
    if (!HasParameter(motion.scene, blocks[i].name)) continue;
    own.push_back(blocks[i]);
    start.push_back(blocks[i].ToCoordinate(blocks[i].start));
    estimate.push_back(blocks[i].ToCoordinate(values[i]));
  }
  const Eigen::Index size = static_cast<Eigen::Index>(own.size());
  RecordingModel model(motion, own);
  Holdout holdout;
  holdout.nominal_rmse = RmseAt(Eigen::Map<Eigen::VectorXd>(start.data(), size), &model, &holdout.failure);
  holdout.rmse = RmseAt(Eigen::Map<Eigen::VectorXd>(estimate.data(), size), &model, &holdout.failure);
  return holdout;
}

}  // namespace clothid

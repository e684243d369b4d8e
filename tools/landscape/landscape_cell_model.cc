#include "tools/landscape/landscape_cell_model.h"

#include <algorithm>
#include <cmath>
#include <stdexcept>
#include <vector>

#include "costs/prediction/prediction_cost.h"
#include "costs/prediction/robust_loss.h"
#include "costs/start/unknown_start.h"
#include "sim/base/error.h"
#include "sim/base/phase_seconds.h"

namespace clothid {
namespace {

// A value is its own coordinate, so that cells and truths are simulated at exactly the numbers that are written down.
ParameterBlock MakeBlock(const std::string& name, double start, const RecordedMotion& motion) {
  ParameterBlock block;
  block.name = name;
  block.id = ParseParameter(name, motion);
  block.start = block.lower_bound = block.upper_bound = start;
  return block;
}

// What is held, then both axes. An axis starts at its largest value: the scene then has the terms that it asks for.
std::vector<ParameterBlock> MakeBlocks(const LandscapePlan& plan, const std::map<std::string, double>& held,
                                       const RecordedMotion& motion) {
  std::vector<ParameterBlock> blocks;
  for (const auto& [name, value] : held) blocks.push_back(MakeBlock(name, value, motion));
  double x = 0.0, y = 0.0;
  for (const LandscapeWindow& window : plan.windows) {
    x = std::max(x, window.x.upper);
    y = std::max(y, window.y.upper);
  }
  blocks.push_back(MakeBlock(plan.windows.front().x.parameter, x, motion));
  blocks.push_back(MakeBlock(plan.windows.front().y.parameter, y, motion));
  return blocks;
}

}  // namespace

LandscapeCellModel::LandscapeCellModel(const RecordedMotion& motion, const LandscapePlan& plan,
                                       const std::map<std::string, double>& held, const ModelError& model_error,
                                       const Assimilation& assimilation)
    : model_(motion, MakeBlocks(plan, held, motion)) {
  model_.SetModelError(model_error);
  const std::string reason = assimilation.is_on() ? model_.WhyNotAssimilated() : std::string();
  if (!reason.empty()) throw Error(ErrorKind::kUsage, "--assimilate: " + model_.name() + " " + reason);
  model_.Assimilate(assimilation, RobustLoss());
}

Eigen::VectorXd LandscapeCellModel::Coordinates(double x, double y) const {
  Eigen::VectorXd coordinates(model_.num_blocks());
  for (int i = 0; i < model_.num_blocks() - 2; ++i) coordinates[i] = model_.blocks()[i].start;
  coordinates.tail(2) << x, y;
  return coordinates;
}

double LandscapeCellModel::StartPrior() const {
  const UnknownStart* const start = model_.unknown_start();
  return start == nullptr ? 0.0 : start->PriorAt(Eigen::VectorXd::Zero(start->size()));
}

Rollout LandscapeCellModel::Predict(double x, double y, const std::atomic<bool>* cancel, Eigen::MatrixXd* predicted,
                                    ForceTrack* forces) {
  return model_.Simulate(Coordinates(x, y), {Precision::kFull, cancel, /*passes_left=*/0}, storage_, predicted,
                         /*velocities=*/nullptr, forces);
}

void LandscapeCellModel::MoveCloudsTo(const Eigen::MatrixXd& predicted, RecordedMotion* motion) const {
  const Eigen::Index num_rows = 3 * model_.observation().num_nodes();
  for (std::size_t i = 0; i < motion->clouds.size(); ++i) {
    const Eigen::VectorXd nodes = predicted.col(static_cast<Eigen::Index>(i)).tail(num_rows);
    const Eigen::Matrix3Xd closest = model_.observation().clouds().ClosestPoints(static_cast<int>(i), nodes);
    motion->clouds[i] = closest.leftCols(motion->clouds[i].cols());
  }
}

void LandscapeCellModel::Evaluate(const LandscapeWindow& window, double x, double y, bool has_gradients,
                                  const std::atomic<bool>* cancel, LandscapeCell* cell) {
  const ScopedTimer timer(&cell->seconds);
  try {
    Eigen::MatrixXd predicted;
    ForceTrack forces;
    const Rollout rollout = Predict(x, y, cancel, &predicted, &forces);
    cell->counts = rollout.counts;
    if (!rollout.ok()) throw std::runtime_error(rollout.failure->ToString());
    const PredictionCost cost = CostOfPrediction(RobustLoss(), model_.observation(), predicted, forces.predicted);
    if (!std::isfinite(cost.value)) throw std::runtime_error("the cost is not finite");
    if (has_gradients) PullBackCost(window, rollout, predicted, forces, cost.Gradient(), Coordinates(x, y), cell);
    cell->cost = cost.value + StartPrior();
  } catch (const std::runtime_error& error) {
    cell->failure = error.what();
  }
}

void LandscapeCellModel::PullBackCost(const LandscapeWindow& window, const Rollout& rollout,
                                      const Eigen::MatrixXd& predicted, const ForceTrack& forces,
                                      const Eigen::VectorXd& cost_gradient, const Eigen::VectorXd& coordinates,
                                      LandscapeCell* cell) {
  const int x = model_.num_blocks() - 2, y = x + 1;
  const Eigen::VectorXd gradient = model_.PullBack(rollout, predicted, /*velocities=*/{}, coordinates, {x, y},
                                                   cost_gradient, {}, Precision::kFull, &forces);
  if (!gradient.allFinite()) throw std::runtime_error("the adjoint sweep gave a gradient that is not finite");
  // d/d log value = value d/d value.
  cell->gradient_x = gradient[0] * (window.x.scale == ParameterScale::kLog ? coordinates[x] : 1.0);
  cell->gradient_y = gradient[1] * (window.y.scale == ParameterScale::kLog ? coordinates[y] : 1.0);
}

}  // namespace clothid

#include "costs/full_residual_cost.h"

#include <Eigen/Core>
#include <exception>
#include <stdexcept>
#include <utility>

#include "costs/prediction/recording_model.h"

namespace clothid {

struct FullResidualCost::State {
  State(const RecordedMotion& motion, std::vector<ParameterBlock> blocks) : model(motion, std::move(blocks)) {}

  RecordingModel model;
  std::string last_failure;
};

FullResidualCost::FullResidualCost(const RecordedMotion& motion, std::vector<ParameterBlock> blocks)
    : state_(std::make_unique<State>(motion, std::move(blocks))) {
  for (int i = 0; i < state_->model.num_blocks(); ++i) mutable_parameter_block_sizes()->push_back(1);
  set_num_residuals(state_->model.observation().num_residuals());
}

FullResidualCost::~FullResidualCost() = default;

bool FullResidualCost::Evaluate(double const* const* parameters, double* residuals, double** jacobians) const {
  Eigen::VectorXd coordinates(state_->model.num_blocks());
  std::vector<int> active;
  for (int i = 0; i < state_->model.num_blocks(); ++i) {
    coordinates[i] = parameters[i][0];
    if (jacobians != nullptr && jacobians[i] != nullptr) active.push_back(i);
  }
  const auto store_frame = [&](int frame, const Eigen::VectorXd&, const Eigen::VectorXd& e, const Eigen::MatrixXd& j) {
    const int first = state_->model.observation().first_row(frame);
    Eigen::Map<Eigen::VectorXd>(residuals + first, e.size()) = e;
    for (std::size_t i = 0; i < active.size(); ++i) {
      Eigen::Map<Eigen::VectorXd>(jacobians[active[i]] + first, e.size()) = j.col(i);
    }
  };
  try {
    const SensitivityResult result = state_->model.PushForward(coordinates, {active, {}}, store_frame, {});
    if (result.failure) throw std::runtime_error(result.failure->ToString());
  } catch (const std::exception& error) {
    state_->last_failure = state_->model.name() + ": " + error.what();
    return false;
  }
  state_->last_failure.clear();
  return true;
}

const std::string& FullResidualCost::last_failure() const { return state_->last_failure; }

}  // namespace clothid

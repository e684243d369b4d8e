#include "costs/prediction/force_prediction.h"

#include <algorithm>
#include <utility>

namespace clothid {
namespace {

// Whose forces of pairs count in that after `step` steps.
int PairForceStep(int step) { return std::max(step, 1); }

}  // namespace

ForcePrediction::ForcePrediction(const ForceObservation* observation, const ClothModel& model,
                                 const Parameters& parameters, int num_steps, Eigen::VectorXd bias,
                                 const std::vector<ParameterId>& sizes)
    : observation_(observation),
      forces_(model, parameters, num_steps, observation->groups(), sizes),
      bias_(std::move(bias)),
      is_needed_(static_cast<std::size_t>(num_steps) + 1, false) {
  for (const FrameStencil& stencil : observation->stencils()) {
    for (int step = stencil.first_step; step <= stencil.last_step(); ++step) is_needed_[step] = true;
  }
}

Eigen::MatrixXd ForcePrediction::At(const Eigen::MatrixXd& states, const Eigen::MatrixXd& pair_forces) const {
  Eigen::MatrixXd after(bias_.size(), states.cols());
  for (int step = 0; step < states.cols(); ++step) {
    if (!is_needed(step)) continue;
    after.col(step) = forces_.At(step, forces_.StatesAt(step, states));
    if (pair_forces.size() > 0) after.col(step) -= forces_.OverGroups(pair_forces.col(PairForceStep(step)));
  }
  Eigen::MatrixXd predicted(bias_.size(), observation_->num_readings());
  for (int i = 0; i < observation_->num_readings(); ++i) {
    const FrameStencil& stencil = observation_->stencils()[i];
    predicted.col(i) = bias_;
    for (int step = stencil.first_step; step <= stencil.last_step(); ++step) {
      predicted.col(i) += stencil.weight(step) * after.col(step);
    }
  }
  return predicted;
}

ForceSampler::ForceSampler(const ForcePrediction* prediction, std::vector<ParameterId> parameters, Visitor visitor,
                           Eigen::MatrixXd fields)
    : prediction_(prediction),
      parameters_(std::move(parameters)),
      visitor_(std::move(visitor)),
      fields_(std::move(fields)) {}

void ForceSampler::AddPairForces(int step, const Eigen::MatrixXd& forces) {
  pair_forces_[static_cast<std::size_t>(step % 3)] = prediction_->forces().OverGroups(forces);
}

void ForceSampler::AddStep(int step, const Eigen::Ref<const Eigen::MatrixXd>& state) {
  const HandleForces& forces = prediction_->forces();
  kept_[static_cast<std::size_t>(step % 3)] = forces.Gather(state);
  for (; next_step_ <= forces.num_steps() && forces.Window(next_step_).last_step() == step; ++next_step_) {
    if (!prediction_->is_needed(next_step_)) continue;
    after_[static_cast<std::size_t>(next_step_ % 2)] = ForceAfter(next_step_);
    VisitReadings(next_step_);
  }
}

Eigen::MatrixXd ForceSampler::ForceAfter(int step) const {
  const HandleForces& forces = prediction_->forces();
  const int first = forces.Window(step).first_step;
  HandleForces::States states;
  for (int k = 0; k < 3; ++k) states[static_cast<std::size_t>(k)] = kept_[static_cast<std::size_t>((first + k) % 3)];
  const Eigen::Index num_changes = states[0].cols() - 1;
  Eigen::MatrixXd after = Eigen::MatrixXd::Zero(prediction_->bias().size(), 1 + num_changes);
  after.col(0) = forces.At(step, states);
  const Eigen::MatrixXd& pair_forces = pair_forces_[static_cast<std::size_t>(PairForceStep(step) % 3)];
  if (pair_forces.size() > 0) after -= pair_forces;
  if (num_changes == 0) return after;
  const auto jacobian = forces.Jacobian(step, states);
  for (std::size_t k = 0; k < 3; ++k) {
    after.rightCols(num_changes).noalias() += jacobian[k] * states[k].rightCols(num_changes);
  }
  for (std::size_t p = 0; p < parameters_.size(); ++p) {
    after.col(1 + static_cast<Eigen::Index>(p)) += forces.ParameterDerivative(parameters_[p], step, states);
  }
  if (fields_.cols() > 0) after.rightCols(fields_.cols()) += forces.FieldDerivative(step, states) * fields_;
  return after;
}

void ForceSampler::VisitReadings(int step) {
  const ForceObservation& observation = prediction_->observation();
  for (; next_reading_ < observation.num_readings(); ++next_reading_) {
    const FrameStencil& stencil = observation.stencils()[next_reading_];
    if (stencil.last_step() > step) return;
    Eigen::MatrixXd sum = Eigen::MatrixXd::Zero(prediction_->bias().size(), kept_[0].cols());
    sum.col(0) = prediction_->bias();
    for (int own = stencil.first_step; own <= stencil.last_step(); ++own) {
      sum += stencil.weight(own) * after_[static_cast<std::size_t>(own % 2)];
    }
    visitor_(next_reading_, sum);
  }
}

ForceSeeds::ForceSeeds(const ForcePrediction* prediction, const Eigen::MatrixXd* states, Eigen::MatrixXd seeds,
                       std::vector<ParameterId> parameters)
    : prediction_(prediction),
      states_(states),
      seeds_(std::move(seeds)),
      parameters_(std::move(parameters)),
      parameter_gradient_(Eigen::MatrixXd::Zero(static_cast<Eigen::Index>(parameters_.size()), seeds_.cols())),
      next_step_(prediction->forces().num_steps()) {
  pending_.fill(Eigen::MatrixXd::Zero(states->rows(), seeds_.cols()));
  pending_forces_.fill(Eigen::MatrixXd::Zero(prediction->bias().size(), seeds_.cols()));
}

Eigen::MatrixXd ForceSeeds::SeedsAfter(int step) const {
  const ForceObservation& observation = prediction_->observation();
  Eigen::MatrixXd sum = Eigen::MatrixXd::Zero(prediction_->bias().size(), seeds_.cols());
  const auto [first, end] = FramesAt(step, observation.stencils());
  for (int reading = first; reading < end; ++reading) {
    sum += observation.stencils()[reading].weight(step) * observation.PullBack(reading, seeds_);
  }
  return sum;
}

void ForceSeeds::AddTo(int step, Eigen::MatrixXd* gradient) {
  const HandleForces& forces = prediction_->forces();
  for (; next_step_ >= 0 && forces.Window(next_step_).last_step() == step; --next_step_) {
    if (!prediction_->is_needed(next_step_)) continue;
    const HandleForces::States states = forces.StatesAt(next_step_, *states_);
    const Eigen::MatrixXd seeds = SeedsAfter(next_step_);
    pending_forces_[static_cast<std::size_t>(PairForceStep(next_step_) % 3)] += seeds;
    const auto jacobian = forces.Jacobian(next_step_, states);
    const int first = forces.Window(next_step_).first_step;
    for (int k = 0; k < 3; ++k) {
      pending_[static_cast<std::size_t>((first + k) % 3)].noalias() +=
          jacobian[static_cast<std::size_t>(k)].transpose() * seeds;
    }
    for (std::size_t p = 0; p < parameters_.size(); ++p) {
      parameter_gradient_.row(static_cast<Eigen::Index>(p)) +=
          forces.ParameterDerivative(parameters_[p], next_step_, states).transpose() * seeds;
    }
    const Eigen::MatrixXd by_fields = forces.FieldDerivative(next_step_, states);
    if (by_fields.cols() == 0) continue;
    if (field_gradient_.size() == 0) field_gradient_.setZero(by_fields.cols(), seeds.cols());
    field_gradient_.noalias() += by_fields.transpose() * seeds;
  }
  Eigen::MatrixXd& own = pending_[static_cast<std::size_t>(step % 3)];
  for (std::size_t i = 0; i < forces.nodes().size(); ++i) {
    gradient->middleRows<3>(3 * forces.nodes()[i]) += own.middleRows<3>(3 * static_cast<Eigen::Index>(i));
  }
  own.setZero();
  Eigen::MatrixXd& own_forces = pending_forces_[static_cast<std::size_t>(step % 3)];
  by_forces_ = own_forces;
  own_forces.setZero();
}

void ForceSeeds::AddPairForcesTo(Eigen::MatrixXd* gradient) const {
  *gradient -= prediction_->forces().OverGroupsTransposed(by_forces_);
}

}  // namespace clothid

// The forces at handles that a recording has measured, as a rollout predicts them, with their derivatives:
//   predicted(t_i) = sum_j w_ij R_j + bias
// with R_j the forces after step j (sim/rollout/handle_forces.h), linear in time between steps, and the bias of the
// sensors (costs/prediction/alignment.h). R_j depends on three successive states, so both sweeps meet it through the
// positions that they differentiate anyway; what it owes to the parameters and fields themselves is added here. Where
// the cloth touches itself, the forces F of pairs upon handles (sim/rollout/pair_forces.h) are taken off, which the
// sweeps differentiate as well: of step j, and of step 1 at the start.
#ifndef CLOTHID_COSTS_PREDICTION_FORCE_PREDICTION_H_
#define CLOTHID_COSTS_PREDICTION_FORCE_PREDICTION_H_

#include <Eigen/Core>
#include <array>
#include <functional>
#include <vector>

#include "datasets/observation/force_observation.h"
#include "sim/cloth/cloth_model.h"
#include "sim/rollout/handle_forces.h"
#include "sim/scene/parameters.h"

namespace clothid {

// At one value of the parameters.
class ForcePrediction {
 public:
  // `observation`, which has forces, and `model` must outlive it; the fields of `parameters` must be in the model.
  // `bias` [3G] N. `sizes`: those that it is differentiated by.
  ForcePrediction(const ForceObservation* observation, const ClothModel& model, const Parameters& parameters,
                  int num_steps, Eigen::VectorXd bias, const std::vector<ParameterId>& sizes);

  const ForceObservation& observation() const { return *observation_; }
  const HandleForces& forces() const { return forces_; }
  const Eigen::VectorXd& bias() const { return bias_; }
  // Whether a reading depends on the force after `step` steps.
  bool is_needed(int step) const { return is_needed_[static_cast<std::size_t>(step)]; }

  // [3G x readings] N, from the positions of the nodes near handles after every step [3n x (steps + 1)] m and F [3H x
  // (steps + 1)] N, empty where the cloth does not touch itself.
  Eigen::MatrixXd At(const Eigen::MatrixXd& states, const Eigen::MatrixXd& pair_forces) const;

 private:
  const ForceObservation* observation_;
  HandleForces forces_;
  Eigen::VectorXd bias_;
  std::vector<bool> is_needed_;  // [steps + 1]
};

// Forward: the readings of a sweep from states that arrive step by step.
class ForceSampler {
 public:
  // Called once per reading, in order: its force [3G] and the derivatives along the columns of the sweep [3G x (1 +
  // c)].
  using Visitor = std::function<void(int reading, const Eigen::MatrixXd& forces)>;

  // `parameters`: what the first of the columns belong to; the last ones are along changes of fields, `fields` [K F x
  // q] as of `SensitivityDirections`. `prediction` must outlive the sampler.
  ForceSampler(const ForcePrediction* prediction, std::vector<ParameterId> parameters, Visitor visitor,
               Eigen::MatrixXd fields = {});
  // `state` [3N x (1 + c)] after `step` steps, positions and changes of them; steps 0, 1, 2, .. in order.
  void AddStep(int step, const Eigen::Ref<const Eigen::MatrixXd>& state);
  // F and changes of it [3H x (1 + c)] after `step` steps, before AddStep of it.
  void AddPairForces(int step, const Eigen::MatrixXd& forces);

 private:
  Eigen::MatrixXd ForceAfter(int step) const;  // [3G x (1 + c)]
  void VisitReadings(int step);

  const ForcePrediction* prediction_;
  std::vector<ParameterId> parameters_;
  Visitor visitor_;
  Eigen::MatrixXd fields_;
  HandleForces::States kept_;             // the latest states, that of step s at place s modulo 3
  HandleForces::States pair_forces_;      // likewise F over the groups; empty: none
  std::array<Eigen::MatrixXd, 2> after_;  // the latest forces, likewise modulo 2
  int next_step_ = 0, next_reading_ = 0;
};

// Reverse: C = sum of seeds . residuals, column by column.
class ForceSeeds {
 public:
  // `states`: those positions. `seeds` [rows of forces x s]. All must outlive it.
  ForceSeeds(const ForcePrediction* prediction, const Eigen::MatrixXd* states, Eigen::MatrixXd seeds,
             std::vector<ParameterId> parameters);

  // Adds dC/dx after `step` steps to `gradient` [3N x s]; steps from the last to the first.
  void AddTo(int step, Eigen::MatrixXd* gradient);
  // Adds dC/dF after the step of the last AddTo to `gradient` [3H x s].
  void AddPairForcesTo(Eigen::MatrixXd* gradient) const;
  // dC/d(parameters) at fixed positions [p x s], after step 0.
  const Eigen::MatrixXd& parameter_gradient() const { return parameter_gradient_; }
  // And by fields [K F x s]; empty where the prediction has none.
  const Eigen::MatrixXd& field_gradient() const { return field_gradient_; }

 private:
  // dC/dR of the force after `step` steps [3G x s].
  Eigen::MatrixXd SeedsAfter(int step) const;

  const ForcePrediction* prediction_;
  const Eigen::MatrixXd* states_;
  Eigen::MatrixXd seeds_;
  std::vector<ParameterId> parameters_;
  Eigen::MatrixXd parameter_gradient_, field_gradient_;
  int next_step_;
  std::array<Eigen::MatrixXd, 3> pending_;         // of states [3n x s], that of step s at place s modulo 3
  std::array<Eigen::MatrixXd, 3> pending_forces_;  // likewise of R [3G x s], whose F is that of step s
  Eigen::MatrixXd by_forces_;                      // that of the last step
};

}  // namespace clothid

#endif  // CLOTHID_COSTS_PREDICTION_FORCE_PREDICTION_H_

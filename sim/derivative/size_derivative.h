// What a solve owes to the size of the cloth at rest (sim/rollout/sized_scene.h).
//
// dg/ds at fixed x and v, with contact frozen as in all derivatives, is a difference in models of other sizes
// (sim/rollout/sized_models.h). It is made of forces alone, no rollout and no solve: one column of the sweeps, the same
// in both of them.
#ifndef CLOTHID_SIM_DERIVATIVE_SIZE_DERIVATIVE_H_
#define CLOTHID_SIM_DERIVATIVE_SIZE_DERIVATIVE_H_

#include <Eigen/Core>
#include <array>
#include <vector>

#include "sim/cloth/cloth_model.h"
#include "sim/rollout/simulator.h"
#include "sim/rollout/sized_models.h"
#include "sim/rollout/step_record.h"
#include "sim/scene/parameters.h"
#include "sim/step/stage.h"

namespace clothid {

class SizeDerivative {
 public:
  // For the sizes among `ids`; where there are none, nothing is built. The model of `simulator` has to be that of the
  // `parameters`, which must outlive the object.
  SizeDerivative(const Parameters& parameters, const std::vector<ParameterId>& ids, const Simulator& simulator);

  // How many models it has built: four for each size.
  int num_models() const { return static_cast<int>(models_.size()); }

  // dg/ds [3N] of the solve that `record` ends, from `start`; rows of handles do not count. Throws `std::logic_error`
  // for a size that was not among the `ids`, as does the other one.
  Eigen::VectorXd MomentumDerivative(ParameterId id, const StepRecord& record, const SolveStart& start) const;
  // dM/ds of every node [N] kg.
  const Eigen::VectorXd& MassSlopes(ParameterId id) const;

 private:
  const Parameters& parameters_;
  std::vector<SizedModel> models_;
  std::array<Eigen::VectorXd, 2> mass_slopes_;  // of size.x and size.y; empty unless asked for
};

}  // namespace clothid

#endif  // CLOTHID_SIM_DERIVATIVE_SIZE_DERIVATIVE_H_

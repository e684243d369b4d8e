// What a solve owes to the size of the cloth at rest (sim/rollout/sized_scene.h).
//
// The rest shape is in every term of g (sim/step/step_problem.h), and in none of them so that its derivative would be
// short. So dg/ds at fixed x and v, with contact frozen as in all derivatives, is a difference of g in models of four
// sizes near by, s (1 + k e), k = -2, -1, 1, 2:
//   dg/ds = (g_-2 - 8 g_-1 + 8 g_1 - g_2)/(12 e s),   e = 5e-4
// which leaves e^4/30 times the fifth derivative by log(s), some 1e-11 of dg/ds, and as much of rounding. It is made of
// forces alone, no rollout and no solve: one column of the sweeps, the same in both of them.
#ifndef CLOTHID_SIM_DERIVATIVE_SIZE_DERIVATIVE_H_
#define CLOTHID_SIM_DERIVATIVE_SIZE_DERIVATIVE_H_

#include <Eigen/Core>
#include <array>
#include <memory>
#include <vector>

#include "sim/cloth/cloth_model.h"
#include "sim/rollout/simulator.h"
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
  int num_models() const { return static_cast<int>(models_[0].size() + models_[1].size()); }

  // dg/ds [3N] of the solve that `record` ends, from `start`; rows of handles do not count. Throws `std::logic_error`
  // for a size that was not among the `ids`, as does the other one.
  Eigen::VectorXd MomentumDerivative(ParameterKind kind, const StepRecord& record, const SolveStart& start) const;
  // dM/ds of every node [N] kg.
  const Eigen::VectorXd& MassSlopes(ParameterKind kind) const;

 private:
  struct SizedModel {
    double weight;  // of the difference
    std::unique_ptr<const Scene> scene;
    std::unique_ptr<const ClothModel> model;
  };
  const std::vector<SizedModel>& ModelsOf(ParameterKind kind) const;

  const Parameters& parameters_;
  std::array<std::vector<SizedModel>, 2> models_;  // of size.x and size.y
  std::array<Eigen::VectorXd, 2> mass_slopes_;
};

}  // namespace clothid

#endif  // CLOTHID_SIM_DERIVATIVE_SIZE_DERIVATIVE_H_

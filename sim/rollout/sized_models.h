// Differences by the size of the cloth at rest (sim/rollout/sized_scene.h).
//
// The rest shape is in every force, and in none of them so that its derivative would be short. So that of a quantity q
// of a model by a size s is a difference of q in models of four sizes near by, s (1 + k e), k = -2, -1, 1, 2:
//   dq/ds = (q_-2 - 8 q_-1 + 8 q_1 - q_2)/(12 e s),   e = 5e-4
// which leaves e^4/30 times the fifth derivative by log(s), some 1e-11 of dq/ds, and as much of rounding.
#ifndef CLOTHID_SIM_ROLLOUT_SIZED_MODELS_H_
#define CLOTHID_SIM_ROLLOUT_SIZED_MODELS_H_

#include <memory>
#include <vector>

#include "sim/cloth/cloth_model.h"
#include "sim/scene/parameters.h"

namespace clothid {

// One of four.
struct SizedModel {
  ParameterId id;  // of the size
  double weight;   // of the difference
  std::unique_ptr<const Scene> scene;
  std::unique_ptr<const ClothModel> model;
};

// Of each of the sizes among `ids`, once; nothing is built where there are none. `model` has the fields, the pieces and
// the size of the parameters.
std::vector<SizedModel> SizedModels(const Parameters& parameters, const std::vector<ParameterId>& ids,
                                    const ClothModel& model);

}  // namespace clothid

#endif  // CLOTHID_SIM_ROLLOUT_SIZED_MODELS_H_

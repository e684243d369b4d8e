#include "sim/rollout/sized_models.h"

#include <algorithm>
#include <array>
#include <cstddef>
#include <utility>

#include "sim/rollout/sized_scene.h"

namespace clothid {
namespace {

constexpr double kShareOfSize = 5e-4;                               // e
constexpr std::array<int, 4> kPlaces = {-2, -1, 1, 2};              // k
constexpr std::array<double, 4> kWeights = {1.0, -8.0, 8.0, -1.0};  // times 1/(12 e s)

}  // namespace

std::vector<SizedModel> SizedModels(const Parameters& parameters, const std::vector<ParameterId>& ids,
                                    const ClothModel& model) {
  std::vector<SizedModel> models;
  for (const ParameterId id : ParametersOf(ParameterTerm::kSize)) {
    if (std::find(ids.begin(), ids.end(), id) == ids.end()) continue;
    Scene own_size = model.scene();
    own_size.mesh = model.chosen_on();
    const auto axis = static_cast<std::size_t>(id.axis);
    for (std::size_t i = 0; i < kPlaces.size(); ++i) {
      std::array<double, 2> size = parameters.size;
      size[axis] *= 1.0 + kPlaces[i] * kShareOfSize;
      SizedModel sized{id, kWeights[i] / (12.0 * kShareOfSize * parameters.size[axis]), nullptr, nullptr};
      sized.scene = std::make_unique<const Scene>(SizedScene(own_size, size));
      auto own = std::make_unique<ClothModel>(*sized.scene, model);
      own->SetVariation(parameters);
      sized.model = std::move(own);
      models.push_back(std::move(sized));
    }
  }
  return models;
}

}  // namespace clothid

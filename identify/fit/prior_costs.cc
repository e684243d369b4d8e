#include "identify/fit/prior_costs.h"

#include <ceres/normal_prior.h>
#include <ceres/sized_cost_function.h>

#include <cmath>
#include <cstddef>
#include <map>
#include <optional>
#include <string>
#include <utility>

#include "identify/base/knot_names.h"
#include "sim/base/error.h"

namespace clothid {
namespace {

class LinkCost : public ceres::SizedCostFunction<1, 1, 1> {
 public:
  explicit LinkCost(double std) : std_(std) {}

  bool Evaluate(double const* const* parameters, double* residuals, double** jacobians) const override {
    residuals[0] = (parameters[0][0] - parameters[1][0]) / std_;
    if (jacobians != nullptr && jacobians[0] != nullptr) jacobians[0][0] = 1.0 / std_;
    if (jacobians != nullptr && jacobians[1] != nullptr) jacobians[1][0] = -1.0 / std_;
    return true;
  }

 private:
  double std_;
};

// The times of the profile that a block has a knot of: the first scene that has it tells.
const Eigen::VectorXd& KnotTimes(const ParameterBlock& block, int knot, const std::vector<RecordedMotion>& motions) {
  if (block.recording != kEveryRecording) return motions[block.recording].scene.wind.profile.times;
  for (const RecordedMotion& motion : motions) {
    if (knot < motion.scene.wind.profile.num_knots()) return motion.scene.wind.profile.times;
  }
  return motions.front().scene.wind.profile.times;
}

}  // namespace

void LinkKnots(const std::vector<RecordedMotion>& motions, double smoothness, std::vector<ParameterBlock>* blocks) {
  std::map<std::pair<std::string, int>, int> places;  // by name without suffix, and recording
  for (std::size_t i = 0; i < blocks->size(); ++i) {
    places[{BaseName((*blocks)[i].name), (*blocks)[i].recording}] = static_cast<int>(i);
  }
  bool has_links = false;
  for (ParameterBlock& block : *blocks) {
    const std::optional<ParameterId> knot = FindKnot(block.name);
    if (!knot || knot->knot == 0) continue;
    ParameterId before = *knot;
    --before.knot;
    const auto place = places.find({ParameterName(before, {}), block.recording});
    if (place == places.end()) continue;
    const Eigen::VectorXd& times = KnotTimes(block, knot->knot, motions);
    block.linked_to = place->second;
    block.link_spread = smoothness * std::sqrt(times[knot->knot] - times[before.knot]);
    has_links = true;
  }
  if (!has_links) {
    throw Error(ErrorKind::kUsage,
                "--wind_smoothness: expected with --wind_profile, or with successive knots in --fit or --each, as "
                "wind.x.1,wind.x.2");
  }
}

std::unique_ptr<ceres::CostFunction> MakePriorCost(const ParameterBlock& block) {
  if (!block.prior.is_given()) return nullptr;
  const ceres::Matrix scale = ceres::Matrix::Constant(1, 1, 1.0 / block.PriorStd());
  return std::make_unique<ceres::NormalPrior>(scale, ceres::Vector::Constant(1, block.PriorCoordinate()));
}

std::unique_ptr<ceres::CostFunction> MakeLinkCost(const ParameterBlock& block) {
  if (!block.is_linked()) return nullptr;
  return std::make_unique<LinkCost>(block.LinkStd());
}

}  // namespace clothid

#include "datasets/synthetic/fine_truth.h"

#include <algorithm>
#include <cmath>

#include "datasets/synthetic/true_parameters.h"

namespace clothid {

Eigen::VectorXd FineTruth::PointsAt(double time) const {
  // A time this close to a step, in steps, is that step: times are multiples of it up to their rounding.
  constexpr double kSameTime = 1e-9;
  double steps = std::clamp((time - start_time()) / scene.time_step, 0.0, static_cast<double>(rollout.num_steps()));
  if (std::abs(steps - std::round(steps)) <= kSameTime * std::max(1.0, steps)) steps = std::round(steps);
  const int before = static_cast<int>(std::floor(steps));
  const double fraction = steps - before;
  const Eigen::MatrixXd from = Interpolate(points, rollout.positions(before));
  if (fraction == 0.0) return from;
  return (1.0 - fraction) * from + fraction * Interpolate(points, rollout.positions(before + 1));
}

FineTruth SimulateFineTruth(const GridScene& grid_scene, const std::map<std::string, double>& truth,
                            const RolloutOptions& options) {
  FineTruth result;
  result.nodes = {2 * grid_scene.nodes[0] - 1, 2 * grid_scene.nodes[1] - 1};
  result.scene = Regrid(grid_scene, result.nodes);
  result.scene.time_step = grid_scene.scene.time_step / kTrueStepDivisor;
  result.scene.duration = grid_scene.scene.num_steps() * grid_scene.scene.time_step;
  result.points = PlaceOnMesh(result.scene.mesh, grid_scene.scene.mesh.rest_positions);
  result.rollout = SimulateTruth(truth, grid_scene.path, result.scene, options);
  return result;
}

}  // namespace clothid

#include "datasets/motion/refined_motion.h"

#include <limits>

#include "sim/scene/refinement.h"

namespace clothid {
namespace {

// With the weight w_k of corner k at least a half the point lies in the triangle of that corner: with the corner it has
// the weight 2 w_k - 1 there, with the midpoints toward the others twice the weights of these. Else it lies in the
// middle triangle: of the midpoint opposite to corner k it has the weight 1 - 2 w_k.
ObservedPoint RefinePoint(const ObservedPoint& point, const RefinedMesh& refined) {
  if (point.num_nodes != 3) return point;
  int opposite[3];
  for (int k = 0; k < 3; ++k) {
    opposite[k] = refined.Midpoint(point.nodes[(k + 1) % 3], point.nodes[(k + 2) % 3]);
    if (opposite[k] < 0) return point;  // on no triangle of the mesh
  }
  ObservedPoint result = point;
  for (int k = 0; k < 3; ++k) {
    result.nodes[k] = opposite[k];
    result.weights[k] = 1.0 - 2.0 * point.weights[k];
  }
  for (int k = 0; k < 3; ++k) {
    if (point.weights[k] < 0.5) continue;
    const int next = (k + 1) % 3, last = (k + 2) % 3;
    result.nodes[k] = point.nodes[k];
    result.weights[k] = 2.0 * point.weights[k] - 1.0;
    result.nodes[next] = opposite[last];
    result.weights[next] = 2.0 * point.weights[next];
    result.nodes[last] = opposite[next];
    result.weights[last] = 2.0 * point.weights[last];
    break;
  }
  return result;
}

HandleMeasurements RefineMeasurements(const HandleMeasurements& measured, Eigen::Index num_handles) {
  HandleMeasurements result = measured;
  const Eigen::Index num_measured = measured.sigma.size();
  result.sigma.conservativeResize(num_handles);
  result.sigma.tail(num_handles - num_measured).setConstant(measured.sigma.mean());
  result.deviations.conservativeResize(3 * num_handles, Eigen::NoChange);
  result.deviations.bottomRows(3 * (num_handles - num_measured)).setConstant(std::numeric_limits<double>::quiet_NaN());
  return result;
}

}  // namespace

RecordedMotion RefineMotion(const RecordedMotion& motion) {
  ExpectRefinable(motion.scene, motion.name);
  const RefinedMesh refined = RefineMesh(motion.scene.mesh);
  RecordedMotion result = motion;
  result.scene = RefineScene(motion.scene, refined);
  for (ObservedPoint& point : result.points) point = RefinePoint(point, refined);
  if (!motion.handle_measurements.is_empty()) {
    result.handle_measurements =
        RefineMeasurements(motion.handle_measurements, static_cast<Eigen::Index>(result.scene.handles.nodes.size()));
  }
  return result;
}

}  // namespace clothid

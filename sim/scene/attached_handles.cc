#include "sim/scene/attached_handles.h"

namespace clothid {

HandlePath AttachedPath(const Scene& scene, const RigidPath& body) {
  const AffineMap start = body.At(scene.start_time).pose;
  const auto num_handles = static_cast<Eigen::Index>(scene.handles.nodes.size());
  Eigen::Matrix3Xd places(3, num_handles);  // in axes of the body
  for (Eigen::Index i = 0; i < num_handles; ++i) {
    const Eigen::Vector3d position =
        scene.initial_positions.segment<3>(3 * scene.handles.nodes[static_cast<std::size_t>(i)]);
    places.col(i) = start.leftCols<3>().transpose() * (position - start.col(3));
  }
  const int count = 2 * scene.num_steps() + 1;
  Eigen::VectorXd times(count);
  Eigen::MatrixXd positions(3 * num_handles, count);
  for (int i = 0; i < count; ++i) {
    times[i] = scene.start_time + 0.5 * i * scene.time_step;
    const AffineMap pose = body.At(times[i]).pose;
    positions.col(i) = ((pose.leftCols<3>() * places).colwise() + pose.col(3)).reshaped();
  }
  return HandlePath(times, positions);
}

}  // namespace clothid

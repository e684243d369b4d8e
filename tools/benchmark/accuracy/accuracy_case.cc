#include "tools/benchmark/accuracy/accuracy_case.h"

#include "tools/benchmark/base/benchmark_scene.h"

namespace clothid {

Scene AccuracyCase::MakeScene(int nodes) const {
  Scene made = MakeBenchmarkScene(scene, nodes, setting.stretch_stiffness, setting.time_step);
  made.duration = duration();
  if (scene == "slope") {
    Eigen::Map<Eigen::Matrix3Xd> positions(made.initial_positions.data(), 3, made.mesh.num_nodes());
    const Eigen::Vector3d center = positions.rowwise().mean();
    positions = ((1.0 + kSlopeTension / setting.stretch_stiffness) * (positions.colwise() - center)).colwise() + center;
  }
  return made;
}

AccuracyPoint AccuracyCase::MakePoint(const std::string& quantity, const std::string& reference,
                                      const std::string& method, int nodes) const {
  AccuracyPoint point;
  point.scene = scene;
  point.setting = setting.name;
  point.quantity = quantity;
  point.reference = reference;
  point.method = method;
  point.nodes = nodes;
  point.time_step = setting.time_step;
  return point;
}

}  // namespace clothid

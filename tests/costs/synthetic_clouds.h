// Point clouds on the surface of recordings made in memory.
#ifndef CLOTHID_TESTS_COSTS_SYNTHETIC_CLOUDS_H_
#define CLOTHID_TESTS_COSTS_SYNTHETIC_CLOUDS_H_

#include <Eigen/Core>
#include <random>

#include "datasets/motion/recorded_motion.h"

namespace clothid {

// Gives `motion`, all of whose nodes are seen in every frame, clouds of `count` points anywhere on its triangles, with
// noise of `noise` m on every coordinate; takes the nodes away unless `keep_points`.
inline void AddClouds(int count, double noise, bool keep_points, RecordedMotion* motion) {
  std::mt19937_64 generator(11);
  std::uniform_real_distribution<double> uniform(0.0, 1.0);
  std::uniform_int_distribution<int> choose(0, motion->scene.mesh.num_faces() - 1);
  std::normal_distribution<double> normal(0.0, 1.0);
  for (int frame = 0; frame < motion->num_frames(); ++frame) {
    Eigen::Matrix3Xd& cloud = motion->clouds.emplace_back(3, count);
    const auto nodes = motion->positions.col(frame).reshaped(3, motion->num_points());
    for (auto point : cloud.colwise()) {
      const Eigen::Vector3i corners = motion->scene.mesh.faces.col(choose(generator));
      const double a = 1.0 - std::sqrt(uniform(generator)), b = (1.0 - a) * uniform(generator);
      point = a * nodes.col(corners[0]) + b * nodes.col(corners[1]) + (1.0 - a - b) * nodes.col(corners[2]);
      for (double& coordinate : point) coordinate += noise * normal(generator);
    }
  }
  if (keep_points) return;
  motion->points.clear();
  motion->sigma.resize(0);
  motion->positions.resize(0, motion->num_frames());
}

}  // namespace clothid

#endif  // CLOTHID_TESTS_COSTS_SYNTHETIC_CLOUDS_H_

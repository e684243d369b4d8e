// Point clouds on the surface of recordings made in memory.
#ifndef CLOTHID_TESTS_COSTS_SYNTHETIC_CLOUDS_H_
#define CLOTHID_TESTS_COSTS_SYNTHETIC_CLOUDS_H_

#include <Eigen/Core>
#include <algorithm>
#include <cmath>
#include <map>
#include <random>
#include <utility>
#include <vector>

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

// Makes of all points of `motion`, its nodes, points that are not material: in every frame each is anywhere on the
// triangles around its node; where `borders`, those of the border anywhere on the half edges of the border beside it,
// but for nodes of one triangle or at corners, which stay. No noise.
inline void SlidePoints(bool borders, unsigned seed, RecordedMotion* motion) {
  const Mesh& mesh = motion->scene.mesh;
  std::map<std::pair<int, int>, int> num_faces;
  std::vector<std::vector<int>> faces(static_cast<std::size_t>(mesh.num_nodes())), border = faces;
  for (int face = 0; face < mesh.num_faces(); ++face) {
    for (int k = 0; k < 3; ++k) {
      faces[mesh.faces(k, face)].push_back(face);
      ++num_faces[std::minmax({mesh.faces(k, face), mesh.faces((k + 1) % 3, face)})];
    }
  }
  for (const auto& [edge, count] : num_faces) {
    if (count > 1) continue;
    border[edge.first].push_back(edge.second);
    border[edge.second].push_back(edge.first);
  }
  std::mt19937_64 generator(seed);
  std::uniform_real_distribution<double> uniform(0.0, 1.0);
  const Eigen::MatrixXd nodes = motion->positions;
  for (int node = 0; node < mesh.num_nodes(); ++node) {
    const bool is_border = borders && !border[node].empty();
    motion->points[node].kind = is_border ? PointKind::kBorder : PointKind::kSurface;
    for (int frame = 0; frame < motion->num_frames(); ++frame) {
      const auto at = [&](int of) -> Eigen::Vector3d { return nodes.col(frame).segment<3>(3 * of); };
      auto point = motion->positions.col(frame).segment<3>(3 * node);
      const double choice = uniform(generator);
      if (is_border) {
        const double share = 0.5 * uniform(generator);
        point = (1.0 - share) * at(node) + share * at(border[node][choice < 0.5 ? 0 : 1]);
        continue;
      }
      const auto num_around = static_cast<double>(faces[node].size());
      const Eigen::Vector3i corners = mesh.faces.col(faces[node][static_cast<std::size_t>(choice * num_around)]);
      const double a = 1.0 - std::sqrt(uniform(generator)), b = (1.0 - a) * uniform(generator);
      point = a * at(corners[0]) + b * at(corners[1]) + (1.0 - a - b) * at(corners[2]);
    }
  }
}

}  // namespace clothid

#endif  // CLOTHID_TESTS_COSTS_SYNTHETIC_CLOUDS_H_

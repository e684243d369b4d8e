// Forces at the handles of recordings that tests make in memory.
#ifndef CLOTHID_TESTS_COSTS_SYNTHETIC_FORCES_H_
#define CLOTHID_TESTS_COSTS_SYNTHETIC_FORCES_H_

#include <gtest/gtest.h>

#include <cmath>
#include <map>
#include <random>
#include <string>
#include <vector>

#include "costs/prediction/recording_model.h"
#include "tests/costs/synthetic_motion.h"

namespace clothid {

// The cloth of `scene` shaken by its handles: along y and z, at 20 and 30 rad/s.
inline Scene Shaken(Scene scene) {
  const std::vector<int>& nodes = scene.handles.nodes;
  constexpr int kNumKnots = 41;
  const Eigen::VectorXd times = Eigen::VectorXd::LinSpaced(kNumKnots, 0.0, scene.duration);
  Eigen::MatrixXd path(3 * static_cast<Eigen::Index>(nodes.size()), kNumKnots);
  for (int k = 0; k < kNumKnots; ++k) {
    const Eigen::Vector3d shift(0.0, 0.01 * (1.0 - std::cos(20.0 * times[k])), 0.008 * std::sin(30.0 * times[k]));
    for (std::size_t i = 0; i < nodes.size(); ++i) {
      path.col(k).segment<3>(3 * static_cast<Eigen::Index>(i)) =
          scene.initial_positions.segment<3>(3 * nodes[i]) + shift;
    }
  }
  scene.handles.path = HandlePath(times, path);
  return scene;
}

struct ForceOptions {
  std::map<std::string, double> true_values;  // as of MotionOptions
  std::vector<std::vector<int>> groups;       // empty: all handles
  int num_readings = 33;
  double noise = 0.0;   // N
  double sigma = 1e-3;  // N
};

// Gives `motion` the forces of a rollout, at times that are not those of its frames, from its start to its end.
inline void AddForces(const ForceOptions& options, RecordedMotion* motion) {
  ForceReadings& forces = motion->forces;
  forces.groups = options.groups;
  forces.times =
      Eigen::VectorXd::LinSpaced(options.num_readings, motion->times[0], motion->times[motion->num_frames() - 1]);
  forces.sigma = Eigen::VectorXd::Constant(forces.num_groups(), options.sigma);
  forces.values = Eigen::MatrixXd::Zero(3 * forces.num_groups(), options.num_readings);
  std::vector<ParameterBlock> blocks;
  for (const auto& [name, value] : options.true_values) {
    ParameterOverrides overrides;
    overrides.start[name] = value;
    blocks.push_back(MakeParameterBlock(name, motion->scene, overrides));
  }
  RecordingModel model(*motion, blocks);
  Eigen::MatrixXd predicted;
  ForceTrack track;
  EXPECT_TRUE(model.Simulate(StartOf(blocks), {}, {}, &predicted, nullptr, &track).ok());
  forces.values = track.predicted;
  std::mt19937_64 generator(11);
  std::normal_distribution<double> normal;
  for (double& force : forces.values.reshaped()) force += options.noise * normal(generator);
}

}  // namespace clothid

#endif  // CLOTHID_TESTS_COSTS_SYNTHETIC_FORCES_H_

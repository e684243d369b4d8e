// By which order the error of a rollout falls with its time step. Truths are SDIRK2 at a far smaller step.
#ifndef CLOTHID_TESTS_SIM_ORDER_OF_CONVERGENCE_H_
#define CLOTHID_TESTS_SIM_ORDER_OF_CONVERGENCE_H_

#include <gtest/gtest.h>

#include <Eigen/Core>
#include <cmath>
#include <cstddef>
#include <vector>

#include "sim/rollout/rollout.h"
#include "sim/rollout/simulator.h"
#include "sim/scene/scene.h"

namespace clothid {

inline constexpr double kFrame = 0.01;  // s, between compared positions

inline std::vector<Eigen::VectorXd> Frames(Scene scene, Integrator integrator, int steps_per_frame) {
  scene.integrator = integrator;
  scene.time_step = kFrame / steps_per_frame;
  scene.solver.step_tolerance = 1e-10;
  std::vector<Eigen::VectorXd> frames;
  RolloutOptions options;
  options.visitor = [&](int step, const Eigen::VectorXd& positions) {
    if (step % steps_per_frame == 0) frames.push_back(positions);
  };
  Simulator simulator(scene);
  const Rollout rollout = Simulate(scene.nominal_parameters(), scene.num_steps(), &simulator, nullptr, options);
  EXPECT_TRUE(rollout.ok()) << rollout.failure->ToString();
  return frames;
}

inline double Distance(const std::vector<Eigen::VectorXd>& a, const std::vector<Eigen::VectorXd>& b) {
  double square = 0.0;
  for (std::size_t i = 0; i < a.size(); ++i) square += (a[i] - b[i]).squaredNorm();
  return std::sqrt(square);
}

// log2 of the ratio of the errors at kFrame/`steps` and half of that.
inline double Order(const Scene& scene, Integrator integrator, int steps) {
  const std::vector<Eigen::VectorXd> truth = Frames(scene, Integrator::kSdirk2, 16 * steps);
  return std::log2(Distance(Frames(scene, integrator, steps), truth) /
                   Distance(Frames(scene, integrator, 2 * steps), truth));
}

// Of SDIRK2, at one and two steps per frame, where the error is more than rounding.
inline void ExpectOrderTwo(const Scene& scene) {
  const std::vector<Eigen::VectorXd> truth = Frames(scene, Integrator::kSdirk2, 64);
  const double coarse = Distance(Frames(scene, Integrator::kSdirk2, 1), truth);
  const double fine = Distance(Frames(scene, Integrator::kSdirk2, 2), truth);
  EXPECT_GE(coarse, 1e-6);
  EXPECT_NEAR(std::log2(coarse / fine), 2.0, 0.3) << coarse;
}

}  // namespace clothid

#endif  // CLOTHID_TESTS_SIM_ORDER_OF_CONVERGENCE_H_

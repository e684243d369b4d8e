// States between steps: linear as everywhere, smooth where frames move.
#include "costs/prediction/frame_interpolation.h"

#include <gtest/gtest.h>

#include <cmath>

#include "tests/costs/synthetic_motion.h"

namespace clothid::frame_interpolation_test {
namespace {

constexpr double kStep = 0.01;  // s, of the scenes

// One number per step.
double Combine(const FrameStencil& stencil, const std::function<double(int)>& state, bool slope = false) {
  double sum = 0.0;
  for (int k = 0; k < stencil.size; ++k) {
    sum += (slope ? stencil.slopes : stencil.weights)[k] * state(stencil.first_step + k);
  }
  return sum;
}

RecordedMotion MotionWithTimes(const Eigen::VectorXd& times) {
  RecordedMotion motion = MakeMotion(SwingScene(), {});
  motion.times = times;
  motion.positions = motion.positions.leftCols(times.size()).eval();
  return motion;
}

TEST(FrameInterpolationTest, WithoutAnOffsetItIsThatOfTheObservation) {
  MotionOptions options;
  options.frame_interval = 0.0125;
  const RecordedMotion motion = MakeMotion(SwingScene(), options);
  const Observation observation(motion);
  const FrameInterpolation interpolation(observation);
  EXPECT_EQ(interpolation.num_steps(), observation.num_steps());
  EXPECT_FALSE(interpolation.has_slopes());
  const std::vector<FrameStencil> stencils = interpolation.At(0.0);
  ASSERT_EQ(static_cast<int>(stencils.size()), motion.num_frames());
  for (std::size_t i = 0; i < stencils.size(); ++i) {
    const auto time = [&](int step) { return kStep * step; };
    EXPECT_NEAR(Combine(stencils[i], time), motion.times[static_cast<Eigen::Index>(i)], 1e-15) << i;
    EXPECT_EQ(Combine(stencils[i], time, true), 0.0) << i;
  }
}

TEST(FrameInterpolationTest, CubicsGoThroughTheStepsAndKeepParabolas) {
  const RecordedMotion motion = MotionWithTimes(Eigen::VectorXd::LinSpaced(10, 0.0, 9 * kStep));
  const FrameInterpolation interpolation(motion, 0.02);
  EXPECT_EQ(interpolation.num_steps(), 13);
  const auto parabola = [](double step) { return 2.0 + 3.0 * step - 0.7 * step * step; };
  const auto slope = [](double step) { return (3.0 - 1.4 * step) / kStep; };
  for (const double offset : {0.0, 0.0033, 0.0071, 0.02}) {
    const std::vector<FrameStencil> stencils = interpolation.At(offset);
    for (std::size_t i = 0; i < stencils.size(); ++i) {
      const double step = static_cast<double>(i) + offset / kStep;
      EXPECT_LE(stencils[i].last_step(), interpolation.num_steps());
      EXPECT_NEAR(Combine(stencils[i], parabola), parabola(step), 1e-12) << i << " at " << offset;
      EXPECT_NEAR(Combine(stencils[i], parabola, true), slope(step), 1e-10) << i << " at " << offset;
    }
  }
  const std::vector<FrameStencil> at_steps = interpolation.At(0.0);
  for (int i = 0; i < 10; ++i) {
    EXPECT_NEAR(Combine(at_steps[i], [i](int step) { return step == i ? 1.0 : 0.0; }), 1.0, 1e-12);
  }
}

// The motion is any; at each of these offsets the only frame passes a step, the start, or the end of what is simulated.
TEST(FrameInterpolationTest, NeitherValueNorSlopeJumps) {
  const auto motion_of_step = [](int step) { return std::sin(1.7 * step * step); };
  const RecordedMotion motion = MotionWithTimes(Eigen::Vector2d(0.0, 4.0 * kStep));
  const FrameInterpolation interpolation(motion, 3.0 * kStep);
  const double epsilon = 1e-9;
  for (const double offset : {-0.03, -0.01, 0.0, 0.01, 0.02, 0.03}) {
    const std::vector<FrameStencil> below = interpolation.At(offset - epsilon),
                                    above = interpolation.At(offset + epsilon);
    for (std::size_t i = 0; i < 2; ++i) {
      EXPECT_NEAR(Combine(below[i], motion_of_step), Combine(above[i], motion_of_step), 2e-6) << offset;
      EXPECT_NEAR(Combine(below[i], motion_of_step, true), Combine(above[i], motion_of_step, true), 1e-3) << offset;
    }
  }
}

TEST(FrameInterpolationTest, SlopesAreThoseOfDifferences) {
  const auto motion_of_step = [](int step) { return std::sin(1.7 * step * step); };
  const RecordedMotion motion = MotionWithTimes(Eigen::Vector2d(0.0, 0.0437));
  const FrameInterpolation interpolation(motion, 0.02);
  const double step = 1e-6;
  for (const double offset : {-0.0123, -0.004, 0.0007, 0.0112, 0.0199}) {
    const std::vector<FrameStencil> at = interpolation.At(offset), below = interpolation.At(offset - step),
                                    above = interpolation.At(offset + step);
    for (std::size_t i = 0; i < 2; ++i) {
      const double difference = (Combine(above[i], motion_of_step) - Combine(below[i], motion_of_step)) / (2.0 * step);
      EXPECT_NEAR(Combine(at[i], motion_of_step, true), difference, 1e-5) << i << " at " << offset;
    }
  }
}

TEST(FrameInterpolationTest, StatesArriveInTheOrderOfTheFrames) {
  const RecordedMotion motion = MotionWithTimes(Eigen::Vector4d(0.0, 0.001, 0.002, 0.0437));
  const FrameInterpolation interpolation(motion, 0.02);
  const auto motion_of_step = [](int step) { return std::cos(0.3 * step); };
  for (const double offset : {-0.02, -0.0015, 0.0, 0.02}) {
    const std::vector<FrameStencil> stencils = interpolation.At(offset);
    int next = 0;
    FrameSampler sampler(&stencils, [&](int frame, const FrameStates& states) {
      EXPECT_EQ(frame, next++);
      const FrameStencil& stencil = stencils[static_cast<std::size_t>(frame)];
      ASSERT_EQ(static_cast<int>(states.size()), stencil.size);
      for (int k = 0; k < stencil.size; ++k) {
        const double expected = motion_of_step(stencil.first_step + k);
        EXPECT_EQ(states[static_cast<std::size_t>(k)], expected * Eigen::RowVector2d(1.0, 2.0)) << frame;
      }
    });
    for (int step = 0; step <= interpolation.num_steps(); ++step) {
      sampler.AddStep(step, motion_of_step(step) * Eigen::RowVector2d(1.0, 2.0));
    }
    EXPECT_EQ(next, 4);
  }
}

}  // namespace
}  // namespace clothid::frame_interpolation_test

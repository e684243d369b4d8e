// The start of a scene against the first frame.
#include "datasets/observation/start_difference.h"

#include "tests/costs/synthetic_motion.h"

namespace clothid::start_difference_test {
namespace {

RecordedMotion Moved(double distance) {
  RecordedMotion motion = MakeMotion(SwingScene(), {});
  for (int node = 0; node < motion.scene.mesh.num_nodes(); ++node) {
    motion.scene.initial_positions[3 * node] += distance;
  }
  return motion;
}

TEST(StartDifferenceTest, IsNoneWhereTheSceneStartsAsItWasSeen) {
  const std::optional<StartDifference> difference = DifferenceAtStart(Moved(0.0));
  ASSERT_TRUE(difference.has_value());
  EXPECT_LT(difference->rms, 1e-12);
  EXPECT_FALSE(difference->is_noticeable());
}

TEST(StartDifferenceTest, IsJudgedByTheClothAndTheNoise) {
  // The cloth is 300 mm wide.
  EXPECT_FALSE(DifferenceAtStart(Moved(0.005))->is_noticeable());
  const StartDifference small = *DifferenceAtStart(Moved(0.007));
  EXPECT_NEAR(small.rms, 0.007, 1e-12);
  EXPECT_NEAR(small.cloth_size, 0.3, 1e-12);
  EXPECT_TRUE(small.is_noticeable());
  EXPECT_FALSE(small.is_large());
  EXPECT_TRUE(DifferenceAtStart(Moved(0.1))->is_large());
  RecordedMotion noisy = Moved(0.007);
  noisy.sigma = Eigen::VectorXd::Constant(noisy.num_points(), 0.003);
  EXPECT_NEAR(DifferenceAtStart(noisy)->noise, 0.003 * std::sqrt(3.0), 1e-12);
  EXPECT_FALSE(DifferenceAtStart(noisy)->is_noticeable());
}

TEST(StartDifferenceTest, TakesThePointsThatWereSeen) {
  RecordedMotion motion = Moved(0.1);
  motion.positions.col(0).setConstant(std::nan(""));
  EXPECT_FALSE(DifferenceAtStart(motion).has_value());
  motion.positions.col(0).segment<3>(3 * 4).setZero();
  EXPECT_FALSE(DifferenceAtStart(motion).has_value()) << "a handle, whose start is that of its path";
  motion.positions.col(0).segment<3>(3 * 12) = motion.scene.initial_positions.segment<3>(3 * 12);
  EXPECT_EQ(DifferenceAtStart(motion)->rms, 0.0);
}

TEST(StartDifferenceTest, NeedsAFirstFrameAtTheStartOfTheScene) {
  RecordedMotion motion = Moved(0.1);
  motion.times.array() += 0.5 * motion.scene.time_step + 1e-6;
  EXPECT_FALSE(DifferenceAtStart(motion).has_value());
  motion.scene.start_time = motion.times[0];
  EXPECT_TRUE(DifferenceAtStart(motion).has_value());
  motion.start_source = StartSource::kFirstFrame;
  EXPECT_FALSE(DifferenceAtStart(motion).has_value());
}

TEST(StartDifferenceTest, TakesAPredictionThatAFitHasCorrected) {
  const RecordedMotion motion = Moved(0.1);
  EXPECT_EQ(DifferenceAtStart(motion, motion.positions.col(0))->rms, 0.0);
}

}  // namespace
}  // namespace clothid::start_difference_test

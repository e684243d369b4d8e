// Errors by lead time: none of a model that is right, growing ones of one that is not.
#include "identify/checks/lead_time.h"

#include <gtest/gtest.h>

#include <vector>

#include "tests/costs/synthetic_motion.h"

namespace clothid::lead_time_test {
namespace {

constexpr double kTruth = 90.0;

RecordedMotion Swing() {
  Scene scene = ClothScene(5, 100);
  scene.handles.nodes = {0, 4};
  MotionOptions options;
  options.true_values = {{"k_stretch", kTruth}};
  options.sigma = 1e-3;
  return MakeMotion(scene, options);
}

std::vector<LeadTimeError> ErrorsAt(double k_stretch, const RecordedMotion& motion) {
  RecordingModel model(motion, MakeBlocks(motion.scene, {"k_stretch"}));
  LeadTimes ahead({0.05, std::nullopt}, {});
  ahead.Add(motion, model.blocks().front().ToCoordinate(k_stretch) * Eigen::VectorXd::Ones(1), &model);
  return ahead.Errors();
}

TEST(LeadTimeTest, TheRightModelKnowsWhatComes) {
  const std::vector<LeadTimeError> errors = ErrorsAt(kTruth, Swing());
  ASSERT_EQ(errors.size(), 3u) << "1 s is longer than what any launch has ahead";
  for (std::size_t i = 0; i < errors.size(); ++i) {
    EXPECT_EQ(errors[i].lead, (std::vector<double>{0.1, 0.2, 0.5})[i]);
    EXPECT_LT(errors[i].rmse, 1e-8);
    EXPECT_GT(errors[i].still_rmse, 1e-3);
  }
  EXPECT_EQ(errors[0].num_predictions, 4);
  EXPECT_EQ(errors[2].num_predictions, 2) << "those at .2 and .4 s";
}

TEST(LeadTimeTest, AWrongOneIsOffByMoreTheFartherItLooks) {
  const std::vector<LeadTimeError> errors = ErrorsAt(0.5 * kTruth, Swing());
  ASSERT_EQ(errors.size(), 3u);
  EXPECT_GT(errors[0].rmse, 1e-5);
  EXPECT_GT(errors[1].rmse, errors[0].rmse);
  EXPECT_LT(errors[2].rmse, errors[2].still_rmse);
}

// What is not seen at the launch, or after it, counts nothing.
TEST(LeadTimeTest, PointsThatAreNotSeenCountNothing) {
  RecordedMotion motion = Swing();
  const std::vector<LeadTimeError> all = ErrorsAt(0.5 * kTruth, motion);
  motion.positions.middleCols(25, 8).setConstant(std::nan(""));  // .1 s after the launch at .2 s
  const std::vector<LeadTimeError> some = ErrorsAt(0.5 * kTruth, motion);
  EXPECT_EQ(some[0].num_predictions, 3);
  EXPECT_NE(some[0].rmse, all[0].rmse);
  motion.positions.setConstant(std::nan(""));
  motion.positions.leftCols(5) = Swing().positions.leftCols(5);
  EXPECT_TRUE(ErrorsAt(kTruth, motion).empty());
}

TEST(LeadTimeTest, NothingIsToldWithoutCorrections) {
  const RecordedMotion motion = Swing();
  RecordingModel model(motion, MakeBlocks(motion.scene, {"k_stretch"}));
  LeadTimes ahead({}, {});
  ahead.Add(motion, Eigen::VectorXd::Zero(1), &model);
  EXPECT_TRUE(ahead.Errors().empty());
}

}  // namespace
}  // namespace clothid::lead_time_test

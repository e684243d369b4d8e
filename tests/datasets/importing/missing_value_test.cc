// Positions that stand for points that were not seen.
#include "datasets/importing/missing_value.h"

#include <gtest/gtest.h>

#include "tests/expect_error.h"

namespace clothid::missing_value_test {
namespace {

TEST(MissingValues, ReadsPositionsAndSingleNumbers) {
  const MissingValues values = MissingValues::Parse("0,0,0.5:-1e6", "--missing");
  EXPECT_TRUE(values.Contains(Eigen::Vector3d(0.0, -0.0, 0.5)));
  EXPECT_TRUE(values.Contains(Eigen::Vector3d::Constant(-1e6)));
  EXPECT_FALSE(values.Contains(Eigen::Vector3d(0.0, 0.0, -1e6)));
  EXPECT_FALSE(values.Contains(Eigen::Vector3d(0.0, 0.0, 0.5000001)));
  EXPECT_TRUE(MissingValues::Parse("", "--missing").is_empty());
  EXPECT_FALSE(MissingValues().Contains(Eigen::Vector3d::Zero()));
}

TEST(MissingValues, FindsNumbersThatWereRoundedToFloat32) {
  const MissingValues values = MissingValues::Parse("-999.9", "--missing");
  EXPECT_TRUE(values.Contains(Eigen::Vector3d::Constant(-999.9)));
  EXPECT_TRUE(values.Contains(Eigen::Vector3d::Constant(static_cast<double>(-999.9f))));
  EXPECT_FALSE(values.Contains(Eigen::Vector3d::Constant(-999.90001)));
}

TEST(MissingValues, RefusesWhatIsNoPosition) {
  for (const char* text : {"0,0", "0,0,0,0", "x", "0,0,nan", "0:", ":", "inf", "0 0 0"}) {
    ExpectError([&] { MissingValues::Parse(text, "--missing"); }, ErrorKind::kUsage,
                {"--missing: expected a position as in 0,0,0"});
  }
}

}  // namespace
}  // namespace clothid::missing_value_test

// Bounded coordinates from free ones.
#include "identify/fit/sigmoid_map.h"

#include <gtest/gtest.h>

#include <cmath>

namespace clothid {
namespace {

ParameterBlock MakeBlock(const std::string& name, ParameterScale scale, double start, double lower, double upper) {
  ParameterBlock block;
  block.name = name;
  block.scale = scale;
  block.start = start;
  block.lower_bound = lower;
  block.upper_bound = upper;
  return block;
}

std::vector<ParameterBlock> MakeBlocks() {
  ParameterBlock frozen = MakeBlock("density", ParameterScale::kLog, 0.2, 0.1, 0.4);
  frozen.frozen = true;
  return {MakeBlock("mu", ParameterScale::kLinear, 0.5, 0.0, 2.0), frozen,
          MakeBlock("k_stretch", ParameterScale::kLog, 100.0, 1.0, 1e5)};
}

TEST(SigmoidMapTest, StartsAtTheStartAndStaysInside) {
  const SigmoidMap map(MakeBlocks());
  ASSERT_EQ(map.num_free(), 2);
  const double zero[] = {0.0, 0.0};
  const Eigen::VectorXd start = map.ToCoordinates(zero);
  EXPECT_NEAR(start[0], 0.5, 1e-15);
  EXPECT_EQ(start[1], std::log(0.2));
  EXPECT_NEAR(start[2], std::log(100.0), 1e-14);
  const double far[] = {1e3, -1e4};
  EXPECT_NEAR(map.ToCoordinates(far)[0], 2.0, 1e-12);
  EXPECT_NEAR(map.ToCoordinates(far)[2], 0.0, 1e-12);
}

TEST(SigmoidMapTest, PullsGradientsBack) {
  const SigmoidMap map(MakeBlocks());
  const double u[] = {0.4, -1.3};
  const Eigen::Vector3d coordinate_gradient(2.0, 5.0, -3.0);
  double gradient[2];
  map.PullBack(u, coordinate_gradient, gradient);
  const double step = 1e-6;
  for (int i = 0; i < 2; ++i) {
    double above[] = {u[0], u[1]}, below[] = {u[0], u[1]};
    above[i] += step;
    below[i] -= step;
    const double difference =
        coordinate_gradient.dot(map.ToCoordinates(above) - map.ToCoordinates(below)) / (2.0 * step);
    EXPECT_NEAR(gradient[i], difference, 1e-8);
  }
}

TEST(SigmoidMapTest, AStartAtABoundIsMovedInside) {
  std::vector<ParameterBlock> blocks = MakeBlocks();
  blocks[0].start = 0.0;
  const SigmoidMap map(blocks);
  const double zero[] = {0.0, 0.0};
  EXPECT_GT(map.ToCoordinates(zero)[0], 0.0);
  EXPECT_LT(map.ToCoordinates(zero)[0], 0.01);
}

}  // namespace
}  // namespace clothid

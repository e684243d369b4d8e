// Arrays in a page: what is packed comes out again, as exactly as it is said.
#include "identify/report/packed_array.h"

#include <gtest/gtest.h>

#include <limits>
#include <random>

#include "tests/identify/report/packed_page.h"

namespace clothid::packed_array_test {
namespace {

constexpr double kNaN = std::numeric_limits<double>::quiet_NaN();

TEST(PackedArrayTest, BytesComeOutAgain) {
  for (const std::string& bytes : std::vector<std::string>{"", "a", "ab", std::string("abc\0\xff\x80", 6)}) {
    const std::vector<unsigned char> unpacked = Unpack(PackBytes(bytes));
    EXPECT_EQ(std::string(unpacked.begin(), unpacked.end()), bytes);
  }
}

TEST(PackedArrayTest, PositionsAreOffByHalfAStepAtMost) {
  const Eigen::AlignedBox3d box(Eigen::Vector3d(-1.0, 2.0, 0.5), Eigen::Vector3d(0.5, 2.1, 0.5));
  const PositionGrid grid = GridOver(box);
  EXPECT_DOUBLE_EQ(grid.step, 1.5 / 65534.0);
  std::mt19937_64 generator(1);
  std::uniform_real_distribution<double> uniform(0.0, 1.0);
  Eigen::MatrixXd positions(12, 7);
  for (Eigen::Index i = 0; i < positions.size(); ++i) {
    positions(i) = box.min()[i % 3] + box.sizes()[i % 3] * uniform(generator);
  }
  positions.block<3, 1>(3, 2).setConstant(kNaN);
  positions(7, 0) = kNaN;   // one coordinate, in the first frame
  positions(11, 5) = 10.0;  // outside of the grid
  const std::vector<int> frames = {0, 2, 5, 6};
  const std::vector<std::vector<int>> unpacked = UnpackPositions(PackPositions(Quantize(grid, positions, frames)), 12);
  ASSERT_EQ(unpacked.size(), 4u);
  for (int f = 0; f < 4; ++f) {
    for (int row = 0; row < 12; ++row) {
      const bool is_unseen = (f == 1 && row / 3 == 1) || (f == 0 && row / 3 == 2) || (f == 2 && row / 3 == 3);
      const int q = unpacked[f][row];
      EXPECT_EQ(q == kUnseenCoordinate, is_unseen) << f << " " << row;
      if (is_unseen) continue;
      EXPECT_NEAR(grid.origin[row % 3] + grid.step * q, positions(row, frames[f]), 0.5001 * grid.step);
    }
  }
}

TEST(PackedArrayTest, EveryChangeOfACoordinateIsKept) {
  GridPositions positions(3, 6);
  positions << 0, 65534, 0, 32768, 0, 1,  //
      30000, 32768, 0, 65534, 32766, 65534, 5, 5, 65535, 5, 65535, 32773;
  const std::vector<std::vector<int>> unpacked = UnpackPositions(PackPositions(positions), 3);
  for (int frame = 0; frame < 6; ++frame) {
    for (int row = 0; row < 3; ++row) {
      // A change by 32768 is off by one, see PackPositions.
      EXPECT_NEAR(unpacked[frame][row], positions(row, frame), 1.0) << frame << " " << row;
      EXPECT_EQ(unpacked[frame][row] == kUnseenCoordinate, positions(row, frame) == kUnseenCoordinate);
    }
  }
  EXPECT_EQ(unpacked[1][0], 65534);
}

TEST(PackedArrayTest, AFlatBoxHasAGrid) {
  EXPECT_EQ(GridOver(Eigen::AlignedBox3d(Eigen::Vector3d::Ones(), Eigen::Vector3d::Ones())).step, 1.0);
}

}  // namespace
}  // namespace clothid::packed_array_test

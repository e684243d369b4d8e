// The recordings of a real cloth are not part of the project: see CLOTHID_RECORDINGS in tests/README.md.
#include <gtest/gtest.h>

#include <cmath>
#include <cstdlib>
#include <filesystem>
#include <string>

#include "datasets/motion/motion_file.h"

namespace clothid::real_recordings_test {
namespace {

struct Expected {
  const char* file;
  int frames;
  int missing_points;
};

class RealRecording : public ::testing::TestWithParam<Expected> {
 protected:
  void SetUp() override {
    const char* folder = std::getenv("CLOTHID_RECORDINGS");
    path_ = (folder ? std::string(folder) : CLOTHID_SOURCE_DIR "/../shared/recordings") + "/" + GetParam().file;
    if (!std::filesystem::exists(path_)) GTEST_SKIP() << path_ << " is not there; set CLOTHID_RECORDINGS to its folder";
  }

  std::string path_;
};

TEST_P(RealRecording, IsReadWithItsGapsAndHandles) {
  const RecordedMotion motion = ReadMotion(path_);
  EXPECT_EQ(motion.num_frames(), GetParam().frames);
  EXPECT_EQ(motion.num_points(), 64);
  EXPECT_EQ(motion.scene.handles.nodes, (std::vector<int>{0, 56}));
  EXPECT_EQ(motion.scene.handles.path.num_handles(), 2);
  EXPECT_EQ(motion.positions.array().isNaN().count(), 3 * GetParam().missing_points);
  EXPECT_EQ(motion.sigma.size(), 64);
  EXPECT_EQ(motion.scene.start_time, motion.times[0]);
  EXPECT_TRUE(motion.scene.initial_positions.allFinite());
  EXPECT_NEAR(ClothSize(motion.scene.mesh), 0.3, 0.03);
}

// The robot swings the cloth along y. Across it the corners are found wrongly every few frames, by up to 5 cm.
TEST_P(RealRecording, HasHandlePathsThatKeepTheMotionAndLoseTheJumps) {
  ReadMotionOptions raw;
  raw.smooth_handles = false;
  const Eigen::MatrixXd measured = ReadMotion(path_, raw).scene.handles.path.positions();
  const Eigen::MatrixXd smoothed = ReadMotion(path_).scene.handles.path.positions();
  const auto largest_jump = [](const Eigen::MatrixXd& path, Eigen::Index row) {
    const Eigen::Index last = path.cols() - 1;
    return (path.row(row).tail(last) - path.row(row).head(last)).lpNorm<Eigen::Infinity>();
  };
  for (const Eigen::Index handle : {0, 1}) {
    const Eigen::Index along = 3 * handle + 1, across = 3 * handle;
    const double removed = (smoothed.row(along) - measured.row(along)).norm() / std::sqrt(double(measured.cols()));
    EXPECT_GT(removed, 1e-4);  // m
    EXPECT_LT(removed, 8e-3);  // m, of a swing of 0.3 m
    EXPECT_LT(largest_jump(smoothed, across), 0.5 * largest_jump(measured, across));
  }
}

INSTANTIATE_TEST_SUITE_P(Hung, RealRecording,
                         ::testing::Values(Expected{"hung_a.motion.bin", 133, 39},
                                           Expected{"hung_b.motion.bin", 124, 31}),
                         [](const auto& test) { return std::string(test.param.file).substr(0, 6); });

}  // namespace
}  // namespace clothid::real_recordings_test

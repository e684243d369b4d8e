// Numbers that stand for points that were not seen are told from points that rest.
#include <gtest/gtest.h>

#include <algorithm>
#include <numeric>
#include <random>
#include <string>
#include <utility>
#include <vector>

#include "datasets/checking/motion_check.h"
#include "tests/datasets/importing/made_up_capture.h"

namespace clothid::repeated_places_test {
namespace {

constexpr int kNumPoints = kCaptureColumns * kCaptureRows;

// The finding of this name; one without a name where there is none.
Finding FindingOf(const MotionTensors& tensors, const std::string& what) {
  ReadMotionOptions options;
  options.smooth_handles = false;
  for (const Finding& finding : CheckMotion(InterpretMotion(tensors, "capture", options))) {
    if (finding.what == what) return finding;
  }
  return {};
}

Finding Repeated(const MotionTensors& tensors) { return FindingOf(tensors, "repeated places"); }

void ExpectNone(const MotionTensors& tensors) { EXPECT_EQ(Repeated(tensors).what, "") << Repeated(tensors).value; }

// Puts the point there in the frames [begin, end).
void Put(const Eigen::Vector3d& place, int point, int begin, int end, MotionTensors* tensors) {
  for (int frame = begin; frame < end; ++frame) tensors->positions.col(frame).segment<3>(3 * point) = place;
}

// Every point with this chance in every frame.
void Scatter(const Eigen::Vector3d& place, double share, MotionTensors* tensors) {
  std::mt19937_64 generator(7);
  std::bernoulli_distribution is_lost(share);
  for (int frame = 0; frame < kCaptureFrames; ++frame) {
    for (int point = 0; point < kNumPoints; ++point) {
      if (is_lost(generator)) Put(place, point, frame, frame + 1, tensors);
    }
  }
}

std::vector<int> Range(int begin, int end) {
  std::vector<int> numbers(static_cast<std::size_t>(end - begin));
  std::iota(numbers.begin(), numbers.end(), begin);
  return numbers;
}

TEST(RepeatedPlaces, TellsTheNumbersOfAPointThatIsHiddenForAWhile) {
  for (const auto& [begin, end] : {std::pair{20, 36}, {0, 8}, {52, 60}}) {
    MotionTensors tensors = MadeUpCapture();
    Put(Eigen::Vector3d::Zero(), 27, begin, end, &tensors);
    const Finding finding = Repeated(tensors);
    EXPECT_EQ(finding.severity, Severity::kProblem);
    EXPECT_EQ(finding.frames, Range(begin, end));
    EXPECT_EQ(finding.points, std::vector<int>{27});
    EXPECT_EQ(finding.value.find("(0, 0, 0): " + std::to_string(end - begin) + " times"), 0u) << finding.value;
    EXPECT_NE(finding.hint.find("motion convert --missing 0,0,0"), std::string::npos) << finding.hint;
  }
}

TEST(RepeatedPlaces, TellsAnyNumbersAndShares) {
  for (const Eigen::Vector3d& place :
       {Eigen::Vector3d(0, 0, 0), Eigen::Vector3d(-1e6, -1e6, -1e6), Eigen::Vector3d(9.999, 9.999, 9.999),
        Eigen::Vector3d(0.14, 0.0, 0.86)}) {  // the last one among the cloth
    for (const double share : {0.005, 0.02, 0.15, 0.45}) {
      MotionTensors tensors = MadeUpCapture();
      Scatter(place, share, &tensors);
      const Finding finding = Repeated(tensors);
      EXPECT_EQ(finding.severity, Severity::kProblem) << place.transpose() << ", " << share;
      EXPECT_EQ(finding.value.find("places)"), std::string::npos) << finding.value;
    }
  }
}

TEST(RepeatedPlaces, TellsFramesAndPointsThatWereNeverSeen) {
  MotionTensors tensors = MadeUpCapture();
  for (int point = 0; point < kNumPoints; ++point) Put(Eigen::Vector3d::Zero(), point, 20, 25, &tensors);
  EXPECT_EQ(Repeated(tensors).frames, Range(20, 25));
  tensors = MadeUpCapture();
  for (int point = 30; point < 34; ++point) Put(Eigen::Vector3d::Zero(), point, 0, kCaptureFrames, &tensors);
  EXPECT_EQ(Repeated(tensors).points, Range(30, 34));
}

TEST(RepeatedPlaces, NamesSeveralNumbers) {
  MotionTensors tensors = MadeUpCapture();
  Put(Eigen::Vector3d::Zero(), 27, 20, 26, &tensors);
  Put(Eigen::Vector3d::Constant(-1e6), 40, 30, 34, &tensors);
  EXPECT_NE(Repeated(tensors).hint.find("--missing 0,0,0:-1e+06,-1e+06,-1e+06 "), std::string::npos)
      << Repeated(tensors).hint;
}

// As a tracker that holds the last place.
TEST(RepeatedPlaces, TellsAPointThatStaysBehind) {
  MotionTensors tensors = MadeUpCapture();
  tensors.positions.reshaped(3, tensors.positions.size() / 3).row(1) +=
      Eigen::VectorXd::LinSpaced(kCaptureFrames, 0.0, 1.2).transpose().replicate(kNumPoints, 1).reshaped().transpose();
  Put(tensors.positions.col(29).segment<3>(3 * 27), 27, 30, 50, &tensors);
  EXPECT_EQ(Repeated(tensors).points, std::vector<int>{27});
  EXPECT_EQ(Repeated(tensors).frames.back(), 49);
}

TEST(RepeatedPlaces, APointAtRestIsNoSuchPlace) {
  MotionTensors tensors = MadeUpCapture();
  for (int frame = 30; frame < kCaptureFrames; ++frame) tensors.positions.col(frame) = tensors.positions.col(29);
  ExpectNone(tensors);
  for (int frame = 0; frame < kCaptureFrames; ++frame) tensors.positions.col(frame) = tensors.positions.col(29);
  ExpectNone(tensors);
  for (const int node : tensors.handle_index) {
    tensors.positions.middleRows<3>(3 * node) = MadeUpCapture().positions.middleRows<3>(3 * node);
  }
  ExpectNone(tensors);
}

TEST(RepeatedPlaces, RoundedNumbersAreNoSuchPlaces) {
  for (const double step : {0.001, 0.005, 0.01}) {
    MotionTensors tensors = MadeUpCapture();
    tensors.positions = (tensors.positions / step).array().round() * step;
    ExpectNone(tensors);
  }
  MotionTensors tensors = MadeUpCapture();
  tensors.positions = tensors.positions.cast<float>().cast<double>();
  ExpectNone(tensors);
}

// Each frame by one spacing: a point is where its neighbour was.
TEST(RepeatedPlaces, AClothThatIsDraggedAlongItselfHasNone) {
  MotionTensors tensors = MadeUpCapture();
  for (int frame = 0; frame < kCaptureFrames; ++frame) {
    for (int p = 0; p < kNumPoints; ++p) {
      const int column = p % kCaptureColumns + std::min(frame, 40), row = p / kCaptureColumns;
      tensors.positions.col(frame).segment<3>(3 * p) << kCaptureSpacing * column, kCaptureSpacing * row, 0.0;
    }
  }
  ExpectNone(tensors);
}

// Neither is a mesh in a wrong order, nor a frame that was copied with an outlier in it.
TEST(RepeatedPlaces, OtherFaultsAreNotTakenForThem) {
  MotionTensors tensors = MadeUpCapture();
  const Eigen::MatrixXd before = tensors.positions;
  for (int p = 0; p < kNumPoints; ++p) {
    tensors.positions.middleRows<3>(3 * p) = before.middleRows<3>(3 * (27 * p % kNumPoints));
  }
  for (int frame = 30; frame < kCaptureFrames; ++frame) tensors.positions.col(frame) = tensors.positions.col(29);
  ExpectNone(tensors);
  tensors = MadeUpCapture();
  tensors.positions.col(30).segment<3>(3 * 27).array() += 0.3;
  for (int frame = 31; frame < 37; ++frame) tensors.positions.col(frame) = tensors.positions.col(30);
  ExpectNone(tensors);
  // A point that was taken for one that is held.
  tensors = MadeUpCapture();
  Put(CapturedPlace(0, 0, 0.0), 0, 0, kCaptureFrames, &tensors);
  Put(CapturedPlace(0, 0, 0.0), 27, 20, 30, &tensors);
  ExpectNone(tensors);
}

// Clouds of the capture, `num_points` about each of its points.
MotionTensors CloudCapture(int num_points, double noise) {
  MotionTensors tensors = MadeUpCapture();
  std::mt19937_64 generator(5);
  std::normal_distribution<double> error(0.0, noise);
  for (int frame = 0; frame < kCaptureFrames; ++frame) {
    Eigen::Matrix3Xd cloud = tensors.positions.col(frame).reshaped(3, kNumPoints).replicate(1, num_points);
    for (double& coordinate : cloud.reshaped()) coordinate += error(generator);
    tensors.clouds.push_back(cloud);
  }
  tensors.positions.resize(0, kCaptureFrames);
  tensors.sigma.resize(0);
  tensors.cloud_sigma = 0.003;
  for (int p = 0; p < kNumPoints; ++p) tensors.mesh.rest_positions.col(p) = CapturedPlace(p % 8, p / 8, 0.0);
  tensors.scene_text =
      R"({"clothid_scene": 1, "time_step": 0.005, "handles": [0, 7], "initial": {"positions": "rest"}})";
  return tensors;
}

TEST(RepeatedPlaces, TellsThoseOfClouds) {
  for (const double share : {0.02, 0.15}) {
    for (const double number : {0.0, 9999.0}) {
      MotionTensors tensors = CloudCapture(6, 0.01);
      for (Eigen::Matrix3Xd& cloud : tensors.clouds) {
        cloud.leftCols(static_cast<Eigen::Index>(share * static_cast<double>(cloud.cols()))).setConstant(number);
      }
      const Finding finding = Repeated(tensors);
      EXPECT_EQ(finding.severity, Severity::kProblem) << share << ", " << number;
      EXPECT_EQ(finding.frames.size(), 60u);
      EXPECT_NE(finding.hint.find("motion convert_clouds --missing " + std::string(number == 0.0 ? "0,0,0" : "9999,")),
                std::string::npos)
          << finding.hint;
    }
  }
  // One of each frame, as the mean of those of a voxel.
  MotionTensors tensors = CloudCapture(6, 0.01);
  for (Eigen::Matrix3Xd& cloud : tensors.clouds) cloud.col(17).setZero();
  EXPECT_EQ(Repeated(tensors).severity, Severity::kProblem);
}

TEST(RepeatedPlaces, TellsACloudOfWhichNothingWasSeen) {
  MotionTensors tensors = CloudCapture(6, 0.01);
  tensors.clouds[10].setZero();
  const Finding finding = Repeated(tensors);
  EXPECT_EQ(finding.severity, Severity::kProblem);
  EXPECT_EQ(finding.frames, std::vector<int>{10});
}

TEST(RepeatedPlaces, CloudsMayRepeatThemselves) {
  ExpectNone(CloudCapture(6, 0.01));
  MotionTensors still = CloudCapture(6, 0.01);
  for (Eigen::Matrix3Xd& cloud : still.clouds) cloud = still.clouds.front();
  ExpectNone(still);
  MotionTensors twice = CloudCapture(6, 0.01);
  for (Eigen::Matrix3Xd& cloud : twice.clouds) cloud = cloud.replicate(1, 2).eval();
  ExpectNone(twice);
  MotionTensors rounded = CloudCapture(100, 0.02);
  for (Eigen::Matrix3Xd& cloud : rounded.clouds) cloud = (cloud / 0.002).array().round() * 0.002;
  ExpectNone(rounded);
  MotionTensors empty = CloudCapture(6, 0.01);
  empty.clouds[10].resize(3, 0);
  ExpectNone(empty);
}

// Not to the last bit: the point follows something else.
TEST(RepeatedPlaces, JumpsTellHowLongAPointStaysAway) {
  MotionTensors tensors = MadeUpCapture();
  for (int frame = 20; frame < 32; ++frame) {
    tensors.positions.col(frame).segment<3>(3 * 27) += Eigen::Vector3d(0.0, 0.3, 0.0);
  }
  ExpectNone(tensors);
  const Finding finding = FindingOf(tensors, "jumps of points");
  EXPECT_NE(finding.value.find("for up to 12 frames (0.4 s)"), std::string::npos) << finding.value;
  EXPECT_EQ(finding.hint.find("for one frame"), std::string::npos) << finding.hint;
}

}  // namespace
}  // namespace clothid::repeated_places_test

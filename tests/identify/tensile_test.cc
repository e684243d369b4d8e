// A real tensile test of a knit (CLOTHID_RECORDINGS in tests/README.md): the gauge makes its stiffness absolute.
#include <gtest/gtest.h>

#include <cmath>
#include <cstdlib>
#include <filesystem>
#include <limits>
#include <string>

#include "identify/fit/fit.h"
#include "identify/verdict/verdict.h"
#include "sim/base/npy_file.h"

namespace clothid::tensile_test {
namespace {

constexpr double kWidth = 0.0666, kLength = 0.0692;  // m, of the specimen between its clamps
constexpr int kColumns = 9, kRows = 9;
constexpr int kNumFrames = 70;                             // up to a strain of 11 %
constexpr double kLeastStrain = 0.02, kMostStrain = 0.10;  // where the force is a straight line
constexpr int kNumPins = 5, kLower = 5, kUpper = 6;        // the points: right, left, bottom, top, centre, both clamps

class TensileTest : public testing::Test {
 protected:
  void SetUp() override {
    const char* variable = std::getenv("CLOTHID_RECORDINGS");
    const std::string folder =
        (variable != nullptr ? std::string(variable) : CLOTHID_SOURCE_DIR "/../shared/recordings") + "/knit_x1/";
    if (!std::filesystem::exists(folder + "force.npy")) {
      GTEST_SKIP() << folder << "force.npy is not there; set CLOTHID_RECORDINGS to its folder";
    }
    const NpyArray positions = ReadNpy(folder + "positions.npy");
    times_ = ReadVector(folder + "times.npy").head(kNumFrames);
    forces_ = ReadVector(folder + "force.npy").head(kNumFrames);
    points_ = Eigen::Map<const Eigen::MatrixXd>(positions.values.data(), 21, positions.shape[0]).leftCols(kNumFrames);
    strains_ = (points_.row(3 * kUpper + 2) - points_.row(3 * kLower + 2)).transpose().array() / kLength - 1.0;
  }

  static Eigen::VectorXd ReadVector(const std::string& path) {
    const NpyArray array = ReadNpy(path);
    return Eigen::Map<const Eigen::VectorXd>(array.values.data(), static_cast<Eigen::Index>(array.values.size()));
  }

  bool IsCounted(int frame) const { return strains_[frame] >= kLeastStrain && strains_[frame] <= kMostStrain; }

  // Least squares of force per width over strain, N/m.
  double Slope() const {
    double count = 0.0, x = 0.0, y = 0.0, xx = 0.0, xy = 0.0;
    for (int i = 0; i < kNumFrames; ++i) {
      if (!IsCounted(i)) continue;
      const double force = forces_[i] / kWidth;
      count += 1.0;
      x += strains_[i];
      y += force;
      xx += strains_[i] * strains_[i];
      xy += strains_[i] * force;
    }
    return (count * xy - x * y) / (count * xx - x * x);
  }

  // A strip in the xz plane, its rows at the clamps with them.
  Scene MakeScene() const {
    Scene scene;
    scene.integrator = Integrator::kEuler;  // quasi-static: it damps what the clamps' noise shakes
    scene.time_step = 0.1;
    scene.duration = times_[kNumFrames - 1];
    GridOptions grid;
    grid.nodes = {kColumns, kRows};
    grid.size = {kWidth, kLength};
    grid.origin = Eigen::Vector3d(-0.5 * kWidth, 0.0, 0.0);
    grid.axes = {Eigen::Vector3d::UnitX(), Eigen::Vector3d::UnitZ()};
    scene.mesh = MakeGrid(grid);
    scene.initial_positions = scene.mesh.rest_positions.reshaped();
    scene.initial_velocities = Eigen::VectorXd::Zero(scene.initial_positions.size());
    scene.material.density = 0.3;
    scene.material.stretch_stiffness = 100.0;
    Eigen::MatrixXd path(6 * kColumns, kNumFrames);
    for (int i = 0; i < 2 * kColumns; ++i) {
      const bool is_lower = i < kColumns;
      const int node = is_lower ? i : kColumns * (kRows - 1) + i - kColumns;
      scene.handles.nodes.push_back(node);
      path.middleRows<3>(3 * i) = scene.mesh.rest_positions.col(node).replicate(1, kNumFrames);
      path.row(3 * i + 2) = points_.row(3 * (is_lower ? kLower : kUpper) + 2);
      path.row(3 * i + 2).array() += scene.mesh.rest_positions(2, node) - path(3 * i + 2, 0);
    }
    scene.handles.path = HandlePath(times_, path);
    return scene;
  }

  // Where a pin stands at rest: its triangle.
  static ObservedPoint PinAt(const Mesh& mesh, double x, double z) {
    ObservedPoint point;
    point.num_nodes = 3;
    for (int f = 0; f < mesh.num_faces(); ++f) {
      Eigen::Matrix3d corners;
      for (int k = 0; k < 3; ++k) {
        const Eigen::Vector3d node = mesh.rest_positions.col(mesh.faces(k, f));
        corners.col(k) << node.x(), node.z(), 1.0;
      }
      const Eigen::Vector3d weights = corners.inverse() * Eigen::Vector3d(x, z, 1.0);
      if (weights.minCoeff() < -1e-9) continue;
      for (int k = 0; k < 3; ++k) {
        point.nodes[k] = mesh.faces(k, f);
        point.weights[k] = weights[k];
      }
      return point;
    }
    ADD_FAILURE() << "a pin is not on the specimen";
    return point;
  }

  // The pins, which are seen along x and z; and the gauge at the upper clamp.
  RecordedMotion MakeRecording(bool with_forces) const {
    RecordedMotion motion;
    motion.name = "knit_x1";
    motion.scene = MakeScene();
    motion.scene_text = "{}";
    motion.times = times_;
    motion.positions = points_.topRows(3 * kNumPins);
    for (int p = 0; p < kNumPins; ++p) {
      const Eigen::Vector3d pin = motion.positions.col(0).segment<3>(3 * p);
      motion.points.push_back(PinAt(motion.scene.mesh, pin.x(), pin.z()));
      motion.positions.row(3 * p + 1).setConstant(std::numeric_limits<double>::quiet_NaN());
    }
    motion.sigma = Eigen::VectorXd::Constant(kNumPins, 3e-4);
    if (!with_forces) return motion;
    ForceReadings& forces = motion.forces;
    forces.times = times_;
    forces.groups = {{motion.scene.handles.nodes.begin() + kColumns, motion.scene.handles.nodes.end()}};
    forces.sigma = Eigen::VectorXd::Constant(1, 0.15);
    forces.values = Eigen::MatrixXd::Constant(3, kNumFrames, std::numeric_limits<double>::quiet_NaN());
    for (int i = 0; i < kNumFrames; ++i) {
      if (IsCounted(i)) forces.values(2, i) = forces_[i];
    }
    return motion;
  }

  static FitSummary FitOf(const RecordedMotion& motion, const std::vector<std::string>& names) {
    FitOptions options;
    options.parameters = names;
    options.jacobian = JacobianMethod::kSensitivity;
    FitProblem problem({motion}, options);
    return Fit(options, &problem);
  }

  Eigen::VectorXd times_, forces_, strains_;
  Eigen::MatrixXd points_;  // [21 x T] m
};

// The path of the clamp and the gauge, nothing else.
TEST_F(TensileTest, StiffnessIsTheSlopeOfTheForce) {
  const double slope = Slope();
  EXPECT_GT(slope, 240.0);
  EXPECT_LT(slope, 310.0);
  RecordedMotion motion = MakeRecording(true);
  motion.positions.setConstant(std::numeric_limits<double>::quiet_NaN());
  // The specimen was taut before its strain counts as zero: an offset of the line.
  const FitSummary fit = FitOf(motion, {"k_stretch", "force_bias.z"});
  ASSERT_EQ(fit.status, FitStatus::kConverged) << fit.message;
  ASSERT_TRUE(fit.uncertainty);
  const double stiffness = fit.parameters[0].value;
  const ParameterUncertainty& interval = fit.uncertainty->parameters[0];
  std::printf("slope %.1f N/m; k_stretch %.1f, 95 %% interval %.1f .. %.1f; force_bias.z %.3f N, force rms %.3f N\n",
              slope, stiffness, interval.lower95, interval.upper95, fit.parameters[1].value, fit.error.force.rms());
  EXPECT_NEAR(stiffness, slope, 0.1 * slope);
  EXPECT_LT(interval.lower95, slope);
  EXPECT_GT(interval.upper95, slope);
  EXPECT_LT(interval.upper95 - interval.lower95, 0.3 * slope);
  EXPECT_TRUE(IsIdentifiable(fit, {}, 0).value_or(false));
  EXPECT_NEAR(fit.error.force.rms(), 0.15, 0.03);
}

// The isotropic membrane does not contract where it is pulled, as the knit does: the pins miss it by a millimetre, and
// the stiffness stays.
TEST_F(TensileTest, PinsThatTheModelMissesDoNotMoveIt) {
  const FitSummary fit = FitOf(MakeRecording(true), {"k_stretch", "force_bias.z"});
  ASSERT_EQ(fit.status, FitStatus::kConverged) << fit.message;
  EXPECT_NEAR(fit.parameters[0].value, Slope(), 0.1 * Slope());
  EXPECT_NEAR(fit.error.force.rms(), 0.15, 0.03);
  EXPECT_GT(fit.error.rmse(), 5e-4);
}

TEST_F(TensileTest, WithoutTheGaugeItIsNotDetermined) {
  const FitSummary fit = FitOf(MakeRecording(false), {"k_stretch"});
  ASSERT_TRUE(fit.has_estimate()) << fit.message;
  EXPECT_FALSE(IsIdentifiable(fit, {}, 0).value_or(true));
  EXPECT_EQ(Judge(fit, {}).parameters[0], Usability::kDoNotUse);
}

}  // namespace
}  // namespace clothid::tensile_test

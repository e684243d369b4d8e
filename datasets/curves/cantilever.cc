#include "datasets/curves/cantilever.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <nlohmann/json.hpp>
#include <numeric>
#include <string>
#include <vector>

#include "datasets/curves/heavy_elastica.h"
#include "datasets/curves/lab_table.h"
#include "datasets/motion/motion_file.h"
#include "datasets/motion/motion_validation.h"
#include "sim/base/error.h"
#include "sim/base/text_file.h"
#include "sim/mesh/mesh.h"

namespace clothid {
namespace {

constexpr double kLeastOverhang = 0.005, kMostOverhang = 1.0;  // m: beyond them a unit is off
constexpr int kFewestProfilePoints = 5;
constexpr double kLongestProfileStep = 0.34;  // of the overhang: a longer chord is no arc

constexpr int kAcrossCantilever = 5, kCellsAlong = 48;
constexpr double kCantileverStep = 0.2;        // s
constexpr int kNumCantileverSteps = 40;        // at which the frames are
constexpr double kCantileverStretch = 1000.0;  // N/m
constexpr double kTwistShare = 0.5;            // of the rigidity: of a plate that is isotropic

[[noreturn]] void FailOnRow(const LabTable& table, Eigen::Index row, const std::string& message) {
  throw Error(ErrorKind::kBadData,
              table.name + ":" + std::to_string(table.lines[static_cast<std::size_t>(row)]) + ": " + message);
}

void CheckOverhang(const LabTable& table, Eigen::Index row, double overhang) {
  if (overhang >= kLeastOverhang && overhang <= kMostOverhang) return;
  FailOnRow(table, row, "expected an overhang of 5 to 1000 mm, found " + ShortestText(1e3 * overhang) + " mm");
}

void TakeAngles(const LabTable& table, CantileverTable* result) {
  constexpr double kDegrees = 57.29577951308232;
  result->overhangs = table.values.col(0);
  result->is_bench_angle = table.values.cols() == 1;
  result->angles = result->is_bench_angle ? Eigen::VectorXd::Constant(table.values.rows(), kBenchAngle)
                                          : Eigen::VectorXd(table.values.col(1));
  for (Eigen::Index row = 0; row < table.values.rows(); ++row) {
    CheckOverhang(table, row, result->overhangs[row]);
    const double angle = result->angles[row];
    if (!(angle >= kLeastSag && angle <= kMostSag)) {
      FailOnRow(table, row,
                "expected an angle of 1 to 75 degrees below the level, found " + ShortestText(kDegrees * angle));
    }
  }
}

void TakeProfile(const LabTable& table, CantileverTable* result) {
  result->profile = table.values.transpose();
  const Eigen::Index last = table.values.rows() - 1;
  if (last + 1 < kFewestProfilePoints) {
    FailOnRow(table, last, "expected at least 5 points of a profile, found " + std::to_string(last + 1));
  }
  result->is_turned = result->profile.row(1).sum() > 0.0;
  if (result->is_turned) result->profile.row(1) *= -1.0;
  double length = 0.0, longest = 0.0;
  Eigen::Vector2d before = Eigen::Vector2d::Zero();
  for (Eigen::Index row = 0; row <= last; ++row) {
    const Eigen::Vector2d point = result->profile.col(row);
    if (point.x() < before.x() || (row > 0 && point == before)) {
      FailOnRow(table, row, "expected points from the edge of the clamp at 0,0 on, forwards");
    }
    longest = std::max(longest, (point - before).norm());
    length += (point - before).norm();
    before = point;
  }
  CheckOverhang(table, last, length);
  if (longest > kLongestProfileStep * length) {
    FailOnRow(table, last,
              "expected points all along the strip, from the edge of the clamp at 0,0 on; two are " +
                  ShortestText(std::round(1e5 * longest) / 1e2) + " mm apart");
  }
  if (!(std::atan2(-before.y(), before.x()) >= kLeastSag)) FailOnRow(table, last, "expected a profile that sags");
  result->overhangs = Eigen::VectorXd::Constant(1, length);
  result->angles = Eigen::VectorXd::Constant(1, std::min(std::atan2(-before.y(), before.x()), kMostSag));
}

std::string SceneOfCantilever(const CantileverStrip& strip) {
  nlohmann::ordered_json scene = {{"clothid_scene", 2},
                                  {"time_step", kCantileverStep},
                                  {"integrator", "euler"},
                                  {"initial", {{"positions", "rest"}}}};
  std::vector<int> edge(kAcrossCantilever);
  std::iota(edge.begin(), edge.end(), 0);
  scene["handles"] = {{"nodes", edge}, {"clamp", true}};
  nlohmann::ordered_json& materials = scene["materials"];
  materials = {{"density", strip.density}, {"k_stretch", kCantileverStretch}};
  if (!strip.has_warp) {
    materials["k_bend"] = strip.nominal;
    return scene.dump(2);
  }
  materials["bend_warp"] = materials["bend_weft"] = strip.nominal;
  materials["bend_twist"] = kTwistShare * strip.nominal;
  materials["warp_direction"] = {1, 0, 0};
  if (strip.direction == PullDirection::kWeft) materials["warp_angle"] = 90;
  if (strip.direction == PullDirection::kBias) materials["warp_angle"] = 45;
  return scene.dump(2);
}

// All but what is seen.
MotionTensors HeldStrip(const CantileverStrip& strip, const std::string& provenance) {
  for (const double number : {strip.width, strip.overhang, strip.density, strip.sigma, strip.nominal}) {
    ExpectUsage(number > 0.0 && std::isfinite(number), "strip: expected numbers > 0");
  }
  GridOptions grid;
  grid.nodes = {kAcrossCantilever, kCellsAlong + 1};
  grid.size = {strip.width, strip.overhang};
  grid.origin = {0.0, -0.5 * strip.width, 0.0};
  grid.axes = {Eigen::Vector3d::UnitY(), Eigen::Vector3d::UnitX()};
  MotionTensors motion;
  motion.mesh = MakeGrid(grid);
  for (int i = 0; i < kAcrossCantilever; ++i) motion.handle_index.push_back(i);
  motion.times = Eigen::VectorXd::LinSpaced(kNumCantileverSteps + 1, 0.0, kNumCantileverSteps * kCantileverStep);
  motion.handle_times = Eigen::Vector2d(0.0, kNumCantileverSteps * kCantileverStep);
  motion.handle_positions = motion.mesh.rest_positions(Eigen::all, motion.handle_index).reshaped().replicate(1, 2);
  motion.single_precision = motion.single_precision_clouds = false;
  motion.scene_text = SceneOfCantilever(strip);
  motion.provenance = provenance;
  return motion;
}

MotionTensors Tried(MotionTensors motion) {
  ValidateMotionTensors(motion, motion.provenance);
  InterpretMotion(motion, motion.provenance);
  return motion;
}

}  // namespace

Eigen::VectorXd CantileverTable::BendingLengths() const {
  Eigen::VectorXd lengths(angles.size());
  for (Eigen::Index i = 0; i < lengths.size(); ++i) {
    lengths[i] = overhangs[i] * SagOfAngle(angles[i]).bending_length;
  }
  return lengths;
}

CantileverTable ReadCantileverTable(const std::string& path) {
  static const LabColumn overhang = {
      {"overhang", "overhang length", "overhanging length"}, {LabQuantity::kLength}, "mm, cm or m"};
  static const LabColumn angle = {{"angle", "winkel"}, {LabQuantity::kAngle}, "deg or rad"};
  static const LabColumn x = {{"x"}, {LabQuantity::kLength}, "mm, cm or m"};
  static const LabColumn z = {{"z", "y"}, {LabQuantity::kLength}, "mm, cm or m"};
  static const std::vector<LabForm> forms = {
      {{overhang, angle}, "columns of overhang and angle", "Overhang [mm];Angle [deg]"},
      {{overhang}, "of overhang alone", "Overhang [mm]"},
      {{x, z}, "of x and z of a profile", "x [mm];z [mm]"}};
  const LabTable table = ReadLabTable(path, forms);
  CantileverTable result;
  result.name = path;
  for (const std::string& column : table.columns) result.columns += (result.columns.empty() ? "" : " and ") + column;
  if (table.form == 2) {
    TakeProfile(table, &result);
  } else {
    TakeAngles(table, &result);
  }
  return result;
}

std::string ParameterOfCantilever(const CantileverStrip& strip) {
  if (!strip.has_warp) return "k_bend";
  if (strip.direction == PullDirection::kBias) return "bend_twist";
  return strip.direction == PullDirection::kWarp ? "bend_warp" : "bend_weft";
}

MotionTensors RecordCantilever(const Eigen::Vector2d& tip, const CantileverStrip& strip,
                               const std::string& provenance) {
  MotionTensors motion = HeldStrip(strip, provenance);
  motion.node_index = {motion.mesh.num_nodes() - 1 - kAcrossCantilever / 2};
  motion.positions.setConstant(3, motion.times.size(), std::numeric_limits<double>::quiet_NaN());
  motion.positions.rightCols<1>() << tip.x(), std::numeric_limits<double>::quiet_NaN(), tip.y();
  motion.sigma = Eigen::VectorXd::Constant(1, strip.sigma);
  return Tried(std::move(motion));
}

MotionTensors RecordProfile(const Eigen::Matrix2Xd& profile, const CantileverStrip& strip,
                            const std::string& provenance) {
  MotionTensors motion = HeldStrip(strip, provenance);
  motion.positions.resize(0, motion.times.size());
  motion.clouds.assign(static_cast<std::size_t>(motion.times.size()), Eigen::Matrix3Xd(3, 0));
  Eigen::Matrix3Xd& seen = motion.clouds.back();
  seen.setZero(3, profile.cols() + 1);  // the first is the edge of the clamp
  seen.row(0).tail(profile.cols()) = profile.row(0);
  seen.row(2).tail(profile.cols()) = profile.row(1);
  motion.cloud_sigma = strip.sigma;
  return Tried(std::move(motion));
}

}  // namespace clothid

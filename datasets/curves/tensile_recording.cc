#include "datasets/curves/tensile_recording.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "datasets/motion/motion_file.h"
#include "datasets/motion/motion_validation.h"
#include "sim/base/error.h"
#include "sim/mesh/mesh.h"

namespace clothid {
namespace {

constexpr double kDensity = 0.2;         // kg/m^2, of a fabric of medium weight; a curve does not depend on it
constexpr double kTimeStep = 0.1;        // s
constexpr double kStepTolerance = 0.01;  // of the momentum of the strip, see the header
constexpr int kNumPullSteps = 100;       // at which the frames are
constexpr double kDuration = kNumPullSteps * kTimeStep;

constexpr int kUsualNodes = 9, kMostUsualNodes = 65;

constexpr double kUsualStiffening = 3.0;  // of knits along their courses; woven cloth and their wales have more
constexpr double kShearShare = 0.5;       // of k: an isotropic cloth that does not contract

// N/m: the power of ten that is nearest to the force per width over the strain at the last reading.
double NominalStiffness(const TensileCurve& curve) {
  const Eigen::Index last = curve.strains.size() - 1;
  return std::pow(10.0, std::round(std::log10(curve.forces[last] / (curve.width * curve.strains[last]))));
}

std::string SceneOfStrip(const TensileCurve& curve, const TensileStrip& strip) {
  const double stiffness = NominalStiffness(curve);
  nlohmann::ordered_json scene = {{"clothid_scene", 2},
                                  {"time_step", kTimeStep},
                                  {"integrator", "euler"},
                                  {"gravity", {0, 0, 0}},
                                  {"initial", {{"positions", "rest"}}},
                                  {"solver", {{"step_tolerance", kStepTolerance}}}};
  nlohmann::ordered_json& materials = scene["materials"];
  materials = {{"density", kDensity},
               {"membrane", strip.membrane == MembraneLaw::kYarn ? "yarn" : "orthotropic"},
               {"k_warp", stiffness},
               {"k_weft", stiffness},
               {"k_shear", kShearShare * stiffness},
               {"k_poisson", 0}};
  if (strip.membrane == MembraneLaw::kYarn) {
    materials["stiffening_warp"] = materials["stiffening_weft"] = kUsualStiffening;
  }
  if (strip.direction == PullDirection::kWeft) {
    materials["warp_direction"] = {1, 0, 0};
  } else {
    materials["warp_direction"] = {0, 0, 1};
  }
  if (strip.direction == PullDirection::kBias) materials["warp_angle"] = 45;
  return scene.dump(2);
}

void CheckStrip(const TensileStrip& strip) {
  ExpectUsage(strip.membrane != MembraneLaw::kArap, "membrane: expected one with warp and weft");
  ExpectUsage(strip.nodes[0] >= 2 && strip.nodes[1] >= 3 && strip.nodes[0] <= kMaxNodes / strip.nodes[1],
              "nodes: expected at least 2 across and 3 along the pull, and at most " + std::to_string(kMaxNodes));
}

// The rows at both clamps, the upper one moved at constant speed.
void HoldClamps(const TensileCurve& curve, const TensileStrip& strip, MotionTensors* motion) {
  const int num_across = strip.nodes[0], first_upper = motion->mesh.num_nodes() - num_across;
  std::vector<int> upper;
  for (int i = 0; i < num_across; ++i) motion->handle_index.push_back(i);
  for (int i = 0; i < num_across; ++i) upper.push_back(first_upper + i);
  motion->handle_index.insert(motion->handle_index.end(), upper.begin(), upper.end());
  const Eigen::VectorXd start = motion->mesh.rest_positions(Eigen::all, motion->handle_index).reshaped();
  motion->handle_times = Eigen::Vector2d(0.0, kDuration);
  motion->handle_positions = start.replicate(1, 2);
  const double pull = curve.length * curve.strains[curve.strains.size() - 1];
  for (int i = num_across; i < 2 * num_across; ++i) motion->handle_positions(3 * i + 2, 1) += pull;

  ForceReadings& forces = motion->forces;
  const Eigen::Index count = curve.strains.size();
  forces.times = curve.strains / curve.strains[count - 1] * kDuration;
  forces.times[count - 1] = kDuration;
  forces.values = Eigen::MatrixXd::Constant(3, count, std::numeric_limits<double>::quiet_NaN());
  forces.values.row(2) = curve.forces.transpose();
  forces.groups = {upper};
  forces.sigma = Eigen::VectorXd::Constant(1, curve.force_sigma);
}

// Where the right mark is at rest: on the edge between two nodes of the row in the middle.
void PlaceMark(const TensileCurve& curve, const TensileStrip& strip, MotionTensors* motion) {
  const int num_cells = strip.nodes[0] - 1;
  const double place = (0.5 + 0.5 * curve.rest_width / curve.width) * num_cells;
  const int left = std::min(static_cast<int>(place), num_cells - 1);
  const int node = left + strip.nodes[0] * (strip.nodes[1] / 2);
  const Mesh& mesh = motion->mesh;
  for (int face = 0; face < mesh.num_faces(); ++face) {
    Eigen::Vector3d weights = Eigen::Vector3d::Zero();
    int num_found = 0;
    for (int corner = 0; corner < 3; ++corner) {
      if (mesh.faces(corner, face) == node) weights[corner] = 1.0 - (place - left);
      if (mesh.faces(corner, face) == node + 1) weights[corner] = place - left;
      num_found += mesh.faces(corner, face) == node || mesh.faces(corner, face) == node + 1;
    }
    if (num_found < 2) continue;
    motion->face_index = {face};
    motion->barycentric = weights;
    return;
  }
}

// A frame per reading, and the start.
void SeeWidths(const TensileCurve& curve, const TensileStrip& strip, MotionTensors* motion) {
  const Eigen::Index count = curve.strains.size();
  motion->times.resize(count + 1);
  motion->times << 0.0, motion->forces.times;
  motion->positions.setConstant(3, count + 1, std::numeric_limits<double>::quiet_NaN());
  motion->positions.row(0).tail(count) = 0.5 * curve.widths.transpose();
  motion->sigma = Eigen::VectorXd::Constant(1, 0.5 * curve.width_sigma);
  PlaceMark(curve, strip, motion);
}

// Nobody saw a point, but a recording has one.
void SeeNothing(const TensileStrip& strip, MotionTensors* motion) {
  motion->times = Eigen::VectorXd::LinSpaced(kNumPullSteps + 1, 0.0, kDuration);
  motion->node_index = {strip.nodes[0] / 2 + strip.nodes[0] * (strip.nodes[1] / 2)};
  motion->positions.setConstant(3, motion->times.size(), std::numeric_limits<double>::quiet_NaN());
}

}  // namespace

std::array<int, 2> UsualNodes(const TensileCurve& curve, PullDirection direction) {
  if (direction != PullDirection::kBias) return {kUsualNodes, kUsualNodes};
  const double num_cells = std::round((kUsualNodes - 1) * curve.length / curve.width);
  return {kUsualNodes, static_cast<int>(std::clamp(num_cells + 1.0, 1.0 * kUsualNodes, 1.0 * kMostUsualNodes))};
}

MotionTensors RecordTensileTest(const TensileCurve& curve, const TensileStrip& strip, const std::string& provenance) {
  CheckStrip(strip);
  GridOptions grid;
  grid.nodes = strip.nodes;
  grid.size = {curve.width, curve.length};
  grid.origin = {-0.5 * curve.width, 0.0, 0.0};
  grid.axes = {Eigen::Vector3d::UnitX(), Eigen::Vector3d::UnitZ()};
  MotionTensors motion;
  motion.mesh = MakeGrid(grid);
  HoldClamps(curve, strip, &motion);
  if (curve.widths.size() > 0) {
    SeeWidths(curve, strip, &motion);
  } else {
    SeeNothing(strip, &motion);
  }
  motion.scene_text = SceneOfStrip(curve, strip);
  motion.provenance = provenance;
  ValidateMotionTensors(motion, provenance);
  InterpretMotion(motion, provenance);
  return motion;
}

double InertiaAtClamp(const TensileCurve& curve) {
  const double speed = curve.length * curve.strains[curve.strains.size() - 1] / kDuration;
  return kDensity * curve.width * curve.length / 3.0 * speed / kTimeStep;
}

std::string ParametersOfPull(const TensileStrip& strip, bool has_widths) {
  if (strip.direction == PullDirection::kBias) return "k_shear";
  const std::string name = strip.direction == PullDirection::kWarp ? "warp" : "weft";
  return "k_" + name + (strip.membrane == MembraneLaw::kYarn ? ",stiffening_" + name : "") +
         (has_widths ? ",k_poisson" : "");
}

}  // namespace clothid

#include <Eigen/Core>
#include <algorithm>
#include <cmath>
#include <iomanip>
#include <iostream>
#include <sstream>
#include <string>
#include <vector>

#include "datasets/checking/track_statistics.h"
#include "datasets/motion/motion_file.h"
#include "sim/base/error.h"
#include "sim/base/text_file.h"
#include "tools/motion/motion_commands.h"

namespace clothid {
namespace {

// How a motion covers time and points.
struct Coverage {
  double median_interval = 0.0;   // s
  double longest_interval = 0.0;  // s
  std::vector<int> gaps;          // the frames before them
  long long num_missing = 0;      // points over all frames
  int num_never_seen = 0;         // points
};

Eigen::VectorXd Intervals(const Eigen::VectorXd& times) {
  return times.tail(times.size() - 1) - times.head(times.size() - 1);
}

Coverage Measure(const RecordedMotion& motion) {
  Coverage coverage;
  if (motion.num_frames() > 1) {
    const Eigen::VectorXd intervals = Intervals(motion.times);
    std::vector<double> sorted(intervals.begin(), intervals.end());
    const auto middle = sorted.begin() + static_cast<std::ptrdiff_t>(sorted.size() / 2);
    std::nth_element(sorted.begin(), middle, sorted.end());
    coverage.median_interval = *middle;
    coverage.longest_interval = intervals.maxCoeff();
    for (int frame = 0; frame < intervals.size(); ++frame) {
      if (intervals[frame] > kGapFactor * coverage.median_interval) coverage.gaps.push_back(frame);
    }
  }
  for (int point = 0; point < motion.num_points(); ++point) {
    const auto num_unseen = motion.positions.middleRows<3>(3 * point).colwise().sum().array().isNaN().count();
    coverage.num_missing += num_unseen;
    coverage.num_never_seen += num_unseen == motion.num_frames();
  }
  return coverage;
}

double Percent(long long part, long long whole) {
  return whole > 0 ? 100.0 * static_cast<double>(part) / static_cast<double>(whole) : 0.0;
}

void PrintTensor(const char* name, const char* type, Eigen::Index frames, Eigen::Index rows, Eigen::Index width) {
  if (rows == 0) return;
  std::cout << "  " << name << " " << type << " [";
  if (frames > 0) std::cout << frames << ", ";
  std::cout << rows;
  if (width > 1) std::cout << ", " << width;
  std::cout << "]\n";
}

void PrintForceTensors(const ForceReadings& forces) {
  if (forces.is_empty()) return;
  PrintTensor("handle_forces", "F64", forces.num_readings(), forces.num_groups(), 3);
  if (forces.moments.size() > 0) {
    PrintTensor("handle_moments", "F64", forces.num_readings(), forces.num_groups(), 3);
  }
  PrintTensor("force_times", "F64", 0, forces.num_readings(), 1);
  PrintTensor("force_sigma", "F64", 0, forces.num_groups(), 1);
  if (forces.groups.empty()) return;
  std::size_t num_nodes = 0;
  for (const std::vector<int>& group : forces.groups) num_nodes += group.size();
  PrintTensor("force_nodes", "I32", 0, static_cast<Eigen::Index>(num_nodes), 1);
  PrintTensor("force_offsets", "I32", 0, forces.num_groups() + 1, 1);
}

void PrintSewing(const Mesh& mesh) {
  if (mesh.has_corner_rest()) PrintTensor("corner_rest", "F64", mesh.num_faces(), 3, 2);
  PrintTensor("folds", "I32", 0, static_cast<Eigen::Index>(mesh.folds.size()), 2);
  PrintTensor("link_nodes", "I32", 0, static_cast<Eigen::Index>(mesh.links.size()), 3);
  PrintTensor("link_values", "F64", 0, static_cast<Eigen::Index>(mesh.links.size()), 3);
}

void PrintTensors(const MotionTensors& tensors) {
  const Eigen::Index num_frames = tensors.times.size();
  std::cout << "tensors\n";
  PrintTensor("positions", tensors.single_precision ? "F32" : "F64", num_frames, tensors.positions.rows() / 3, 3);
  PrintTensor("times", "F64", 0, num_frames, 1);
  PrintTensor("rest_positions", "F64", 0, tensors.mesh.num_nodes(), 3);
  PrintTensor("faces", "I32", 0, tensors.mesh.num_faces(), 3);
  PrintSewing(tensors.mesh);
  PrintTensor("node_index", "I32", 0, static_cast<Eigen::Index>(tensors.node_index.size()), 1);
  PrintTensor("face_index", "I32", 0, static_cast<Eigen::Index>(tensors.face_index.size()), 1);
  PrintTensor("barycentric", "F64", 0, tensors.barycentric.cols(), 3);
  PrintTensor("point_kind", "I32", 0, static_cast<Eigen::Index>(tensors.point_kind.size()), 1);
  PrintTensor("handle_index", "I32", 0, static_cast<Eigen::Index>(tensors.handle_index.size()), 1);
  PrintTensor("handle_positions", "F64", tensors.handle_positions.cols(), tensors.handle_positions.rows() / 3, 3);
  PrintTensor("handle_times", "F64", 0, tensors.handle_times.size(), 1);
  PrintTensor("sigma", "F64", 0, tensors.sigma.size(), 1);
  PrintForceTensors(tensors.forces);
  if (tensors.clouds.empty()) return;
  Eigen::Index num_cloud_points = 0;
  for (const Eigen::Matrix3Xd& cloud : tensors.clouds) num_cloud_points += cloud.cols();
  PrintTensor("cloud_positions", tensors.single_precision_clouds ? "F32" : "F64", 0, num_cloud_points, 3);
  PrintTensor("cloud_offsets", "I32", 0, num_frames + 1, 1);
  if (tensors.cloud_sigma > 0.0) PrintTensor("cloud_sigma", "F64", 0, 1, 1);
}

// What few scenes have is told where it is there.
bool IsTold(ParameterKind kind, double value) { return value != 0.0 || RowOf(kind).part == ParameterPart::kPiece; }

void PrintScene(const Scene& scene) {
  const Parameters nominal = scene.nominal_parameters();
  std::cout << "scene\n  nodes " << scene.mesh.num_nodes() << ", faces " << scene.mesh.num_faces() << ", handles "
            << scene.handles.nodes.size() << (scene.handles.path.num_handles() > 0 ? " (moving)" : "");
  if (!scene.handles.clamped.empty()) std::cout << ", clamped at " << scene.handles.clamped.size() << " edges";
  std::cout << "\n  time step " << scene.time_step << " s, " << scene.num_steps() << " steps, integrator "
            << IntegratorName(scene.integrator) << ", contact mode "
            << (scene.contact_mode == ContactMode::kGap ? "gap" : "velocity") << "\n  nominal: density "
            << nominal.material.density << " kg/m^2";
  for (const ParameterKind kind : MaterialKinds()) {
    if (kind == ParameterKind::kDensity || !scene.has(kind)) continue;
    const double value = nominal.material.*RowOf(kind).constant;
    if (!IsTold(kind, value)) continue;
    std::cout << ", " << ParameterName({kind}, {}) << " " << value << " " << RowOf(kind).UnitIn(scene.air_law);
  }
  std::cout << "\n";
  for (const ParameterId id : scene.piece_parameters()) {
    const std::string name = ParameterName(id, {}, scene.mesh.piece_names);
    std::cout << "  " << name << " " << GetParameter(nominal, id) << " " << RowOf(id.kind).UnitIn(scene.air_law)
              << "\n";
  }
  for (size_t i = 0; i < scene.obstacles.size(); ++i) {
    std::cout << "  obstacle " << scene.obstacles[i].name << ": mu " << nominal.friction_coefficients[i]
              << ", contact distance " << scene.obstacles[i].contact_distance << " m\n";
  }
}

}  // namespace

std::string TimeText(double seconds) {
  constexpr int kDigits = 6, kDecimals = 4;
  const double size = std::abs(seconds);
  std::ostringstream text;
  text << std::setprecision(
              std::max(kDigits, kDecimals + (size > 1.0 ? static_cast<int>(std::ceil(std::log10(size))) : 0)))
       << seconds;
  return text.str();
}

void PrintCoverage(const RecordedMotion& motion) {
  const Coverage coverage = Measure(motion);
  const long long num_seen_at_most = static_cast<long long>(motion.num_points()) * motion.num_frames();
  std::cout << "frames " << motion.num_frames() << ", from " << TimeText(motion.times[0]) << " s to "
            << TimeText(motion.times[motion.num_frames() - 1]) << " s";
  if (motion.num_frames() > 1) {
    std::cout << ", rate " << 1.0 / coverage.median_interval << " Hz (median), longest interval "
              << coverage.longest_interval << " s";
  }
  std::cout << "\n";
  PrintClouds(motion);
  std::cout << "points " << motion.num_points() << ", missing " << coverage.num_missing << " of " << num_seen_at_most
            << " (" << Percent(coverage.num_missing, num_seen_at_most) << " %), never seen " << coverage.num_never_seen
            << "\ngaps " << coverage.gaps.size() << " (intervals over " << kGapFactor << " times the median)";
  for (const int frame : coverage.gaps)
    std::cout << (frame == coverage.gaps.front() ? ": after frame " : ", ") << frame;
  std::cout << "\n";
}

int MotionInfo(const std::vector<std::string>& arguments) {
  const std::string& path = arguments.front();
  const MotionTensors tensors = ReadMotionTensors(path);
  const RecordedMotion motion = ReadMotion(path);
  std::cout << Escaped(path) << "\n";
  PrintTensors(tensors);
  PrintCoverage(motion);
  PrintScene(motion.scene);
  std::cout << "provenance " << Escaped(motion.provenance) << "\nsha256 " << motion.sha256 << "\n";
  return kExitSuccess;
}

}  // namespace clothid

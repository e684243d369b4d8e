#include "costs/prediction/alignment.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <map>
#include <optional>
#include <stdexcept>
#include <utility>

#include "sim/base/error.h"
#include "sim/mesh/mesh.h"

namespace clothid {
namespace {

constexpr char kAlignName[] = "align";  // shift and turn

// The measured forces of a group along an axis [F]; empty where there is no such group.
Eigen::VectorXd ForcesAlong(ParameterId id, const ForceReadings& forces) {
  if (forces.is_empty() || id.part >= forces.num_groups()) return {};
  return forces.values.row(3 * static_cast<Eigen::Index>(id.part) + id.axis).transpose();
}

double LargestForce(ParameterId id, const ForceReadings& forces) {
  double largest = 0.0;
  for (const double force : ForcesAlong(id, forces)) {
    if (std::isfinite(force)) largest = std::max(largest, std::abs(force));
  }
  return largest;
}

double MedianFrameInterval(const RecordedMotion& motion) {
  std::vector<double> intervals;
  for (Eigen::Index i = 1; i < motion.times.size(); ++i) intervals.push_back(motion.times[i] - motion.times[i - 1]);
  if (intervals.empty()) return 0.0;
  const auto middle = intervals.begin() + static_cast<std::ptrdiff_t>(intervals.size() / 2);
  std::nth_element(intervals.begin(), middle, intervals.end());
  return *middle;
}

// Of one kind, and of one group of handles if `part` says so.
void AppendAxes(ParameterKind kind, int part, std::vector<std::string>* names) {
  for (int axis = 0; axis < RowOf(kind).num_axes; ++axis) names->push_back(ParameterName({kind, axis, part}, {}));
}

void SetInGroup(int place, int axis, double value, std::vector<Eigen::Vector3d>* vectors) {
  if (static_cast<int>(vectors->size()) <= place) vectors->resize(place + 1, Eigen::Vector3d::Zero());
  (*vectors)[place][axis] = value;
}

}  // namespace

void Alignment::Set(ParameterId id, double value) {
  switch (id.kind) {
    case ParameterKind::kTimeOffset:
      time_offset = value;
      break;
    case ParameterKind::kShift:
      shift[id.axis] = value;
      break;
    case ParameterKind::kTurn:
      turn[id.axis] = value;
      break;
    case ParameterKind::kStartVelocity:
      start_velocity[id.axis] = value;
      break;
    case ParameterKind::kHandleShift:
      SetInGroup(id.part + 1, id.axis, value, &handle_shifts);
      break;
    case ParameterKind::kHandleTurn:
      handle_turn[id.axis] = value;
      break;
    case ParameterKind::kForceBias:
      SetInGroup(id.part, id.axis, value, &force_bias);
      break;
    default:
      throw std::logic_error("no parameter of a recording");
  }
}

Eigen::VectorXd Alignment::ForceBias(int num_groups) const {
  Eigen::VectorXd bias = Eigen::VectorXd::Zero(3 * static_cast<Eigen::Index>(num_groups));
  for (int g = 0; g < std::min(num_groups, static_cast<int>(force_bias.size())); ++g) {
    bias.segment<3>(3 * static_cast<Eigen::Index>(g)) = force_bias[g];
  }
  return bias;
}

std::vector<std::string> ExpandAlignmentNames(const std::vector<std::string>& names) {
  std::vector<std::string> expanded;
  for (const std::string& name : names) {
    const std::optional<ParameterId> first = FindParameter(name + ".x");
    if (name == kAlignName) {
      AppendAxes(ParameterKind::kShift, kWhole, &expanded);
      AppendAxes(ParameterKind::kTurn, kWhole, &expanded);
    } else if (first && IsOfRecording(first->kind)) {
      AppendAxes(first->kind, first->part, &expanded);
    } else {
      expanded.push_back(name);
    }
  }
  return expanded;
}

std::string KnownAlignmentNames() {
  std::string names, of_groups;
  for (const ParameterRow& row : ParameterTable()) {
    if (!IsOfRecording(row.kind)) continue;
    const std::string axes = row.num_axes > 0 ? "[.x|.y|.z]" : "";
    if (row.has_whole) names += (names.empty() ? "" : ", ") + (row.name + axes);
    if (row.kind == ParameterKind::kTimeOffset) names.append(", ").append(kAlignName);
    if (row.part != ParameterPart::kHandleGroup) continue;
    of_groups += ", " + std::string(row.name) + (row.has_whole ? "1" + axes + ", .." : axes);
  }
  return names + of_groups;
}

double DefaultAlignmentRange(ParameterId id, const RecordedMotion& motion) {
  const double range = RowOf(id.kind).range;
  switch (id.kind) {
    case ParameterKind::kTimeOffset:
      return range * MedianFrameInterval(motion);
    case ParameterKind::kShift:
    case ParameterKind::kHandleShift:
      return range * ClothSize(motion.scene.mesh);
    case ParameterKind::kForceBias:
      return range * std::max(LargestForce(id, motion.forces), motion.forces.sigma[id.part]);
    default:
      return range;
  }
}

double LargestAlignmentBound(ParameterId id, const RecordedMotion& motion) {
  if (id.kind == ParameterKind::kTimeOffset) return motion.times[motion.times.size() - 1] - motion.times[0];
  const bool is_turn = id.kind == ParameterKind::kTurn || id.kind == ParameterKind::kHandleTurn;
  return is_turn ? M_PI : std::numeric_limits<double>::infinity();
}

std::vector<std::vector<int>> HandleGroups(const RecordedMotion& motion) {
  if (!motion.forces.groups.empty()) return motion.forces.groups;
  const std::vector<int>& nodes = motion.scene.handles.nodes;
  const Mesh& mesh = motion.scene.mesh;
  std::vector<int> first(static_cast<std::size_t>(mesh.num_nodes()), -1);  // the least handle of a handle's group
  for (const int node : nodes) first[node] = node;
  for (bool changed = true; changed;) {
    changed = false;
    for (int f = 0; f < mesh.num_faces(); ++f) {
      for (int i = 0; i < 3; ++i) {
        int &a = first[mesh.faces(i, f)], &b = first[mesh.faces((i + 1) % 3, f)];
        if (a < 0 || b < 0 || a == b) continue;
        a = b = std::min(a, b);
        changed = true;
      }
    }
  }
  std::map<int, std::vector<int>> groups;
  for (const int node : nodes) groups[first[node]].push_back(node);
  std::vector<std::vector<int>> list;
  for (auto& [least, group] : groups) list.push_back(std::move(group));
  return list;
}

void ExpectMeasured(ParameterId id, const std::string& name, const RecordedMotion& motion) {
  const auto num_handles = static_cast<int>(motion.scene.handles.nodes.size());
  const auto expect = [&](bool condition, const std::string& problem) {
    if (!condition) throw Error(ErrorKind::kUsage, "parameter '" + name + "': " + motion.name + problem);
  };
  if (id.kind == ParameterKind::kHandleShift) {
    expect(num_handles > 0, " has no handles");
    const auto num_groups = static_cast<int>(HandleGroups(motion).size());
    expect(id.part < num_groups,
           " has " + std::to_string(num_groups) + (num_groups == 1 ? " group" : " groups") + " of handles");
  }
  if (id.kind == ParameterKind::kHandleTurn) expect(num_handles > 1, " has not two handles, which alone can turn");
  if (id.kind == ParameterKind::kHandleTurn) {
    expect(motion.scene.handles.clamped.empty(), " has clamps, whose slopes would have to turn with the handles");
  }
  if (id.kind != ParameterKind::kForceBias) return;
  const Eigen::VectorXd forces = ForcesAlong(id, motion.forces);
  if (!forces.array().isNaN().all()) return;
  throw Error(ErrorKind::kUsage, "parameter '" + name + "': " + motion.name + " has no forces along " + "xyz"[id.axis] +
                                     " of group " + std::to_string(id.part + 1) + " of its handles");
}

Eigen::Vector3d TurnCenter(const RecordedMotion& motion) {
  if (motion.centroid) return *motion.centroid;
  Eigen::Vector3d sum = Eigen::Vector3d::Zero(), count = Eigen::Vector3d::Zero();
  for (Eigen::Index i = 0; i < motion.positions.cols(); ++i) {
    for (Eigen::Index row = 0; row < motion.positions.rows(); ++row) {
      if (!std::isfinite(motion.positions(row, i))) continue;
      sum[row % 3] += motion.positions(row, i);
      count[row % 3] += 1.0;
    }
  }
  for (const Eigen::Matrix3Xd& cloud : motion.clouds) {
    sum += cloud.rowwise().sum();
    count.array() += static_cast<double>(cloud.cols());
  }
  return sum.cwiseQuotient(count.cwiseMax(1.0));
}

}  // namespace clothid

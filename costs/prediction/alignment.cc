#include "costs/prediction/alignment.h"

#include <algorithm>
#include <array>
#include <charconv>
#include <cmath>
#include <limits>
#include <map>
#include <string_view>
#include <utility>

#include "sim/base/error.h"
#include "sim/mesh/mesh.h"

namespace clothid {
namespace {

constexpr double kFrameIntervals = 2.0;
constexpr double kShareOfCloth = 0.25;
constexpr double kHandleShareOfCloth = 0.1;
constexpr double kLargestTurn = 0.2;        // rad
constexpr double kLargestStartSpeed = 2.0;  // m/s

constexpr char kTimeOffsetName[] = "time_offset";
constexpr char kAlignName[] = "align";  // shift and turn
constexpr char kForceBiasName[] = "force_bias";
constexpr char kHandleShiftName[] = "handle_shift";
constexpr int kMostGroups = 1000;
constexpr double kHandleShiftSpread = 0.01;  // m
constexpr double kHandleTurnSpread = 0.05;   // rad
constexpr char kAxes[] = "xyz";

struct GroupName {
  const char* name;
  AlignmentKind kind;
};

constexpr std::array<GroupName, 5> kGroups = {{{"shift", AlignmentKind::kShift},
                                               {"turn", AlignmentKind::kTurn},
                                               {"v0", AlignmentKind::kStartVelocity},
                                               {kHandleShiftName, AlignmentKind::kHandleShift},
                                               {"handle_turn", AlignmentKind::kHandleTurn}}};

// K of "NAMEK", from `first` to kMostGroups without leading zeros; nothing for any other text.
std::optional<int> NumberAfter(std::string_view name, std::string_view text, int first) {
  if (text.substr(0, name.size()) != name) return std::nullopt;
  const std::string_view digits = text.substr(name.size());
  int number = 0;
  const auto [end, error] = std::from_chars(digits.data(), digits.data() + digits.size(), number);
  const bool is_number = error == std::errc() && end == digits.data() + digits.size() && digits[0] != '0';
  if (!is_number || number < first || number > kMostGroups) return std::nullopt;
  return number;
}

// What "force_bias", "force_bias2", .. and "handle_shift1", .. are, but for the axis; nothing for any other name.
std::optional<AlignmentId> NumberedGroup(const std::string& name) {
  if (name == kForceBiasName) return AlignmentId{AlignmentKind::kForceBias, 0, 0};
  if (const auto number = NumberAfter(kForceBiasName, name, 2)) {
    return AlignmentId{AlignmentKind::kForceBias, 0, *number - 1};
  }
  if (const auto number = NumberAfter(kHandleShiftName, name, 1)) {
    return AlignmentId{AlignmentKind::kHandleShift, 0, *number};
  }
  return std::nullopt;
}

// The measured forces of a group along an axis [F]; empty where there is no such group.
Eigen::VectorXd ForcesAlong(AlignmentId id, const ForceReadings& forces) {
  if (forces.is_empty() || id.group >= forces.num_groups()) return {};
  return forces.values.row(3 * static_cast<Eigen::Index>(id.group) + id.axis).transpose();
}

double LargestForce(AlignmentId id, const ForceReadings& forces) {
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

void AppendAxes(const std::string& group, std::vector<std::string>* names) {
  for (int axis = 0; axis < 3; ++axis) names->push_back(group + "." + kAxes[axis]);
}

}  // namespace

void Alignment::Set(AlignmentId id, double value) {
  const auto set_of_group = [&](std::vector<Eigen::Vector3d>* vectors) {
    if (static_cast<int>(vectors->size()) <= id.group) vectors->resize(id.group + 1, Eigen::Vector3d::Zero());
    (*vectors)[id.group][id.axis] = value;
  };
  switch (id.kind) {
    case AlignmentKind::kTimeOffset:
      time_offset = value;
      break;
    case AlignmentKind::kShift:
      shift[id.axis] = value;
      break;
    case AlignmentKind::kTurn:
      turn[id.axis] = value;
      break;
    case AlignmentKind::kStartVelocity:
      start_velocity[id.axis] = value;
      break;
    case AlignmentKind::kHandleShift:
      set_of_group(&handle_shifts);
      break;
    case AlignmentKind::kHandleTurn:
      handle_turn[id.axis] = value;
      break;
    case AlignmentKind::kForceBias:
      set_of_group(&force_bias);
      break;
  }
}

Eigen::VectorXd Alignment::ForceBias(int num_groups) const {
  Eigen::VectorXd bias = Eigen::VectorXd::Zero(3 * static_cast<Eigen::Index>(num_groups));
  for (int g = 0; g < std::min(num_groups, static_cast<int>(force_bias.size())); ++g) {
    bias.segment<3>(3 * static_cast<Eigen::Index>(g)) = force_bias[g];
  }
  return bias;
}

std::optional<AlignmentId> ParseAlignmentId(const std::string& name) {
  if (name == kTimeOffsetName) return AlignmentId{AlignmentKind::kTimeOffset, 0};
  for (const GroupName& group : kGroups) {
    for (int axis = 0; axis < 3; ++axis) {
      if (name == std::string(group.name) + "." + kAxes[axis]) return AlignmentId{group.kind, axis};
    }
  }
  if (name.size() > 2 && name[name.size() - 2] == '.') {
    const std::size_t axis = std::string_view(kAxes).find(name.back());
    std::optional<AlignmentId> id = NumberedGroup(name.substr(0, name.size() - 2));
    if (id && axis < 3) {
      id->axis = static_cast<int>(axis);
      return id;
    }
  }
  return std::nullopt;
}

std::vector<std::string> ExpandAlignmentNames(const std::vector<std::string>& names) {
  std::vector<std::string> expanded;
  for (const std::string& name : names) {
    const bool is_align = name == kAlignName;
    bool is_group = false;
    for (const GroupName& group : kGroups) {
      const bool is_rigid = group.kind == AlignmentKind::kShift || group.kind == AlignmentKind::kTurn;
      if (name != group.name && !(is_align && is_rigid)) continue;
      AppendAxes(group.name, &expanded);
      is_group = true;
    }
    if (NumberedGroup(name)) {
      AppendAxes(name, &expanded);
      is_group = true;
    }
    if (!is_group) expanded.push_back(name);
  }
  return expanded;
}

std::string AlignmentGroup(const std::string& name) {
  return ParseAlignmentId(name) ? name.substr(0, name.find('.')) : name;
}

std::string KnownAlignmentNames() {
  std::string names = std::string(kTimeOffsetName) + ", " + kAlignName;
  for (const GroupName& group : kGroups) names += ", " + std::string(group.name) + "[.x|.y|.z]";
  return names + ", " + kHandleShiftName + "1[.x|.y|.z], .., " + kForceBiasName + "[.x|.y|.z]";
}

double DefaultAlignmentRange(AlignmentId id, const RecordedMotion& motion) {
  switch (id.kind) {
    case AlignmentKind::kTimeOffset:
      return kFrameIntervals * MedianFrameInterval(motion);
    case AlignmentKind::kShift:
      return kShareOfCloth * ClothSize(motion.scene.mesh);
    case AlignmentKind::kTurn:
    case AlignmentKind::kHandleTurn:
      return kLargestTurn;
    case AlignmentKind::kStartVelocity:
      return kLargestStartSpeed;
    case AlignmentKind::kHandleShift:
      return kHandleShareOfCloth * ClothSize(motion.scene.mesh);
    case AlignmentKind::kForceBias:
      return std::max(LargestForce(id, motion.forces), motion.forces.sigma[id.group]);
  }
  return 0.0;
}

double LargestAlignmentBound(AlignmentId id, const RecordedMotion& motion) {
  if (id.kind == AlignmentKind::kTimeOffset) return motion.times[motion.times.size() - 1] - motion.times[0];
  const bool is_turn = id.kind == AlignmentKind::kTurn || id.kind == AlignmentKind::kHandleTurn;
  return is_turn ? M_PI : std::numeric_limits<double>::infinity();
}

ParameterPrior DefaultAlignmentPrior(AlignmentId id) {
  if (id.kind == AlignmentKind::kHandleShift) return {0.0, kHandleShiftSpread};
  if (id.kind == AlignmentKind::kHandleTurn) return {0.0, kHandleTurnSpread};
  return {};
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

void ExpectMeasured(AlignmentId id, const std::string& name, const RecordedMotion& motion) {
  const auto num_handles = static_cast<int>(motion.scene.handles.nodes.size());
  const auto expect = [&](bool condition, const std::string& problem) {
    if (!condition) throw Error(ErrorKind::kUsage, "parameter '" + name + "': " + motion.name + problem);
  };
  if (id.kind == AlignmentKind::kHandleShift) {
    expect(num_handles > 0, " has no handles");
    const auto num_groups = static_cast<int>(HandleGroups(motion).size());
    expect(id.group <= num_groups,
           " has " + std::to_string(num_groups) + (num_groups == 1 ? " group" : " groups") + " of handles");
  }
  if (id.kind == AlignmentKind::kHandleTurn) expect(num_handles > 1, " has not two handles, which alone can turn");
  if (id.kind != AlignmentKind::kForceBias) return;
  const Eigen::VectorXd forces = ForcesAlong(id, motion.forces);
  if (!forces.array().isNaN().all()) return;
  throw Error(ErrorKind::kUsage, "parameter '" + name + "': " + motion.name + " has no forces along " + kAxes[id.axis] +
                                     " of group " + std::to_string(id.group + 1) + " of its handles");
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

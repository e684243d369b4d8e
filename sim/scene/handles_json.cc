#include "sim/scene/handles_json.h"

#include <algorithm>
#include <cstddef>
#include <set>

#include "sim/base/error.h"
#include "sim/base/text_file.h"
#include "sim/path/handle_csv.h"
#include "sim/scene/attached_handles.h"
#include "sim/scene/obstacle_json.h"

namespace clothid {
namespace {

using Kind = JsonValue::Kind;

constexpr const char* kForms = "a list of nodes, {\"nodes\": [..], ..}, or a list of these";

std::string List(const std::vector<int>& nodes) {
  std::string list;
  for (const int node : nodes) list += (list.empty() ? "" : ", ") + std::to_string(node);
  return Printable(list);
}

// Of one group, or of several.
std::vector<JsonNode> GroupsOf(const JsonNode& node) {
  if (node.is(Kind::kObject)) return {node};
  if (!node.is(Kind::kArray)) node.Fail(std::string("expected ") + kForms);
  std::vector<JsonNode> items = node.items();
  const bool are_objects = !items.empty() && items.front().is(Kind::kObject);
  return are_objects ? items : std::vector<JsonNode>{node};
}

// That are not among those `seen`, to which they are added.
std::vector<int> ReadNodes(const JsonNode& list, int num_nodes, std::set<int>* seen) {
  std::vector<int> nodes;
  for (const JsonNode& item : list.items()) {
    nodes.push_back(item.Integer(0, num_nodes - 1));
    if (!seen->insert(nodes.back()).second) item.Fail("node " + std::to_string(nodes.back()) + " is listed twice");
  }
  return nodes;
}

// true: as the rest shape says; a direction: that; false: not clamped.
std::optional<Clamp> ReadClamp(const JsonNode& node, const std::vector<int>& nodes) {
  Clamp clamp{nodes};
  if (node.is(Kind::kArray)) {
    clamp.direction = node.Vector3();
    if (clamp.direction->norm() > 0.0) return clamp;
  } else if (node.is(Kind::kBoolean)) {
    return node.Boolean() ? std::optional(clamp) : std::nullopt;
  }
  node.Fail("expected true, or the direction [x, y, z] in which the cloth leaves the clamp at the start");
}

// Of which the last is that of `node`.
void AddClamps(const std::vector<Clamp>& clamps, const JsonNode& node, Scene* scene) {
  std::string problem;
  try {
    return ClampHandles(clamps, scene);
  } catch (const Error& error) {
    problem = error.what();
  }
  node.Fail(problem);
}

}  // namespace

HandlesReader::HandlesReader(const JsonNode& node, const std::string& folder, Scene* scene)
    : is_recorded_(!scene->handles.nodes.empty()) {
  std::set<int> seen;
  for (const JsonNode& group : GroupsOf(node)) ReadGroup(group, folder, scene->mesh.num_nodes(), &seen);
  if (static_cast<int>(seen.size()) == scene->mesh.num_nodes()) {
    node.Fail("expected at least one node that is not a handle");
  }
  if (is_recorded_) {
    const std::vector<int>& recorded = scene->handles.nodes;
    if (seen != std::set<int>(recorded.begin(), recorded.end())) {
      node.Fail("expected the handles of the recording: " + List(recorded));
    }
    return;
  }
  for (const Group& group : groups_) {
    scene->handles.nodes.insert(scene->handles.nodes.end(), group.nodes.begin(), group.nodes.end());
  }
}

void HandlesReader::ReadGroup(const JsonNode& node, const std::string& folder, int num_nodes, std::set<int>* seen) {
  if (!node.is(Kind::kObject)) {
    groups_.push_back({node, ReadNodes(node, num_nodes, seen), {}, nullptr, {}, {}});
    return;
  }
  node.ExpectKeys({"nodes", "path", "attach", "poses", "clamp"});
  Group group{node,
              ReadNodes(node.Require("nodes", "a list of nodes"), num_nodes, seen),
              {},
              nullptr,
              node.Find("attach"),
              node.Find("clamp")};
  const auto path = node.Find("path"), poses = node.Find("poses");
  if ((path ? 1 : 0) + (poses ? 1 : 0) + (group.attach ? 1 : 0) > 1) {
    node.Fail("expected one of \"path\", \"poses\" and \"attach\"");
  }
  if (path) {
    const std::string file = path->Path(folder);
    if (!is_recorded_) group.path = ReadHandleCsv(file, static_cast<int>(group.nodes.size()));
  }
  if (poses) group.body = ReadBodyPath(*poses, folder);
  groups_.push_back(std::move(group));
}

void HandlesReader::PutOnPaths(Scene* scene) const {
  for (const Group& group : groups_) {
    if (group.path.num_handles() == 0) continue;
    const Eigen::VectorXd start = group.path.At(scene->start_time);
    for (std::size_t i = 0; i < group.nodes.size(); ++i) {
      scene->initial_positions.segment<3>(3 * static_cast<Eigen::Index>(group.nodes[i])) =
          start.segment<3>(3 * static_cast<Eigen::Index>(i));
    }
  }
}

std::shared_ptr<const RigidPath> HandlesReader::BodyOf(const Group& group, const Scene& scene) {
  if (!group.attach) return group.body;
  for (const SceneObstacle& obstacle : scene.obstacles) {
    if (obstacle.name == group.attach->String() && obstacle.path != nullptr) return obstacle.path;
  }
  group.attach->Fail("expected the name of an obstacle that has a path");
}

void HandlesReader::Attach(Scene* scene) {
  std::vector<std::vector<int>> nodes;
  std::vector<HandlePath> paths;
  for (Group& group : groups_) {
    if (group.body != nullptr) scene->handles.bodies.push_back(group.body);
    group.body = BodyOf(group, *scene);
    nodes.push_back(group.nodes);
    paths.push_back(group.body == nullptr || is_recorded_ ? group.path
                                                          : AttachedPath(*scene, group.nodes, *group.body));
  }
  if (!is_recorded_) scene->handles.path = JoinPaths(*scene, nodes, paths);
  std::vector<Clamp> clamps;
  for (const Group& group : groups_) {
    std::optional<Clamp> clamp = group.clamp ? ReadClamp(*group.clamp, group.nodes) : std::nullopt;
    if (!clamp) continue;
    clamp->body = group.body;
    clamps.push_back(std::move(*clamp));
    AddClamps(clamps, *group.clamp, scene);
  }
}

}  // namespace clothid

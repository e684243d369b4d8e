#include "sim/scene/obstacle_json.h"

#include <algorithm>
#include <set>
#include <string>
#include <utility>

#include "sim/base/error.h"
#include "sim/path/pose_csv.h"
#include "sim/scene/sequence_json.h"
#include "sim/scene/shape_json.h"

namespace clothid {
namespace {

// Names stand in flags ("mu.NAME"), so they must not hold what separates flags.
void CheckName(const JsonNode& name, std::set<std::string>* names) {
  const auto is_allowed = [](char c) {
    return (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z') || (c >= '0' && c <= '9') || c == '_' || c == '-';
  };
  const std::string& text = name.String();
  if (text.empty() || !std::all_of(text.begin(), text.end(), is_allowed)) {
    name.Fail("expected a name of letters, digits, '_' and '-'");
  }
  if (!names->insert(text).second) name.Fail("expected a name that no other obstacle has");
}

std::string UniqueName(const std::string& type, std::set<std::string>* names) {
  std::string name = type;
  for (int i = 2; !names->insert(name).second; ++i) name = type + std::to_string(i);
  return name;
}

// Rows time, x, y, z, qx, qy, qz, qw.
RigidPath ReadRows(const JsonNode& list) {
  constexpr std::size_t kNumbers = 8;
  const std::vector<JsonNode> rows = list.items();
  Eigen::MatrixXd table(kNumbers, static_cast<Eigen::Index>(rows.size()));
  for (std::size_t i = 0; i < rows.size(); ++i) {
    const std::vector<JsonNode> numbers = rows[i].items();
    if (numbers.size() != kNumbers) rows[i].Fail("expected [time, x, y, z, qx, qy, qz, qw]");
    for (std::size_t k = 0; k < kNumbers; ++k) table(k, i) = numbers[k].Number();
  }
  return PathOfTable(table);
}

}  // namespace

std::shared_ptr<const RigidPath> ReadBodyPath(const JsonNode& node, const std::string& folder) {
  std::string problem;
  try {
    const bool is_file = node.is(JsonValue::Kind::kString);
    return std::make_shared<RigidPath>(is_file ? ReadPoseCsv(node.Path(folder)) : ReadRows(node));
  } catch (const Error& error) {
    if (node.is(JsonValue::Kind::kString) || error.kind() != ErrorKind::kBadData) throw;
    problem = error.what();
  }
  node.Fail(problem);
}

std::vector<SceneObstacle> ReadObstacles(const JsonNode& list, const RecordedSequences& recorded,
                                         const std::string& folder) {
  if (list.items().size() > kMaxObstacles) {
    list.Fail("expected at most " + std::to_string(kMaxObstacles) + " obstacles");
  }
  std::set<std::string> names;
  for (const JsonNode& node : list.items()) {
    if (const auto name = node.Find("name")) CheckName(*name, &names);
  }
  std::vector<SceneObstacle> obstacles;
  for (const JsonNode& node : list.items()) {
    SceneObstacle obstacle;
    obstacle.shape = ReadShape(node, folder);
    if (const auto mu = node.Find("mu")) obstacle.friction_coefficient = mu->NonNegativeNumber();
    if (const auto distance = node.Find("contact_distance")) obstacle.contact_distance = distance->NonNegativeNumber();
    if (const auto path = node.Find("path")) obstacle.path = ReadBodyPath(*path, folder);
    const auto name = node.Find("name");
    obstacle.name = name ? name->String() : UniqueName(node.Find("type")->String(), &names);
    if (const auto sequence = node.Find("sequence")) {
      if (obstacle.path != nullptr) sequence->Fail("expected none beside \"path\": frames are in world axes");
      const auto own = recorded.find(obstacle.name);
      const Eigen::MatrixXd* positions = own == recorded.end() ? nullptr : &own->second;
      obstacle.sequence = ReadSequence(*sequence, *obstacle.shape, positions, folder);
    }
    obstacles.push_back(std::move(obstacle));
  }
  return obstacles;
}

}  // namespace clothid

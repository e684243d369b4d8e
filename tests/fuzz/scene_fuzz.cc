// scene.json, with the files that it may name (scene_files/), and its text once the surfaces stand in it.
#include <optional>
#include <vector>

#include "datasets/motion/scene_text.h"
#include "sim/base/json_document.h"
#include "sim/scene/scene_json.h"
#include "tests/fuzz/fuzz_target.h"

namespace clothid {
namespace {

constexpr char kSource[] = "scene.json";
constexpr char kFolder[] = CLOTHID_SOURCE_DIR "/tests/fuzz/scene_files";

// Up to the limit on nodes a grid takes seconds, which buys nothing: tests/sim/scene/scene_json_test.cc tries that
// limit.
bool HasLargeGrid(const std::string& text) {
  constexpr long long kLarge = 64;  // nodes
  const JsonValue document = ParseJson(text, kSource);
  std::optional<JsonNode> node = JsonNode(document, kSource);
  for (const char* key : {"mesh", "grid", "nodes"}) {
    if (!node->is(JsonValue::Kind::kObject)) return false;
    node = node->Find(key);
    if (!node) return false;
  }
  if (!node->is(JsonValue::Kind::kArray) || node->items().size() != 2) return false;
  double num_nodes = 1.0;
  for (const JsonNode& item : node->items()) num_nodes *= item.is(JsonValue::Kind::kNumber) ? item.Number() : 0.0;
  return num_nodes > kLarge && num_nodes <= kMaxNodes;
}

}  // namespace
}  // namespace clothid

int clothid::FuzzScene(const std::uint8_t* data, std::size_t size) {
  const std::string text(AsText(data, size));
  bool is_large = false;
  if (!Accepts([&] { is_large = HasLargeGrid(text); }, kSource) || is_large) return 0;
  Scene scene;
  // A file that the scene names stands in the message itself.
  if (!Accepts([&] { scene = ParseScene(text, kSource, kFolder); }, "")) return 0;
  Check(scene.num_steps() >= 1, "at least one step");
  const std::string whole = WithInlineLists(text, scene);
  Check(Accepts([&] { ParseScene(whole, kSource, kFolder); }, kSource), "a text with surfaces that reads back");
  return 0;
}

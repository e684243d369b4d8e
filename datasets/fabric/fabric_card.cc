#include "datasets/fabric/fabric_card.h"

#include <algorithm>
#include <cmath>
#include <map>
#include <nlohmann/json.hpp>
#include <optional>

#include "sim/base/json_document.h"
#include "sim/base/text_file.h"
#include "sim/scene/parameters.h"

namespace clothid {
namespace {

using Json = nlohmann::ordered_json;

constexpr char kCardSchema[] = "clothid.fabric/1";
constexpr double kNormal95Width = 2.0 * 1.96;  // standard deviations
// A prior is a factor above 1 even where a recording without noise told all.
constexpr double kLeastSpread = 1e-6;

const std::map<std::string, KnownBy>& KnownWords() {
  static const std::map<std::string, KnownBy> words = {
      {"fitted", KnownBy::kFitted}, {"believed", KnownBy::kBelieved}, {"assumed", KnownBy::kAssumed}};
  return words;
}

const std::map<std::string, MembraneLaw>& MembraneWords() {
  static const std::map<std::string, MembraneLaw> words = {
      {"arap", MembraneLaw::kArap}, {"orthotropic", MembraneLaw::kOrthotropic}, {"yarn", MembraneLaw::kYarn}};
  return words;
}

template <typename Value>
const char* WordOf(const std::map<std::string, Value>& words, Value value) {
  return std::find_if(words.begin(), words.end(), [&](const auto& word) { return word.second == value; })
      ->first.c_str();
}

template <typename Value>
Value ReadWord(const JsonNode& node, const std::map<std::string, Value>& words) {
  const auto found = node.is(JsonValue::Kind::kString) ? words.find(node.String()) : words.end();
  if (found != words.end()) return found->second;
  std::string all;
  for (const auto& [word, value] : words) all += (all.empty() ? "\"" : ", \"") + word + "\"";
  node.Fail("expected one of " + all);
}

Json ConstantJson(const CardConstant& constant) {
  Json json = {{"value", constant.value},
               {"unit", RowOf(constant.kind).unit},
               {"known", WordOf(KnownWords(), constant.known_by)},
               {"lower95", constant.lower95},
               {"upper95", constant.upper95},
               {"scatter", constant.scatter},
               {"seen", nullptr}};
  const char* quantity = SeenQuantity(constant.kind);
  if (quantity != nullptr && !std::isnan(constant.seen_from)) {
    json["seen"] = {{"quantity", quantity}, {"from", constant.seen_from}, {"to", constant.seen_to}};
  }
  return json;
}

double NumberOrNull(const JsonNode& object, const char* key) {
  const JsonNode node = object.Require(key, "a number or null");
  return node.is(JsonValue::Kind::kNull) ? std::nan("") : node.Number();
}

void ReadSeen(const JsonNode& node, CardConstant* constant) {
  if (node.is(JsonValue::Kind::kNull)) return;
  node.ExpectKeys({"quantity", "from", "to"});
  const char* expected = SeenQuantity(constant->kind);
  if (expected == nullptr) node.Fail("expected null");
  const JsonNode quantity = node.Require("quantity", "a text");
  if (quantity.String() != expected) quantity.Fail(std::string("expected \"") + expected + "\"");
  constant->seen_from = node.Require("from", "a number").Number();
  constant->seen_to = node.Require("to", "a number").Number();
  if (constant->seen_from > constant->seen_to) node.Fail("expected from <= to");
}

void ReadInterval(const JsonNode& node, CardConstant* constant) {
  constant->lower95 = NumberOrNull(node, "lower95");
  constant->upper95 = NumberOrNull(node, "upper95");
  const bool is_logarithmic = IsLogarithmic(constant->kind);
  if (!constant->is_told()) {
    if (!std::isnan(constant->lower95) || !std::isnan(constant->upper95)) {
      node.Fail("expected lower95 and upper95 null, as it is \"assumed\"");
    }
    return;
  }
  if (!(constant->lower95 < constant->upper95) || (is_logarithmic && !(constant->lower95 > 0.0))) {
    node.Fail(std::string("expected ") + (is_logarithmic ? "0 < " : "") + "lower95 < upper95");
  }
  if (is_logarithmic && !(constant->value > 0.0)) node.Require("value", "").Fail("expected a number > 0");
}

// Whether a scene of that law has such a constant.
bool IsOfMembrane(MembraneLaw law, ParameterNeed need) {
  if (need == ParameterNeed::kArapMembrane) return law == MembraneLaw::kArap;
  if (need == ParameterNeed::kOrthotropicMembrane) return law != MembraneLaw::kArap;
  return need != ParameterNeed::kYarnMembrane || law == MembraneLaw::kYarn;
}

CardConstant ReadConstant(const JsonNode& node, const std::string& name, MembraneLaw membrane) {
  const std::optional<ParameterId> id = FindParameter(name);
  if (!id || !IsOfFabric(id->kind) || !IsOfMembrane(membrane, RowOf(id->kind).need)) {
    node.Fail(std::string("expected a constant of a cloth with \"membrane\": \"") + MembraneName(membrane) + "\"");
  }
  node.ExpectKeys({"value", "unit", "known", "lower95", "upper95", "scatter", "seen"});
  CardConstant constant;
  constant.kind = id->kind;
  const ParameterRow& row = RowOf(id->kind);
  const JsonNode value = node.Require("value", "a number");
  constant.value = value.Number();
  if (!IsInDomain(row.domain, constant.value)) value.Fail(std::string("expected ") + DomainWords(row.domain));
  const JsonNode unit = node.Require("unit", "a text");
  if (unit.String() != row.unit) unit.Fail(std::string("expected \"") + row.unit + "\"");
  constant.known_by = ReadWord(node.Require("known", "a text"), KnownWords());
  ReadInterval(node, &constant);
  constant.scatter = NumberOrNull(node, "scatter");
  if (constant.scatter < 0.0) node.Require("scatter", "").Fail("expected a number >= 0 or null");
  ReadSeen(node.Require("seen", "an object or null"), &constant);
  return constant;
}

CardRecording ReadCardRecording(const JsonNode& node) {
  node.ExpectKeys({"name", "sha256", "kind", "nodes", "edge_m", "time_step_s", "load_N"});
  CardRecording recording;
  recording.name = node.Require("name", "a text").String();
  recording.sha256 = node.Require("sha256", "a text").String();
  recording.kind = node.Require("kind", "a text").String();
  recording.num_nodes = node.Require("nodes", "an integer").Integer(1, kMaxNodes);
  recording.edge_length = node.Require("edge_m", "a number > 0").PositiveNumber();
  recording.time_step = node.Require("time_step_s", "a number > 0").PositiveNumber();
  recording.load = NumberOrNull(node, "load_N");
  return recording;
}

// All constants of the membrane or of bending, or none: a scene needs them together.
void ExpectWhole(const JsonNode& constants, const FabricCard& card) {
  const auto has = [&](ParameterKind kind) { return card.Find(kind) != nullptr; };
  const auto expect = [&](std::initializer_list<ParameterKind> kinds) {
    if (std::none_of(kinds.begin(), kinds.end(), has)) return;
    for (const ParameterKind kind : kinds) constants.Require(RowOf(kind).name, "an object, beside the others");
  };
  expect({ParameterKind::kWarpStiffness, ParameterKind::kWeftStiffness, ParameterKind::kShearStiffness});
  expect({ParameterKind::kWarpBending, ParameterKind::kWeftBending, ParameterKind::kTwistBending});
  if (has(ParameterKind::kBendingStiffness) && has(ParameterKind::kWarpBending)) {
    constants.Find("k_bend")->Fail("expected none beside 'bend_warp'");
  }
}

}  // namespace

ParameterPrior CardConstant::Prior() const {
  const bool is_logarithmic = IsLogarithmic(kind);
  const double width = is_logarithmic ? std::log(upper95 / lower95) : upper95 - lower95;
  const double spread = std::hypot(width / kNormal95Width, std::isnan(scatter) ? 0.0 : scatter);
  return {value, is_logarithmic ? std::exp(std::max(spread, kLeastSpread)) : spread};
}

void CardConstant::Believe(const ParameterPrior& prior) {
  known_by = KnownBy::kBelieved;
  value = prior.center;
  const bool is_logarithmic = IsLogarithmic(kind);
  const double half = 0.5 * kNormal95Width * (is_logarithmic ? std::log(prior.spread) : prior.spread);
  lower95 = is_logarithmic ? value * std::exp(-half) : value - half;
  upper95 = is_logarithmic ? value * std::exp(half) : value + half;
}

const CardConstant* FabricCard::Find(ParameterKind kind) const {
  const auto found = std::find_if(constants.begin(), constants.end(),
                                  [&](const CardConstant& constant) { return constant.kind == kind; });
  return found == constants.end() ? nullptr : &*found;
}

bool FabricCard::tells_any() const {
  return std::any_of(constants.begin(), constants.end(),
                     [](const CardConstant& constant) { return constant.is_told(); });
}

const char* MembraneName(MembraneLaw law) { return WordOf(MembraneWords(), law); }

bool IsOfFabric(ParameterKind kind) {
  const ParameterTerm term = RowOf(kind).term;
  return kind == ParameterKind::kDensity || term == ParameterTerm::kMembrane || term == ParameterTerm::kBending ||
         term == ParameterTerm::kDamping;
}

const char* SeenQuantity(ParameterKind kind) {
  const ParameterTerm term = RowOf(kind).term;
  return term == ParameterTerm::kMembrane ? "strain" : term == ParameterTerm::kBending ? "curvature_1_m" : nullptr;
}

std::string FabricCardJson(const FabricCard& card) {
  Json json = {{"schema", kCardSchema},
               {"clothid", card.program},
               {"membrane", MembraneName(card.membrane)},
               {"bend_poisson", card.bend_poisson},
               {"constants", Json::object()},
               {"recordings", Json::array()}};
  for (const CardConstant& constant : card.constants) {
    json["constants"][RowOf(constant.kind).name] = ConstantJson(constant);
  }
  for (const CardRecording& recording : card.recordings) {
    json["recordings"].push_back({{"name", recording.name},
                                  {"sha256", recording.sha256},
                                  {"kind", recording.kind},
                                  {"nodes", recording.num_nodes},
                                  {"edge_m", recording.edge_length},
                                  {"time_step_s", recording.time_step},
                                  {"load_N", recording.load}});
  }
  for (const CardForce& force : card.missing_forces) {
    json["missing_force"].push_back({{"deviation_N_m2", force.deviation},
                                     {"time_s", force.time},
                                     {"length_m", force.length},
                                     {"factor", force.factor}});
  }
  return json.dump(2, ' ', false, Json::error_handler_t::replace) + "\n";
}

bool IsFabricCard(const JsonNode& root) {
  const auto schema = root.Find("schema");
  return schema && schema->is(JsonValue::Kind::kString) && schema->String() == kCardSchema;
}

FabricCard ReadFabricCard(const std::string& path) {
  const JsonValue document = ParseJson(ReadText(path, kMaxJsonBytes), path);
  return ParseFabricCard(JsonNode(document, path));
}

FabricCard ParseFabricCard(const JsonNode& root) {
  const std::string expected = std::string("\"") + kCardSchema + "\", the card of a fit";
  const JsonNode schema = root.Require("schema", expected);
  if (!IsFabricCard(root)) schema.Fail("expected " + expected);
  root.ExpectKeys({"schema", "clothid", "membrane", "bend_poisson", "constants", "recordings", "missing_force"});
  FabricCard card;
  card.program = root.Require("clothid", "a text").String();
  card.membrane = ReadWord(root.Require("membrane", "a text"), MembraneWords());
  const JsonNode poisson = root.Require("bend_poisson", "a number between -1 and 1");
  card.bend_poisson = poisson.Number();
  if (!(std::abs(card.bend_poisson) < 1.0)) poisson.Fail("expected a number between -1 and 1");
  const JsonNode constants = root.Require("constants", "an object");
  for (const std::string& name : constants.keys()) {
    card.constants.push_back(ReadConstant(*constants.Find(name), name, card.membrane));
  }
  ExpectWhole(constants, card);
  for (const JsonNode& item : root.Require("recordings", "a list").items()) {
    card.recordings.push_back(ReadCardRecording(item));
  }
  if (const auto forces = root.Find("missing_force")) {
    const bool is_one = forces->is(JsonValue::Kind::kObject);
    for (const JsonNode& force : is_one ? std::vector<JsonNode>{*forces} : forces->items()) {
      force.ExpectKeys({"deviation_N_m2", "time_s", "length_m", "factor"});
      const auto number = [&](const char* key) { return force.Require(key, "a positive number").PositiveNumber(); };
      card.missing_forces.push_back({number("deviation_N_m2"), number("time_s"), number("length_m"), number("factor")});
    }
  }
  return card;
}

}  // namespace clothid

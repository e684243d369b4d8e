// The small languages of flags. The first byte chooses the flag.
#include <array>
#include <functional>

#include "costs/field/field_request.h"
#include "costs/prediction/parameter_block.h"
#include "costs/prediction/robust_loss.h"
#include "identify/base/options.h"
#include "sim/base/text_file.h"
#include "sim/scene/scene_json.h"
#include "tests/fuzz/fuzz_target.h"
#include "tools/landscape/landscape_plan.h"
#include "tools/landscape/scene_variant.h"

namespace clothid {
namespace {

constexpr char kScene[] = R"({"clothid_scene": 1, "duration": 1, "gravity": [0, 0, -9.81],
  "mesh": {"grid": {"nodes": [3, 3], "size": [0.3, 0.3]}}, "handles": [0],
  "obstacles": [{"name": "ball", "type": "sphere", "center": [0, 0, 0], "radius": 0.2},
                {"type": "plane", "point": [0, 0, 0], "normal": [0, 0, 1], "mu": 0.3}],
  "parameters": {"mu.ball": {"nominal": 0.2}, "k_stretch": {"nominal": 100, "lower": 1, "upper": 1e6}}})";

const Scene& OwnScene() {
  static const Scene scene = ParseScene(kScene, "scene", "");
  return scene;
}

// Names come back from their variant; a scene that was changed is still one, or is refused as a scene.
void ReadSweep(const std::string& text) {
  constexpr std::size_t kMaxTried = 4;  // variants
  const std::vector<SceneVariant> variants = ParseSweep(text);
  for (std::size_t i = 0; i < std::min(variants.size(), kMaxTried); ++i) {
    const std::string name = VariantName(variants[i]);
    Check(VariantName(ParseSweep(name).at(0)) == name, "a name that gives the variant back");
    const std::string changed = ChangeScene(kScene, OwnScene().obstacle_names(), variants[i]);
    Accepts([&] { ParseScene(changed, "scene", ""); }, "scene");
  }
}

void ReadParameter(const std::string& text) {
  const std::vector<std::string> names = OwnScene().obstacle_names();
  Check(ParameterName(ParseParameter(text, names), names) == text, "the same name");
}

// Names of a recording's own parameters, groups of them and suffixes; a block has the name that it was made of.
void ReadRecordingParameter(const std::string& text) {
  RecordedMotion motion;
  motion.scene = OwnScene();
  motion.times = Eigen::Vector2d(0.0, 0.1);
  motion.points = {ObservedPoint()};  // node 0
  motion.positions = Eigen::MatrixXd::Zero(3, 2);
  for (const std::string& name : ExpandAlignmentNames(ParseNames(text, "parameter"))) {
    const std::vector<std::string> names = OverrideNames(name);
    Check(names.front() == name && names.size() <= 4, "the name itself first");
    const ParameterBlock block = MakeParameterBlock(name, motion, {});
    Check(block.name == name && block.lower_bound < block.upper_bound, "a block of that name");
  }
}

void ReadPlan(const std::string& text) {
  const std::vector<std::string> parts = Split(text, ' ');
  LandscapeFlags flags;
  std::string* const fields[] = {&flags.x, &flags.y, &flags.zoom, &flags.zoom_around, &flags.contact, &flags.sweep};
  for (std::size_t i = 0; i < std::min(parts.size(), std::size(fields)); ++i) *fields[i] = parts[i];
  const LandscapePlan plan = MakeLandscapePlan(flags, OwnScene());
  Check(plan.num_cells() > 0 && plan.num_cells() <= kMaxLandscapeCells, "a number of cells within its limit");
}

void ReadSigma(const std::string& text) {
  ReadMotionOptions options;
  ParseSigma(text, &options);
  Check(options.sigma_source != SigmaSource::kGiven || options.sigma > 0.0, "a sigma that is positive");
}

struct Flag {
  std::function<void(const std::string& text)> read;
  const char* name;  // in every message
};

const std::array kFlags = {
    Flag{[](const std::string& text) { ParseParameterValues(text, "--set"); }, "--set"},
    Flag{[](const std::string& text) { ParseNames(text, "--fit"); }, "--fit"},
    Flag{ReadParameter, "parameter"},
    Flag{ReadSweep, "--sweep"},
    Flag{ReadPlan, "--"},
    Flag{[](const std::string& text) { ParseShard(text); }, "--shard"},
    Flag{[](const std::string& text) { ParseRobustLoss(text); }, "loss"},
    Flag{[](const std::string& text) { ParseAdjointOptions(text); }, "--adjoint"},
    Flag{[](const std::string& text) { ParseJacobianMethod(text); }, "--jacobian"},
    Flag{[](const std::string& text) { ParseFitPrecision(text); }, "--precision"},
    Flag{ReadRecordingParameter, "parameter"},
    Flag{ReadSigma, "--sigma"},
    Flag{[](const std::string& text) { ParseStartSource(text); }, "--initial"},
    Flag{[](const std::string& text) { ParseFieldRequests(text); }, "--field"},
    Flag{[](const std::string& text) { ParseParameterPriors(text, "--prior"); }, "--prior"},
};

}  // namespace
}  // namespace clothid

int clothid::FuzzFlags(const std::uint8_t* data, std::size_t size) {
  if (size == 0) return 0;
  const Flag& flag = kFlags[data[0] % kFlags.size()];
  Accepts([&] { flag.read(std::string(AsText(data + 1, size - 1))); }, flag.name);
  return 0;
}

#include "tools/landscape/landscape_plan.h"

#include <algorithm>
#include <functional>
#include <map>
#include <optional>
#include <utility>

#include "costs/prediction/alignment.h"
#include "sim/base/error.h"
#include "sim/base/text_file.h"
#include "sim/scene/parameters.h"
#include "tools/landscape/landscape_axis.h"

namespace clothid {
namespace {

[[noreturn]] void FailOnFlag(const std::string& flag, const std::string& problem) {
  throw Error(ErrorKind::kUsage, flag + ": " + problem);
}

LandscapeWindow ParseWhole(const LandscapeFlags& flags, const Scene& scene) {
  if (flags.x.empty()) FailOnFlag("--x", "is missing; see landscape --help");
  if (flags.y.empty()) FailOnFlag("--y", "is missing; see landscape --help");
  LandscapeWindow whole;
  const std::vector<std::string> obstacles = scene.obstacle_names();
  const std::vector<std::string>& pieces = scene.mesh.piece_names;
  whole.x = ParseAxis(flags.x, "--x", obstacles, pieces);
  whole.y = ParseAxis(flags.y, "--y", obstacles, pieces);
  const ParameterId x = ParseParameter(whole.x.parameter, obstacles, pieces);
  const ParameterId y = ParseParameter(whole.y.parameter, obstacles, pieces);
  if (x == y) FailOnFlag("--y", "'" + whole.y.parameter + "' is on --x already");
  if (Includes(x, y) || Includes(y, x)) {
    FailOnFlag("--y", "'" + whole.y.parameter + "' and '" + whole.x.parameter + "' on --x include each other");
  }
  return whole;
}

// Falling, each in (0, 1).
std::vector<double> ParseZooms(const std::string& text) {
  std::vector<double> zooms;
  for (const std::string& item : Split(text, ',')) {
    const std::optional<double> zoom = ParseNumber(item);
    if (!zoom || !(*zoom > 0.0) || !(*zoom < 1.0)) {
      FailOnFlag("--zoom", "'" + Printable(item) + "': expected a number between 0 and 1");
    }
    zooms.push_back(*zoom);
  }
  std::sort(zooms.begin(), zooms.end(), std::greater<>());
  const auto twice = std::adjacent_find(zooms.begin(), zooms.end());
  if (twice != zooms.end()) FailOnFlag("--zoom", ShortestText(*twice) + " is there twice");
  return zooms;
}

double CenterOn(const LandscapeAxis& axis, const std::map<std::string, double>& centers) {
  const auto found = centers.find(axis.parameter);
  if (found == centers.end()) FailOnFlag("--zoom_around", "expected a value of '" + axis.parameter + "'");
  if (!(found->second >= axis.lower && found->second <= axis.upper)) {
    FailOnFlag("--zoom_around", "'" + axis.parameter + "': expected a value from " + ShortestText(axis.lower) + " to " +
                                    ShortestText(axis.upper));
  }
  return found->second;
}

std::vector<LandscapeWindow> ParseWindows(const LandscapeFlags& flags, const LandscapeWindow& whole) {
  std::vector<LandscapeWindow> windows;
  if (!flags.zoom_only) windows.push_back(whole);
  if (flags.zoom.empty()) {
    if (flags.zoom_only) FailOnFlag("--zoom_only", "expected with --zoom");
    if (!flags.zoom_around.empty()) FailOnFlag("--zoom_around", "expected with --zoom");
    return windows;
  }
  if (flags.zoom_around.empty()) FailOnFlag("--zoom", "expected with --zoom_around");
  const std::map<std::string, double> centers = ParseParameterValues(flags.zoom_around, "--zoom_around");
  const double x = CenterOn(whole.x, centers), y = CenterOn(whole.y, centers);
  if (centers.size() != 2) FailOnFlag("--zoom_around", "expected values of the parameters on the axes alone");
  for (const double zoom : ParseZooms(flags.zoom)) {
    windows.push_back({zoom, ZoomInto(whole.x, x, zoom, "--zoom"), ZoomInto(whole.y, y, zoom, "--zoom")});
  }
  return windows;
}

std::vector<ContactMode> ParseContact(const std::string& text, ContactMode own) {
  if (text.empty()) return {own};
  if (text == "gap") return {ContactMode::kGap};
  if (text == "velocity") return {ContactMode::kVelocity};
  if (text == "both") return {ContactMode::kGap, ContactMode::kVelocity};
  FailOnFlag("--contact", "'" + Printable(text) + "': expected gap, velocity or both");
}

std::vector<LandscapeSetting> ParseSettings(const LandscapeFlags& flags, const Scene& scene) {
  const std::vector<ContactMode> modes = ParseContact(flags.contact, scene.contact_mode);
  std::vector<LandscapeSetting> settings;
  for (const SceneVariant& variant : ParseSweep(flags.sweep)) {
    for (const ContactMode mode : modes) settings.push_back({VariantName(variant), mode});
  }
  return settings;
}

void CheckNumCells(const LandscapeWindow& whole, std::size_t num_settings, std::size_t num_zooms) {
  const double num_cells = static_cast<double>(whole.x.num_cells) * whole.y.num_cells *
                           static_cast<double>(num_settings) * static_cast<double>(num_zooms + 1);
  if (num_cells > kMaxLandscapeCells) {
    FailOnFlag("--x, --y", "expected at most " + std::to_string(kMaxLandscapeCells) +
                               " cells over all settings and windows, not " + ShortestText(num_cells));
  }
}

// What cells set with this parameter, as the scene has it.
std::vector<double> ValuesOf(const std::string& parameter, const Scene& scene) {
  const ParameterId id = ParseParameter(parameter, scene);
  const Parameters nominal = scene.nominal_parameters();
  if (id.kind == ParameterKind::kFriction && id.part == kWhole) return nominal.friction_coefficients;
  std::vector<double> values = {GetParameter(nominal, id)};
  double Material::*const constant = RowOf(id.kind).constant;
  for (const Material& piece : nominal.pieces) {
    if (constant != nullptr && id.part == kWhole) values.push_back(piece.*constant);
  }
  return values;
}

// `own`: the scene that the sweep changes. Throws `Error` (kUsage), naming --sweep, where it changes what is on an axis
// or held: every cell sets that itself.
void CheckSweep(const LandscapeScanOptions& scan, const Scene& own) {
  const LandscapeWindow& window = scan.plan.windows.front();
  std::vector<std::pair<std::string, std::string>> set = {{window.x.parameter, "is on --x"},
                                                          {window.y.parameter, "is on --y"}};
  for (const auto& [name, value] : scan.held) {
    const auto own_id = FindParameter(name);
    if (!own_id || !IsOfRecording(own_id->kind)) set.emplace_back(name, "--result holds");
  }
  for (std::size_t i = 0; i < scan.motions.size(); ++i) {
    for (const auto& [name, reason] : set) {
      if (ValuesOf(name, scan.motions[i].scene) == ValuesOf(name, own)) continue;
      FailOnFlag("--sweep", "'" + scan.plan.settings[i].name + "': changes '" + name + "', which " + reason);
    }
  }
}

}  // namespace

LandscapePlan MakeLandscapePlan(const LandscapeFlags& flags, const Scene& scene) {
  const LandscapeWindow whole = ParseWhole(flags, scene);
  LandscapePlan plan;
  plan.settings = ParseSettings(flags, scene);
  // Before the windows, which look at every cell of an axis.
  CheckNumCells(whole, plan.settings.size(), 0);
  plan.windows = ParseWindows(flags, whole);
  CheckNumCells(whole, plan.settings.size(), plan.windows.size() - 1);
  plan.has_gradients = flags.gradients;
  return plan;
}

LandscapeScanOptions SetUpLandscape(const LandscapeFlags& flags, const MotionReader& read,
                                    const ReadMotionOptions& reading, const FittedResult* result) {
  LandscapeScanOptions scan;
  const RecordedMotion own = read(reading);
  scan.plan = MakeLandscapePlan(flags, own.scene);
  for (std::size_t i = 0; i < scan.plan.settings.size(); ++i) {
    const LandscapeSetting& setting = scan.plan.settings[i];
    const bool is_as_before = i > 0 && scan.plan.settings[i - 1].name == setting.name;
    scan.motions.push_back(is_as_before ? scan.motions.back()
                                        : ReadMotionVariant(read, reading, ParseSweep(setting.name).front()));
    scan.motions.back().scene.contact_mode = setting.contact_mode;
  }
  if (result != nullptr) FollowFit(ScannedFitOf(*result, own), &scan);
  CheckSweep(scan, own.scene);
  return scan;
}

LandscapeShard ParseShard(const std::string& text) {
  if (text.empty()) return {};
  const std::vector<std::string> items = Split(text, '/');
  const auto index = items.size() == 2 ? ParseInteger(items[0]) : std::nullopt;
  const auto count = items.size() == 2 ? ParseInteger(items[1]) : std::nullopt;
  if (!index || !count || *index < 0 || *index >= *count || *count > kMaxLandscapeCells) {
    FailOnFlag("--shard", "'" + Printable(text) + "': expected I/N with 0 <= I < N");
  }
  return {static_cast<int>(*index), static_cast<int>(*count)};
}

}  // namespace clothid

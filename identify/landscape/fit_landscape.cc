#include "identify/landscape/fit_landscape.h"

#include <utility>

#include "identify/landscape/landscape_folder.h"
#include "sim/base/error.h"
#include "sim/base/text_file.h"

namespace clothid {
namespace {

[[noreturn]] void FailOnLandscape(const std::string& folder, const std::string& problem,
                                  ErrorKind kind = ErrorKind::kUsage) {
  throw Error(kind, "--landscape: " + folder + ": " + problem);
}

int FindRecording(const std::string& folder, const LandscapeOrigin& origin,
                  const std::vector<RecordedMotion>& motions) {
  for (std::size_t r = 0; r < motions.size(); ++r) {
    if (motions[r].sha256 == origin.input_sha256) return static_cast<int>(r);
  }
  FailOnLandscape(folder, "was scanned on another recording than those of --target");
}

// The setting that is the scene of `motion` as it is.
int FindSetting(const std::string& folder, const LandscapePlan& plan, const RecordedMotion& motion) {
  for (std::size_t s = 0; s < plan.settings.size(); ++s) {
    const LandscapeSetting& setting = plan.settings[s];
    if (setting.name.empty() && setting.contact_mode == motion.scene.contact_mode) return static_cast<int>(s);
  }
  FailOnLandscape(folder, "has no setting with the scene as it is and contact mode " +
                              ContactModeName(motion.scene.contact_mode) + ", which the fit has");
}

// One setting of several.
Landscape OneSetting(Landscape landscape, int setting) {
  LandscapePlan& plan = landscape.plan;
  const int count = plan.cells_per_window() * static_cast<int>(plan.windows.size());
  const auto first = landscape.cells.begin() + plan.FirstCell(setting, 0);
  landscape.cells = std::vector<LandscapeCell>(first, first + count);
  plan.settings = {plan.settings[setting]};
  return landscape;
}

bool IsOfScene(const ParameterBlock& block, int recording) {
  return !IsOfRecording(block.id.kind) && (block.recording == kEveryRecording || block.recording == recording);
}

LandscapeParameter FindAxis(const std::vector<ParameterBlock>& blocks, const FitLandscape& landscape,
                            const std::string& name) {
  for (std::size_t i = 0; i < blocks.size(); ++i) {
    if (IsOfScene(blocks[i], landscape.recording) && BaseName(blocks[i].name) == name) {
      return {static_cast<int>(i), blocks[i]};
    }
  }
  FailOnLandscape(landscape.folder, "its axis '" + Printable(name) + "' is no parameter of this fit");
}

}  // namespace

FitLandscape ReadFitLandscape(const std::string& folder, const std::vector<RecordedMotion>& motions) {
  if (!HasLandscape(folder)) {
    FailOnLandscape(folder, "holds no landscape; expected the --output of a finished `landscape`", ErrorKind::kIo);
  }
  LandscapePart part = ReadWholeLandscape(folder);
  FitLandscape found;
  found.folder = folder;
  found.recording = FindRecording(folder, part.origin, motions);
  if (!part.origin.truth.empty()) {
    FailOnLandscape(folder, "was scanned with --set, against a simulated motion; expected one against the recording");
  }
  const RecordedMotion& motion = motions[found.recording];
  const int setting = FindSetting(folder, part.landscape.plan, motion);
  found.num_other_settings = static_cast<int>(part.landscape.plan.settings.size()) - 1;
  found.landscape = OneSetting(std::move(part.landscape), setting);
  if (part.origin.fit) found.fit = *std::move(part.origin.fit);
  const LandscapeSigma of_fit = SigmaOf(motion);
  // A scan of clothid 0.1 does not say: it had that of the recording.
  const bool is_told = motion.sigma_source == SigmaSource::kGiven || motion.sigma_source == SigmaSource::kEstimated;
  found.has_other_sigma = part.origin.sigma ? !IsSameSigma(*part.origin.sigma, of_fit) : is_told;
  if (part.origin.sigma) {
    found.rmse_of_root_cost = part.origin.sigma->rmse_of_root_cost;
  } else if (!is_told) {
    found.rmse_of_root_cost = of_fit.rmse_of_root_cost;
  }
  return found;
}

void MatchLandscape(const std::vector<ParameterBlock>& blocks, FitLandscape* landscape) {
  const LandscapeWindow& window = landscape->landscape.plan.windows.front();
  landscape->x = FindAxis(blocks, *landscape, window.x.parameter);
  landscape->y = FindAxis(blocks, *landscape, window.y.parameter);
  landscape->others.clear();
  for (int i = 0; i < static_cast<int>(blocks.size()); ++i) {
    const ParameterBlock& block = blocks[i];
    const bool concerns = block.recording == kEveryRecording || block.recording == landscape->recording;
    const bool is_held = i != landscape->x.index && i != landscape->y.index;
    if (concerns && is_held && !block.frozen) landscape->others.push_back(block.name);
  }
}

}  // namespace clothid

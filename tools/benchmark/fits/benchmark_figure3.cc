#include "tools/benchmark/fits/benchmark_figure3.h"

#include <cmath>
#include <map>
#include <utility>

#include "datasets/files/sha256.h"
#include "datasets/synthetic/true_recording.h"
#include "identify/base/parallel_for.h"
#include "identify/base/version.h"
#include "sim/base/error.h"
#include "sim/base/text_file.h"
#include "sim/scene/scene_json.h"
#include "tools/benchmark/base/integrators.h"
#include "tools/landscape/landscape_axis.h"
#include "tools/landscape/landscape_plan.h"
#include "tools/landscape/landscape_run.h"
#include "tools/landscape/scene_variant.h"

namespace clothid {
namespace {

// A cloth of 0.5 m, held at its upper edge, 25 degrees below the horizontal at the start: it swings down on the sphere
// under its lower half and slides off it. INTEGRATOR stands for a name.
constexpr char kScene[] = R"({
  "clothid_scene": 1,
  "time_step": 0.01,
  "integrator": "INTEGRATOR",
  "duration": 0.8,
  "contact": "gap",
  "mesh": {"grid": {"nodes": [10, 10], "size": [0.5, 0.5], "origin": [-0.25, 0, 0],
                    "axes": [[1, 0, 0], [0, 0.906307787036650, -0.422618261740699]]}},
  "initial": {"positions": "rest"},
  "handles": [0, 1, 2, 3, 4, 5, 6, 7, 8, 9],
  "obstacles": [{"name": "ball", "type": "sphere", "center": [0, 0.25, -0.35], "radius": 0.2, "mu": 0.3}],
  "materials": {"density": 0.2, "k_stretch": 100, "k_bend": 2e-3, "drag": 0.05},
  "solver": {"step_tolerance": 1e-8}
})";

const std::map<std::string, double> kTruth = {{"mu", kFigure3Friction}, {"k_stretch", kFigure3Stiffness}};

void Require(bool condition, const std::string& message) {
  if (!condition) throw Error(ErrorKind::kUsage, message);
}

std::string SceneText(const std::string& integrator) {
  const std::string name = "INTEGRATOR";
  std::string text = kScene;
  return text.replace(text.find(name), name.size(), integrator);
}

SceneVariant VariantOf(const Figure3Setting& setting) {
  SceneVariant variant = {{"ball.center.x", setting.offset}};
  if (setting.contact_mode == ContactMode::kVelocity) variant.push_back({"touch", setting.touch});
  return variant;
}

// One recording for each of `noises`, relative to the cloth's size.
std::vector<RecordedMotion> MakeRecordings(const Figure3Setting& setting, const std::string& integrator,
                                           const std::vector<double>& noises, std::uint64_t seed) {
  const std::string text = ChangeScene(SceneText(integrator), {"ball"}, VariantOf(setting));
  Scene scene = ParseScene(text, setting.Name(), "");
  scene.contact_mode = setting.contact_mode;
  const Rollout rollout = SimulateTruth(MakeTrueParameters(kTruth, scene), setting.Name(), scene);
  std::vector<RecordedMotion> recordings;
  for (const double noise : noises) {
    SyntheticOptions synthetic;
    synthetic.noise_sigma = noise * ClothSize(scene.mesh);
    synthetic.seed = seed;
    recordings.push_back(MakeRecording(rollout, scene, text, synthetic));
  }
  return recordings;
}

std::vector<Figure3Setting> MakeSettings(const Figure3Options& options) {
  std::vector<Figure3Setting> settings;
  for (const double offset : options.offsets) {
    settings.push_back({offset, ContactMode::kGap, 0.0});
    for (const double touch : options.touches) settings.push_back({offset, ContactMode::kVelocity, touch});
  }
  return settings;
}

LandscapePlan MakePlan(const Figure3Options& options, const std::vector<Figure3Setting>& settings) {
  LandscapePlan plan;
  for (const Figure3Setting& setting : settings) plan.settings.push_back({setting.Name(), setting.contact_mode});
  const LandscapeAxis mu = {"mu", ParameterScale::kLinear, kFigure3LowestFriction, kFigure3HighestFriction,
                            options.cells};
  const LandscapeAxis k = {"k_stretch", ParameterScale::kLog, kFigure3LowestStiffness, kFigure3HighestStiffness,
                           options.cells};
  plan.windows.push_back({1.0, mu, k});
  for (const double zoom : options.zooms) {
    plan.windows.push_back(
        {zoom, ZoomInto(mu, kFigure3Friction, zoom, "--zoom"), ZoomInto(k, kFigure3Stiffness, zoom, "--zoom")});
  }
  return plan;
}

Landscape Scan(const Figure3Options& options, LandscapeScanOptions scan) {
  scan.num_threads = options.num_threads;
  if (options.folder.empty()) {
    scan.on_cell = [&](int, const LandscapeCell&, int num_done, int num_cells) {
      if (options.on_progress) options.on_progress("cell", num_done, num_cells);
    };
    return ScanLandscape(scan);
  }
  LandscapeRunOptions run;
  run.origin.version = Version();
  run.origin.git = GitHash();
  run.origin.input_sha256 = Sha256Hex({SceneText(options.integrator)});
  run.origin.truth = kTruth;
  run.origin.fingerprint = LandscapeFingerprint(scan.plan, scan.motions, kTruth);
  run.folder = options.folder;
  run.resume = true;
  run.on_progress = [&](int num_done, int num_cells, int num_kept) {
    if (options.on_progress) options.on_progress("cell", num_done - num_kept, num_cells - num_kept);
  };
  run.scan = std::move(scan);
  return RunLandscape(run).part.landscape;
}

std::vector<JacobianFit> PlanFits(const Figure3Options& options, double noise) {
  std::vector<JacobianFit> fits;
  const int n = options.starts_per_axis;
  for (int start = 0; start < n * n; ++start) {
    const double along_mu = (start % n + 1.0) / (n + 1.0), along_k = (start / n + 1.0) / (n + 1.0);
    JacobianFit fit;
    fit.noise = noise;
    fit.method = "adjoint";
    fit.start = {kFigure3LowestFriction + along_mu * (kFigure3HighestFriction - kFigure3LowestFriction),
                 kFigure3LowestStiffness * std::pow(kFigure3HighestStiffness / kFigure3LowestStiffness, along_k)};
    fits.push_back(fit);
  }
  return fits;
}

// To every recording of every setting.
std::vector<JacobianFit> RunFits(const Figure3Options& options, const std::vector<RecordedMotion>& recordings,
                                 const std::vector<double>& noises) {
  std::vector<JacobianFit> fits;
  for (std::size_t i = 0; i < recordings.size(); ++i) {
    const std::vector<JacobianFit> planned = PlanFits(options, noises[i % noises.size()]);
    fits.insert(fits.end(), planned.begin(), planned.end());
  }
  const int per_recording = options.starts_per_axis * options.starts_per_axis;
  const int num_fits = static_cast<int>(fits.size());
  const auto truth = MakeTrueParameters(kTruth, recordings.front().scene);
  ParallelFor(
      num_fits, options.num_threads,
      [&](int i) { RunJacobianFit(recordings[i / per_recording], truth, FitPrecision::kAdaptive, &fits[i]); },
      [&](int, int num_done) {
        if (options.on_progress) options.on_progress("fit", num_done, num_fits);
      });
  for (auto begin = fits.begin(); begin != fits.end(); begin += per_recording) {
    JudgeFits(truth, begin, begin + per_recording);
  }
  return fits;
}

}  // namespace

std::string Figure3Setting::Name() const { return VariantName(VariantOf(*this)); }

void Figure3Options::Validate() const {
  Require(!offsets.empty(), "--offsets: expected at least one number (m)");
  for (const double touch : touches) Require(touch >= 0.0, "--touch: expected numbers >= 0");
  for (std::size_t i = 0; i < zooms.size(); ++i) {
    const double larger = i == 0 ? 1.0 : zooms[i - 1];
    Require(zooms[i] > 0.0 && zooms[i] < larger, "--zoom: expected falling numbers between 0 and 1");
  }
  Require(!zooms.empty(), "--zoom: expected at least one number");
  IntegratorNamed(integrator);
  Require(cells >= 3, "--cells: expected a number >= 3");
  Require(std::isfinite(noise) && noise >= 0.0, "--noise: expected a number >= 0, relative to the cloth's size");
  Require(starts_per_axis >= 0, "--starts: expected a number >= 0");
  Require(num_threads >= 1, "--threads: expected a number >= 1");
}

Figure3 RunFigure3(const Figure3Options& options) {
  options.Validate();
  Figure3 figure;
  figure.settings = MakeSettings(options);
  figure.noises = {0.0};
  if (options.noise > 0.0) figure.noises.push_back(options.noise);
  std::vector<RecordedMotion> recordings, exact;
  for (const Figure3Setting& setting : figure.settings) {
    const std::vector<RecordedMotion> made = MakeRecordings(setting, options.integrator, figure.noises, options.seed);
    recordings.insert(recordings.end(), made.begin(), made.end());
    exact.push_back(made.front());
  }
  LandscapeScanOptions scan;
  scan.plan = MakePlan(options, figure.settings);
  scan.motions = std::move(exact);
  figure.summary = Summarize(Scan(options, std::move(scan)));
  if (options.starts_per_axis > 0) figure.fits = RunFits(options, recordings, figure.noises);
  return figure;
}

}  // namespace clothid

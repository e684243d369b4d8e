#include "tools/landscape/landscape_scan.h"

#include <atomic>
#include <cmath>
#include <exception>
#include <memory>
#include <mutex>
#include <utility>

#include "costs/prediction/alignment.h"
#include "identify/base/parallel_for.h"
#include "sim/base/error.h"
#include "sim/base/text_file.h"
#include "sim/scene/parameters.h"
#include "tools/landscape/landscape_axis.h"
#include "tools/landscape/landscape_cell_model.h"

namespace clothid {
namespace {

std::unique_ptr<LandscapeCellModel> MakeModel(const LandscapeScanOptions& options, int setting) {
  return std::make_unique<LandscapeCellModel>(options.motions[setting], options.plan, options.held, options.model_error,
                                              options.assimilation);
}

// Models that no thread uses at the moment, by setting. Cells are taken up in their order, so those of earlier settings
// are done with.
class IdleModels {
 public:
  explicit IdleModels(const LandscapeScanOptions* options) : options_(options) {}

  std::unique_ptr<LandscapeCellModel> Take(int setting) {
    {
      const std::lock_guard<std::mutex> lock(mutex_);
      models_.erase(models_.begin(), models_.lower_bound(setting));
      const auto found = models_.find(setting);
      if (found != models_.end()) {
        std::unique_ptr<LandscapeCellModel> model = std::move(found->second);
        models_.erase(found);
        return model;
      }
    }
    return MakeModel(*options_, setting);
  }

  void Return(int setting, std::unique_ptr<LandscapeCellModel> model) {
    const std::lock_guard<std::mutex> lock(mutex_);
    models_.emplace(setting, std::move(model));
  }

 private:
  const LandscapeScanOptions* options_;
  std::mutex mutex_;
  std::multimap<int, std::unique_ptr<LandscapeCellModel>> models_;
};

class Scan {
 public:
  Scan(const LandscapeScanOptions& options, Landscape* landscape)
      : options_(options), landscape_(landscape), models_(&options) {}

  void Run() {
    const std::vector<int> cells = options_.cells ? *options_.cells : LandscapeShard().Cells(options_.plan);
    is_done_.assign(cells.size(), false);
    ParallelFor(
        static_cast<int>(cells.size()), options_.num_threads, [&](int task) { Evaluate(cells[task], task); },
        [&](int task, int /*num_ended*/) { Report(cells[task], task, static_cast<int>(cells.size())); });
    if (problem_) std::rethrow_exception(problem_);
  }

 private:
  bool is_cancelled() const { return options_.cancel != nullptr && options_.cancel->load(); }

  void Evaluate(int cell, int task) {
    if (stop_ || is_cancelled()) return;
    try {
      const LandscapePlace place = options_.plan.PlaceOf(cell);
      const LandscapeWindow& window = options_.plan.windows[place.window];
      std::unique_ptr<LandscapeCellModel> model = models_.Take(place.setting);
      LandscapeCell result;
      model->Evaluate(window, window.x.Value(place.ix), window.y.Value(place.iy), options_.plan.has_gradients,
                      options_.cancel, &result);
      models_.Return(place.setting, std::move(model));
      // A cell that failed now may have been cancelled, one that did not is as good as any.
      if (!result.failure.empty() && is_cancelled()) return;
      landscape_->cells[cell] = std::move(result);
      is_done_[task] = true;
    } catch (...) {
      Stop();
    }
  }

  void Report(int cell, int task, int num_cells) {
    if (!is_done_[task]) return;
    ++num_done_;
    if (!options_.on_cell || stop_) return;
    try {
      options_.on_cell(cell, landscape_->cells[cell], num_done_, num_cells);
    } catch (...) {
      Stop();
    }
  }

  // Keeps the exception that is being handled, where it is the first, and has the other threads end.
  void Stop() {
    const std::lock_guard<std::mutex> lock(mutex_);
    if (!problem_) problem_ = std::current_exception();
    stop_ = true;
  }

  const LandscapeScanOptions& options_;
  Landscape* landscape_;
  IdleModels models_;
  std::vector<char> is_done_;  // by task; no bits, which threads could not write side by side
  int num_done_ = 0;
  std::atomic<bool> stop_{false};
  std::mutex mutex_;
  std::exception_ptr problem_;
};

// Throws `Error` (kUsage), led by `source`, unless every value is one that its parameter can have.
void CheckValues(const std::map<std::string, double>& values, const Scene& scene, const std::string& source) {
  for (const auto& [name, value] : values) {
    ParameterId id;
    try {
      id = ParseParameter(name, scene);
    } catch (const Error& error) {
      throw Error(ErrorKind::kUsage, source + ": " + error.what());
    }
    if (id.kind == ParameterKind::kFriction && scene.obstacles.empty()) {
      throw Error(ErrorKind::kUsage, source + ": '" + name + "': the scene has no obstacle");
    }
    if (!IsInDomain(RowOf(id.kind).domain, value)) {
      throw Error(ErrorKind::kUsage, source + ": '" + name + "': expected " + DomainWords(RowOf(id.kind).domain));
    }
  }
}

// Parameters of the recording itself. Throws `Error` (kUsage), led by `source`, where it has not what they correct.
void CheckAlignment(ParameterId id, const std::string& name, double value, const RecordedMotion& motion,
                    const std::string& source) {
  try {
    ExpectMeasured(id, name, motion);
  } catch (const Error& error) {
    throw Error(ErrorKind::kUsage, source + ": " + error.what());
  }
  const double largest = LargestAlignmentBound(id, motion);
  if (std::abs(value) <= largest) return;
  throw Error(ErrorKind::kUsage, source + ": '" + name + "': expected at most " + ShortestText(largest) + " from zero");
}

// Throws `Error` (kUsage), led by `source`, where something is held that an axis sets.
void CheckHeld(const LandscapeScanOptions& options, const std::string& source) {
  const RecordedMotion& motion = options.motions.front();
  const std::vector<std::string> obstacles = motion.scene.obstacle_names();
  const std::vector<std::string>& pieces = motion.scene.mesh.piece_names;
  const LandscapeWindow& window = options.plan.windows.front();
  for (const auto& [name, value] : options.held) {
    if (const auto own = FindParameter(name); own && IsOfRecording(own->kind)) {
      CheckAlignment(*own, name, value, motion, source);
      continue;
    }
    CheckValues({{name, value}}, motion.scene, source);
    const ParameterId id = ParseParameter(name, obstacles, pieces);
    for (const std::string& axis : {window.x.parameter, window.y.parameter}) {
      if (Includes(ParseParameter(axis, obstacles, pieces), id)) {
        throw Error(ErrorKind::kUsage, source + ": '" + name + "' is set by '" + axis + "', an axis");
      }
    }
  }
}

double TakeAxis(const std::string& name, std::map<std::string, double>* values) {
  const auto found = values->find(name);
  if (found == values->end()) throw Error(ErrorKind::kUsage, "--set: expected a value of '" + name + "', an axis");
  const double value = found->second;
  values->erase(found);
  return value;
}

}  // namespace

void LandscapeScanOptions::Validate() const {
  const auto expect = [](bool condition, const std::string& expected) {
    if (!condition) throw Error(ErrorKind::kUsage, "landscape: expected " + expected);
  };
  expect(num_threads >= 1 && num_threads <= kMaxThreads, "1 to " + std::to_string(kMaxThreads) + " threads");
  expect(!plan.windows.empty() && !plan.settings.empty(), "at least one window and one setting");
  expect(motions.size() == plan.settings.size(), "one recording per setting");
  for (std::size_t i = 0; i < motions.size(); ++i) {
    expect(motions[i].scene.contact_mode == plan.settings[i].contact_mode, "recordings in the settings' contact modes");
  }
  for (const int cell : cells.value_or(std::vector<int>())) {
    expect(cell >= 0 && cell < plan.num_cells(), "cells of the plan");
  }
  CheckHeld(*this, "held");
  for (std::size_t i = 0; i < motions.size(); ++i) MakeModel(*this, static_cast<int>(i));
}

Landscape ScanLandscape(const LandscapeScanOptions& options) {
  options.Validate();
  Landscape landscape;
  landscape.plan = options.plan;
  landscape.cells.resize(static_cast<std::size_t>(options.plan.num_cells()));
  Scan(options, &landscape).Run();
  return landscape;
}

void FollowFit(const ScannedFit& fit, LandscapeScanOptions* options) {
  options->model_error = fit.model_error;
  options->assimilation = fit.assimilation;
  options->held = fit.held;
  const LandscapeWindow& window = options->plan.windows.front();
  for (const std::string& axis : {window.x.parameter, window.y.parameter}) options->held.erase(axis);
  CheckHeld(*options, "--result");
}

void MeasureTruth(const std::map<std::string, double>& truth, LandscapeScanOptions* options) {
  const LandscapeWindow& window = options->plan.windows.front();
  CheckValues(truth, options->motions.front().scene, "--set");
  options->held = truth;
  const double x = TakeAxis(window.x.parameter, &options->held), y = TakeAxis(window.y.parameter, &options->held);
  CheckHeld(*options, "--set");
  const Assimilation assimilation = std::exchange(options->assimilation, {});  // nothing corrects the truth
  ParallelFor(static_cast<int>(options->motions.size()), options->num_threads, [&](int setting) {
    const std::unique_ptr<LandscapeCellModel> model = MakeModel(*options, setting);
    Eigen::MatrixXd predicted;
    ForceTrack forces;
    const Rollout rollout = model->Predict(x, y, options->cancel, &predicted, &forces);
    RecordedMotion& motion = options->motions[setting];
    if (options->cancel != nullptr && options->cancel->load()) return;
    if (!rollout.ok()) {
      const std::string& name = options->plan.settings[setting].name;
      throw Error(ErrorKind::kBadData, motion.name + ": the true parameters cannot be simulated: " + name +
                                           (name.empty() ? "" : ": ") + rollout.failure->ToString());
    }
    motion.positions =
        motion.positions.array().isNaN().select(motion.positions, predicted.topRows(motion.positions.rows()));
    model->MoveCloudsTo(predicted, &motion);
    if (motion.forces.is_empty()) return;
    motion.forces.values = motion.forces.values.array().isNaN().select(motion.forces.values, forces.predicted);
  });
  options->assimilation = assimilation;
}

}  // namespace clothid

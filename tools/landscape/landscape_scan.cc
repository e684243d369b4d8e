#include "tools/landscape/landscape_scan.h"

#include <algorithm>
#include <cmath>
#include <exception>
#include <memory>
#include <mutex>
#include <stdexcept>
#include <utility>

#include "costs/prediction/recording_model.h"
#include "costs/prediction/robust_loss.h"
#include "costs/prediction/rollout_cost_options.h"
#include "identify/base/parallel_for.h"
#include "sim/base/error.h"
#include "sim/base/phase_seconds.h"
#include "sim/scene/parameters.h"
#include "sim/scene/scene.h"
#include "tools/landscape/landscape_axis.h"
#include "tools/landscape/landscape_plan.h"

namespace clothid {
namespace {

// A value is its own coordinate, so that cells and truths are simulated at exactly the numbers that are written down.
ParameterBlock MakeBlock(const std::string& name, double start) {
  ParameterBlock block;
  block.name = name;
  block.start = block.lower_bound = block.upper_bound = start;
  return block;
}

// What is held, then both axes. An axis starts at its largest value: the scene then has the terms that it asks for.
std::vector<ParameterBlock> MakeBlocks(const LandscapePlan& plan, const std::map<std::string, double>& held) {
  std::vector<ParameterBlock> blocks;
  for (const auto& [name, value] : held) blocks.push_back(MakeBlock(name, value));
  double x = 0.0, y = 0.0;
  for (const LandscapeWindow& window : plan.windows) {
    x = std::max(x, window.x.upper);
    y = std::max(y, window.y.upper);
  }
  blocks.push_back(MakeBlock(plan.windows.front().x.parameter, x));
  blocks.push_back(MakeBlock(plan.windows.front().y.parameter, y));
  return blocks;
}

// Of one setting, for one thread at a time.
class CellModel {
 public:
  CellModel(const LandscapeScanOptions& options, int setting)
      : setting_(setting), model_(options.motions[setting], MakeBlocks(options.plan, options.held)) {}

  int setting() const { return setting_; }

  Eigen::VectorXd Coordinates(double x, double y) const {
    Eigen::VectorXd coordinates(model_.num_blocks());
    for (int i = 0; i < model_.num_blocks() - 2; ++i) coordinates[i] = model_.blocks()[i].start;
    coordinates.tail(2) << x, y;
    return coordinates;
  }

  Rollout Predict(double x, double y, const std::atomic<bool>* cancel, Eigen::MatrixXd* predicted) {
    return model_.Simulate(Coordinates(x, y), {Precision::kFull, cancel, /*passes_left=*/0}, storage_, predicted);
  }

  // Puts every point of the recording's clouds onto the predicted surface, where that is nearest.
  void MoveCloudsTo(const Eigen::MatrixXd& predicted, RecordedMotion* motion) const {
    const Eigen::Index num_rows = 3 * model_.observation().num_nodes();
    for (std::size_t i = 0; i < motion->clouds.size(); ++i) {
      const Eigen::VectorXd nodes = predicted.col(static_cast<Eigen::Index>(i)).tail(num_rows);
      motion->clouds[i] = model_.observation().clouds().ClosestPoints(static_cast<int>(i), nodes);
    }
  }

  // Fills `cell`; a failure of any kind leaves neither cost nor gradient.
  void Evaluate(const LandscapeWindow& window, double x, double y, bool has_gradients, const std::atomic<bool>* cancel,
                LandscapeCell* cell) {
    const ScopedTimer timer(&cell->seconds);
    try {
      Eigen::MatrixXd predicted;
      const Rollout rollout = Predict(x, y, cancel, &predicted);
      cell->counts = rollout.counts;
      if (!rollout.ok()) throw std::runtime_error(rollout.failure->ToString());
      const Eigen::VectorXd residuals = model_.observation().Residuals(predicted);
      Eigen::VectorXd weights;
      const double cost = LossWeights(RobustLoss(), model_.observation(), 0, residuals, &weights);
      if (!std::isfinite(cost)) throw std::runtime_error("the cost is not finite");
      if (has_gradients) PullBackCost(window, rollout, predicted, residuals, Coordinates(x, y), cell);
      cell->cost = cost;
    } catch (const std::runtime_error& error) {
      cell->failure = error.what();
    }
  }

 private:
  void PullBackCost(const LandscapeWindow& window, const Rollout& rollout, const Eigen::MatrixXd& predicted,
                    const Eigen::VectorXd& residuals, const Eigen::VectorXd& coordinates, LandscapeCell* cell) {
    const int x = model_.num_blocks() - 2, y = x + 1;
    const Eigen::VectorXd gradient =
        model_.PullBack(rollout, predicted, /*velocities=*/{}, coordinates, {x, y}, residuals, {}, Precision::kFull);
    if (!gradient.allFinite()) throw std::runtime_error("the adjoint sweep gave a gradient that is not finite");
    // d/d log value = value d/d value.
    cell->gradient_x = gradient[0] * (window.x.scale == ParameterScale::kLog ? coordinates[x] : 1.0);
    cell->gradient_y = gradient[1] * (window.y.scale == ParameterScale::kLog ? coordinates[y] : 1.0);
  }

  int setting_;
  RecordingModel model_;
  // As of a fit, so that rollouts beyond it get checkpoints, and with them the same rounding, here too.
  RolloutStorage storage_{RolloutCostOptions().memory_limit, /*keep_factors=*/false};
};

// Models that no thread uses at the moment. Cells are taken up in their order, so those of earlier settings are done
// with.
class IdleModels {
 public:
  explicit IdleModels(const LandscapeScanOptions* options) : options_(options) {}

  std::unique_ptr<CellModel> Take(int setting) {
    std::unique_ptr<CellModel> model;
    {
      const std::lock_guard<std::mutex> lock(mutex_);
      models_.erase(
          std::remove_if(models_.begin(), models_.end(), [=](const auto& idle) { return idle->setting() < setting; }),
          models_.end());
      const auto found =
          std::find_if(models_.begin(), models_.end(), [=](const auto& idle) { return idle->setting() == setting; });
      if (found != models_.end()) {
        model = std::move(*found);
        models_.erase(found);
      }
    }
    return model ? std::move(model) : std::make_unique<CellModel>(*options_, setting);
  }

  void Return(std::unique_ptr<CellModel> model) {
    const std::lock_guard<std::mutex> lock(mutex_);
    models_.push_back(std::move(model));
  }

 private:
  const LandscapeScanOptions* options_;
  std::mutex mutex_;
  std::vector<std::unique_ptr<CellModel>> models_;
};

class Scan {
 public:
  Scan(const LandscapeScanOptions& options, Landscape* landscape)
      : options_(options), landscape_(landscape), models_(&options) {}

  void Run() {
    std::vector<int> all;
    if (!options_.cells) all = LandscapeShard().Cells(options_.plan);
    const std::vector<int>& cells = options_.cells ? *options_.cells : all;
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
      std::unique_ptr<CellModel> model = models_.Take(place.setting);
      LandscapeCell result;
      model->Evaluate(window, window.x.Value(place.ix), window.y.Value(place.iy), options_.plan.has_gradients,
                      options_.cancel, &result);
      models_.Return(std::move(model));
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
void CheckValues(const std::map<std::string, double>& values, const std::vector<std::string>& obstacle_names,
                 const std::string& source) {
  for (const auto& [name, value] : values) {
    ParameterId id;
    try {
      id = ParseParameter(name, obstacle_names);
    } catch (const Error& error) {
      throw Error(ErrorKind::kUsage, source + ": " + error.what());
    }
    if (id.kind == ParameterKind::kFriction && obstacle_names.empty()) {
      throw Error(ErrorKind::kUsage, source + ": '" + name + "': the scene has no obstacle");
    }
    if (!IsInRange(id.kind, value)) {
      throw Error(ErrorKind::kUsage,
                  source + ": '" + name + "': expected a finite number " + (IsInRange(id.kind, 0.0) ? ">= 0" : "> 0"));
    }
  }
}

// Throws `Error` (kUsage), led by `source`, where something is held that an axis sets.
void CheckHeld(const LandscapeScanOptions& options, const std::string& source) {
  const std::vector<std::string> obstacles = options.motions.front().scene.obstacle_names();
  CheckValues(options.held, obstacles, source);
  const LandscapeWindow& window = options.plan.windows.front();
  for (const auto& [name, value] : options.held) {
    const ParameterId id = ParseParameter(name, obstacles);
    for (const std::string& axis : {window.x.parameter, window.y.parameter}) {
      if (Includes(ParseParameter(axis, obstacles), id)) {
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
  for (std::size_t i = 0; i < motions.size(); ++i) CellModel(*this, static_cast<int>(i));
}

Landscape ScanLandscape(const LandscapeScanOptions& options) {
  options.Validate();
  Landscape landscape;
  landscape.plan = options.plan;
  landscape.cells.resize(static_cast<std::size_t>(options.plan.num_cells()));
  Scan(options, &landscape).Run();
  return landscape;
}

void MeasureTruth(const std::map<std::string, double>& truth, LandscapeScanOptions* options) {
  const LandscapeWindow& window = options->plan.windows.front();
  CheckValues(truth, options->motions.front().scene.obstacle_names(), "--set");
  options->held = truth;
  const double x = TakeAxis(window.x.parameter, &options->held), y = TakeAxis(window.y.parameter, &options->held);
  CheckHeld(*options, "--set");
  ParallelFor(static_cast<int>(options->motions.size()), options->num_threads, [&](int setting) {
    CellModel model(*options, setting);
    Eigen::MatrixXd predicted;
    const Rollout rollout = model.Predict(x, y, options->cancel, &predicted);
    RecordedMotion& motion = options->motions[setting];
    if (options->cancel != nullptr && options->cancel->load()) return;
    if (!rollout.ok()) {
      throw Error(ErrorKind::kBadData,
                  motion.name + ": the true parameters cannot be simulated: " +
                      (options->plan.settings[setting].name.empty() ? std::string()
                                                                    : options->plan.settings[setting].name + ": ") +
                      rollout.failure->ToString());
    }
    motion.positions =
        motion.positions.array().isNaN().select(motion.positions, predicted.topRows(motion.positions.rows()));
    model.MoveCloudsTo(predicted, &motion);
  });
}

}  // namespace clothid

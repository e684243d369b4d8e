#include "tools/simulate/predict.h"

#include <unistd.h>

#include <cmath>
#include <iomanip>
#include <iostream>
#include <utility>
#include <vector>

#include "datasets/synthetic/synthetic.h"
#include "identify/base/join_words.h"
#include "identify/prediction/bands_file.h"
#include "sim/base/error.h"
#include "sim/base/text_file.h"
#include "tools/base/count_progress.h"
#include "tools/simulate/prediction_view.h"

namespace clothid {
namespace {

std::string PercentText(double share) {
  return std::isnan(share) ? "-" : std::to_string(std::lround(100.0 * share)) + " %";
}

void PrintStart(const LearntStart& start, const Prediction& prediction) {
  std::cout << "start           of the fitted recordings was off by " << MillimetreText(start.position, 2) << " and "
            << NumberText(start.velocity, 2) << " m/s" << (prediction.has_start ? ", drawn" : ", not drawn");
  if (start.handles > 0.0) {
    std::cout << "; their handles by " << MillimetreText(start.handles, 2)
              << (prediction.has_handles ? ", drawn" : ", not drawn");
  }
  std::cout << "\n";
}

void PrintDrawn(const FitPosterior& posterior, bool has_force) {
  std::vector<std::string> drawn, untold, held;
  for (const PosteriorParameter& parameter : posterior.parameters) {
    (parameter.untold ? untold : drawn).push_back(parameter.name);
  }
  for (const auto& [name, value] : posterior.held) held.push_back(name);
  std::cout << "drawn           " << (drawn.empty() ? "no parameter" : JoinWords(drawn));
  if (!untold.empty()) std::cout << "; within bounds, for want of an interval: " << JoinWords(untold);
  if (!held.empty()) std::cout << "; as if known: " << JoinWords(held);
  if (!posterior.left_out.empty()) std::cout << "; of no use here: " << JoinWords(posterior.left_out);
  std::cout << "\nmodel           ";
  if (!posterior.forces.empty()) {
    std::vector<std::string> forces;
    for (const LastingForce& force : posterior.forces) {
      forces.push_back(NumberText(force.size, 2) + " N/m^2 for " + NumberText(force.time, 2) + " s");
    }
    std::cout << "lacks a force of " << JoinWords(forces) << " over " << NumberText(posterior.forces[0].length, 2)
              << (has_force ? " m, drawn" : " m, not drawn");
    if (posterior.force_factor != 1.0) {
      std::cout << "; calibrated, " << NumberText(posterior.force_factor, 3) << " times what the fit told";
    }
    std::cout << "\n";
  } else {
    std::cout << "the fit tells no force that it lacks\n";
  }
}

void PrintFrame(const FitPosterior& posterior, const Prediction& prediction, Eigen::Index frame) {
  const SpreadShares& shares = prediction.shares;
  std::cout << "at " << NumberText(prediction.times[frame], 3) << " s: +- "
            << MillimetreText(prediction.spread[frame], 3) << " after " << MillimetreText(prediction.moved[frame], 3)
            << " of motion; parameters " << PercentText(shares.parameters[frame]);
  std::vector<std::string> each;
  for (std::size_t i = 0; i < posterior.parameters.size(); ++i) {
    each.push_back(posterior.parameters[i].name + " " + PercentText(shares.each(frame, static_cast<Eigen::Index>(i))));
  }
  if (each.size() > 1) std::cout << " (" << JoinWords(each) << " by itself)";
  std::cout << ", step and mesh " << PercentText(shares.finer[frame])
            << (prediction.has_start ? ", start " + PercentText(shares.start[frame]) : "")
            << (prediction.has_handles ? ", handles " + PercentText(shares.handles[frame]) : "")
            << (prediction.has_force ? ", model " : ", not linear ") << PercentText(shares.rest[frame]) << "\n";
}

// At the end: the median of every number, and its band of 90 %.
void PrintDerived(const DerivedBands& bands) {
  const Eigen::Index last = bands.quantiles[0].cols() - 1;
  const std::string unit = UnitOf(bands.request.kind);
  std::vector<std::string> numbers;
  for (Eigen::Index row = 0; row < bands.quantiles[0].rows(); ++row) {
    const auto number = [&](std::size_t q) {
      const double value = bands.quantiles[q](row, last);
      return std::isinf(value) ? std::string("never") : NumberText(value, 3);
    };
    numbers.push_back(number(2) + " (" + number(0) + " .. " + number(4) + ")");
  }
  std::cout << std::left << std::setw(16) << bands.request.name << JoinWords(numbers)
            << (unit.empty() ? "" : " " + unit) << (bands.request.kind == DerivedKind::kSlip ? "\n" : " at the end\n");
}

void PrintPrediction(const FitPosterior& posterior, const Prediction& prediction) {
  PrintDrawn(posterior, prediction.has_force);
  if (posterior.start) PrintStart(*posterior.start, prediction);
  std::cout << "rollouts        " << prediction.num_draws;
  if (prediction.num_failed > 0) {
    std::cout << "; " << prediction.num_failed << " failed and count nowhere, the first: " << prediction.failure;
  }
  std::cout << "\n";
  for (const auto& [what, why] : {std::pair("step", prediction.no_step), std::pair("mesh", prediction.no_mesh)}) {
    if (!why.empty()) std::cout << "the error of the " << what << " counts nowhere: " << why << "\n";
  }
  constexpr int kTimes = 4;
  const Eigen::Index last = prediction.times.size() - 1;
  for (int i = 1; i <= kTimes; ++i) PrintFrame(posterior, prediction, (i * last + kTimes - 1) / kTimes);
  for (const DerivedBands& bands : prediction.derived) PrintDerived(bands);
  const double until = prediction.WorthUntil();
  std::cout << "worth           more than the cloth at rest "
            << (std::isinf(until) ? "to the end" : "until " + NumberText(until, 3) + " s") << "\n";
}

}  // namespace

int PredictScene(const ScenePart& part, const std::string& result_path, PredictionOptions options,
                 PredictionOutput* output) {
  FitPosterior posterior = ReadPosterior(result_path);
  FitToScene(part.scene, part.path, &posterior);
  if (!posterior.warning.empty()) {
    std::cerr << "simulate: warning: " << result_path << ": the fit says: " << posterior.warning << "\n";
  }
  Prediction prediction;
  {
    CountProgress progress(&std::cerr, isatty(STDERR_FILENO) != 0, "rollouts", CountProgress::End::kQuiet);
    options.on_rollout = [&](int num_done) { progress.Print(num_done, options.num_draws); };
    prediction = Predict(part.scene, posterior, options);
  }
  if (options.cancel != nullptr && *options.cancel) {
    std::cerr << "simulate: interrupted, nothing is written\n";
    return kExitInterrupted;
  }
  output->median = RecordFrames(prediction.median(), prediction.times, part.scene, part.text,
                                "predicted: the median of " + std::to_string(prediction.num_draws) +
                                    " rollouts, seed " + std::to_string(options.seed));
  output->bands = BandsNpz(prediction, posterior, options.keeps_draws);
  output->view = ViewOf(posterior, prediction);
  PrintPrediction(posterior, prediction);
  return kExitSuccess;
}

}  // namespace clothid

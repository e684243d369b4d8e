#include "identify/prediction/judge_bands.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <memory>
#include <optional>
#include <utility>

#include "identify/base/parallel_for.h"
#include "identify/prediction/bands.h"
#include "identify/prediction/coverage.h"
#include "identify/prediction/held_recording.h"
#include "identify/prediction/random_streams.h"
#include "sim/base/error.h"

namespace clothid {
namespace {

// Residuals of draws [m x D] over sigma; empty ones failed.
std::vector<Eigen::VectorXd> RollDraws(const HeldRecording& recording, double force_factor,
                                       const HeldBandOptions& options) {
  std::vector<Eigen::VectorXd> draws(static_cast<std::size_t>(options.num_draws));
  const auto roll = [&](int draw) {
    const bool is_cancelled = options.cancel != nullptr && *options.cancel;
    if (!is_cancelled) draws[static_cast<std::size_t>(draw)] = recording.Roll(draw, force_factor);
  };
  ParallelFor(options.num_draws, options.num_threads, roll);
  return draws;
}

// One recording with what its rollouts have come to.
struct JudgedRecording {
  std::unique_ptr<HeldRecording> held;
  Eigen::MatrixXd finer;                         // [m x 2]
  std::vector<Eigen::VectorXd> drawn, unforced;  // as of `RollDraws`; unforced: empty where nothing is calibrated

  // [m x D] with the changes of step and mesh; columns of rollouts that failed are left out: `numbers` has the others,
  // unless it is null. NaN: as drawn, else of so many times the force, as if what it does were linear.
  Eigen::MatrixXd Draws(double force_factor, const HeldBandOptions& options, std::vector<int>* numbers) const {
    Eigen::MatrixXd all(finer.rows(), options.num_draws);
    Eigen::Index num_kept = 0;
    for (int draw = 0; draw < options.num_draws; ++draw) {
      const auto index = static_cast<std::size_t>(draw);
      const bool scales = !std::isnan(force_factor);
      if (drawn[index].size() == 0 || (scales && unforced[index].size() == 0)) continue;
      Eigen::VectorXd residuals = drawn[index];
      if (scales) residuals = unforced[index] + force_factor * (drawn[index] - unforced[index]);
      all.col(num_kept++) =
          residuals + finer * NormalStream(options.seed, draw, DrawStream::kFiner).Draw(1, 2).transpose();
      if (numbers != nullptr) numbers->push_back(draw);
    }
    return all.leftCols(num_kept);
  }
};

// Draws [D] of one measurement and their numbers, against 0, what was measured.
struct JudgedDraws {
  Eigen::VectorXd values;
  const std::vector<int>& numbers;
  Eigen::RowVectorXd bands = BandsOf(values.transpose());
  double score = RankedScore(values, 0.0);
  ByOthers by_others = ByOthers(values);
};

// Sums over measurements, of which `Finish` makes a cell.
class CellSums {
 public:
  CellSums(double until, int num_draws) : others_(num_draws) { cell_.until = until; }

  bool IsEmpty() const { return cell_.num == 0.0; }

  void Add(double sigma, const JudgedDraws& draws) {
    cell_.num += 1.0;
    cell_.inside += draws.bands[0] <= 0.0 && 0.0 <= draws.bands[4] ? 1.0 : 0.0;
    cell_.rmse += std::pow(sigma * draws.bands[2], 2);
    cell_.score += sigma * draws.score;
    cell_.half_width += 0.5 * sigma * (draws.bands[4] - draws.bands[0]);
    others_.Add(draws.by_others, draws.numbers, sigma);
  }

  HeldBandCell Finish() const {
    HeldBandCell cell = cell_;
    cell.inside /= cell.num;
    cell.rmse = std::sqrt(cell.rmse / cell.num);
    cell.score /= cell.num;
    cell.half_width /= cell.num;
    cell.inside_if_right = RangeOf(others_.Shares());
    cell.rmse_if_right = RangeOf(others_.Errors());
    return cell;
  }

 private:
  HeldBandCell cell_;
  LeaveOneOut others_;
};

// Until when a median is worth more than a cloth at rest, from what both miss, row by row in the order of time.
class WorthCount {
 public:
  void Add(double lead, double missed, double missed_at_rest) {
    if (lead > lead_) Close();
    lead_ = lead;
    missed_ += missed * missed;
    missed_at_rest_ += missed_at_rest * missed_at_rest;
  }

  double Until() {
    Close();
    return until_ == lead_ ? std::numeric_limits<double>::infinity() : until_;
  }

 private:
  void Close() {
    if (missed_ < missed_at_rest_) until_ = lead_;
  }

  double lead_ = 0.0, missed_ = 0.0, missed_at_rest_ = 0.0, until_ = 0.0;
};

// Of all recordings that are judged.
struct AllSums {
  explicit AllSums(int num_draws) : all(kToTheEnd, num_draws) {
    for (const double until : kHeldLeads) leads.emplace_back(until, num_draws);
  }

  static constexpr double kToTheEnd = std::numeric_limits<double>::infinity();
  std::vector<CellSums> leads;
  CellSums all;
};

// `still`: of a cloth at rest; empty: not known.
HeldRecordingBands AddRecording(const JudgedRows& judged, const Eigen::MatrixXd& draws, const std::vector<int>& numbers,
                                const Eigen::VectorXd& still, int num_draws, AllSums* sums) {
  HeldRecordingBands recording;
  CellSums own(AllSums::kToTheEnd, num_draws);
  WorthCount worth;
  for (Eigen::Index row = 0; row < draws.rows(); ++row) {
    const double sigma = judged.sigma[row];
    const JudgedDraws of_row = {draws.row(row).transpose(), numbers};
    for (CellSums* cell : {&sums->leads[LeadOf(judged.leads[row])], &sums->all, &own}) cell->Add(sigma, of_row);
    if (still.size() > 0) worth.Add(judged.leads[row], sigma * of_row.bands[2], sigma * still[row]);
  }
  recording.all = own.Finish();
  if (still.size() > 0) recording.worth_until = worth.Until();
  return recording;
}

constexpr double kAsDrawn = std::numeric_limits<double>::quiet_NaN();

// The share of all measurements in the bands of 90 %.
double InsideWith(double force_factor, const std::vector<JudgedRecording>& recordings, const HeldBandOptions& options) {
  double inside = 0.0, num = 0.0;
  for (const JudgedRecording& recording : recordings) {
    const Eigen::MatrixXd bands = BandsOf(recording.Draws(force_factor, options, nullptr));
    inside += static_cast<double>((bands.col(0).array() <= 0.0 && bands.col(4).array() >= 0.0).count());
    num += static_cast<double>(bands.rows());
  }
  return inside / num;
}

// The factor by which bands hold 90 %, as if what a force does were linear from none to that of `drawn`, which has
// `drawn_factor` times its size.
double FactorByInterpolation(double drawn_factor, const std::vector<JudgedRecording>& recordings,
                             const HeldBandOptions& options) {
  constexpr int kHalvings = 20;
  const double nominal = kBandQuantiles.back() - kBandQuantiles.front();
  double low = std::log(kLeastBandFactor), high = -low;
  for (int i = 0; i < kHalvings; ++i) {
    const double middle = 0.5 * (low + high);
    (InsideWith(std::exp(middle) / drawn_factor, recordings, options) < nominal ? low : high) = middle;
  }
  return std::exp(0.5 * (low + high));
}

// What the bands of `all` hold with one factor on the force: 1 where that is what right ones may hold, for then it
// tells of none. Else it interpolates twice, the second time to rollouts with the first factor, and rolls out with what
// that gives.
BandCalibration Calibrate(const HeldBandCell& all, const HeldBandOptions& options,
                          std::vector<JudgedRecording>* recordings) {
  BandCalibration calibration = {1.0, all.inside};
  if (!all.IsTooNarrow() && !all.IsTooWide()) return calibration;
  for (JudgedRecording& recording : *recordings) recording.unforced = RollDraws(*recording.held, 0.0, options);
  for (int round = 0; round < 2; ++round) {
    calibration.factor = FactorByInterpolation(calibration.factor, *recordings, options);
    for (JudgedRecording& recording : *recordings) {
      recording.drawn = RollDraws(*recording.held, calibration.factor, options);
    }
  }
  calibration.inside = InsideWith(kAsDrawn, *recordings, options);
  return calibration;
}

}  // namespace

HeldBands JudgeByBands(const std::vector<RecordedMotion>& motions, const std::vector<ParameterBlock>& blocks,
                       const Eigen::VectorXd& values, const FitPosterior& posterior, HeldOut held_out,
                       const std::vector<HeldOutStart>& starts, const HeldBandOptions& options) {
  HeldBands bands;
  bands.num_draws = options.num_draws;
  if (posterior.parameters.empty()) {
    bands.why_not = "no parameter has an interval";
    return bands;
  }
  AllSums sums(options.num_draws);
  std::vector<JudgedRecording> judged;
  for (std::size_t r = 0; r < motions.size(); ++r) {
    const int recording = held_out == HeldOut::kFrames ? static_cast<int>(r) : -1;
    JudgedRecording next;
    next.held = std::make_unique<HeldRecording>(motions[r], static_cast<int>(r), recording,
                                                starts.empty() ? HeldOutStart() : starts[r], blocks, values, posterior,
                                                options);
    if (next.held->judged().rows.empty()) continue;
    bands.has_force = bands.has_force || next.held->has_force();
    next.drawn = RollDraws(*next.held, 1.0, options);
    next.finer = next.held->RollFiner();
    std::vector<int> numbers;
    const Eigen::MatrixXd draws = next.Draws(kAsDrawn, options, &numbers);
    bands.num_failed += options.num_draws - static_cast<int>(draws.cols());
    if (draws.cols() < kLeastDraws) {
      bands.recordings.clear();
      bands.why_not = motions[r].name + ": fewer than " + std::to_string(kLeastDraws) + " of " +
                      std::to_string(options.num_draws) + " rollouts work";
      return bands;
    }
    const JudgedRows& rows = next.held->judged();
    const Eigen::VectorXd still = rows.are_forces ? Eigen::VectorXd() : next.held->RollStill();
    bands.recordings.push_back(AddRecording(rows, draws, numbers, still, options.num_draws, &sums));
    bands.recordings.back().name = motions[r].name;
    judged.push_back(std::move(next));
  }
  if (sums.all.IsEmpty()) {
    bands.why_not = "neither a position nor a force was held out";
    return bands;
  }
  bands.all = sums.all.Finish();
  for (const CellSums& lead : sums.leads) {
    if (!lead.IsEmpty()) bands.leads.push_back(lead.Finish());
  }
  if (options.calibrates && bands.has_force) bands.calibration = Calibrate(bands.all, options, &judged);
  return bands;
}

}  // namespace clothid

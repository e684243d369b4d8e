#include "identify/prediction/judge_bands.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <memory>
#include <optional>
#include <utility>

#include "identify/base/parallel_for.h"
#include "identify/prediction/bands.h"
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

  // [m x D] with the changes of step and mesh; columns of rollouts that failed are left out. NaN: as drawn, else of so
  // many times the force, as if what it does were linear.
  Eigen::MatrixXd Draws(double force_factor, const HeldBandOptions& options) const {
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
    }
    return all.leftCols(num_kept);
  }
};

// Sums, until `Finish` makes means of them.
void AddToCell(double sigma, const Eigen::VectorXd& draws, const Eigen::RowVectorXd& bands, HeldBandCell* cell) {
  cell->num += 1.0;
  cell->inside += bands[0] <= 0.0 && 0.0 <= bands[4] ? 1.0 : 0.0;
  cell->rmse += std::pow(sigma * bands[2], 2);
  cell->score += sigma * RankedScore(draws, 0.0);
  cell->half_width += 0.5 * sigma * (bands[4] - bands[0]);
}

void Finish(HeldBandCell* cell) {
  cell->inside /= cell->num;
  cell->rmse = std::sqrt(cell->rmse / cell->num);
  cell->score /= cell->num;
  cell->half_width /= cell->num;
}

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

// `still`: of a cloth at rest; empty: not known.
void AddRecording(const JudgedRows& judged, const Eigen::MatrixXd& draws, const Eigen::VectorXd& still,
                  HeldRecordingBands* own, HeldBands* bands) {
  WorthCount worth;
  for (Eigen::Index row = 0; row < draws.rows(); ++row) {
    const Eigen::VectorXd of_row = draws.row(row).transpose();
    const double sigma = judged.sigma[row];
    const Eigen::RowVectorXd quantiles = BandsOf(of_row.transpose());
    for (HeldBandCell* cell : {&bands->leads[LeadOf(judged.leads[row])], &bands->all, &own->all}) {
      AddToCell(sigma, of_row, quantiles, cell);
    }
    if (still.size() > 0) worth.Add(judged.leads[row], sigma * quantiles[2], sigma * still[row]);
  }
  if (still.size() > 0) own->worth_until = worth.Until();
}

constexpr double kAsDrawn = std::numeric_limits<double>::quiet_NaN();

// The share of all measurements in the bands of 90 %.
double InsideWith(double force_factor, const std::vector<JudgedRecording>& recordings, const HeldBandOptions& options) {
  double inside = 0.0, num = 0.0;
  for (const JudgedRecording& recording : recordings) {
    const Eigen::MatrixXd bands = BandsOf(recording.Draws(force_factor, options));
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

// Interpolates twice, the second time to rollouts with the first factor, and rolls out with what that gives.
BandCalibration Calibrate(const HeldBandOptions& options, std::vector<JudgedRecording>* recordings) {
  BandCalibration calibration;
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
  for (const double until : kHeldLeads) bands.leads.push_back({until});
  if (posterior.parameters.empty()) {
    bands.leads.clear();
    bands.why_not = "no parameter has an interval";
    return bands;
  }
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
    const Eigen::MatrixXd draws = next.Draws(kAsDrawn, options);
    bands.num_failed += options.num_draws - static_cast<int>(draws.cols());
    if (draws.cols() < kLeastDraws) {
      bands.why_not = motions[r].name + ": fewer than " + std::to_string(kLeastDraws) + " of " +
                      std::to_string(options.num_draws) + " rollouts work";
      break;
    }
    const JudgedRows& rows = next.held->judged();
    HeldRecordingBands& own = bands.recordings.emplace_back();
    own.name = motions[r].name;
    AddRecording(rows, draws, rows.are_forces ? Eigen::VectorXd() : next.held->RollStill(), &own, &bands);
    Finish(&own.all);
    judged.push_back(std::move(next));
  }
  if (options.calibrates && bands.has_force && bands.why_not.empty()) bands.calibration = Calibrate(options, &judged);
  const auto is_empty = [](const HeldBandCell& cell) { return cell.num == 0.0; };
  bands.leads.erase(std::remove_if(bands.leads.begin(), bands.leads.end(), is_empty), bands.leads.end());
  for (HeldBandCell& cell : bands.leads) Finish(&cell);
  if (bands.all.num > 0.0) {
    Finish(&bands.all);
  } else if (bands.why_not.empty()) {
    bands.why_not = "neither a position nor a force was held out";
  }
  if (!bands.why_not.empty()) {
    bands.leads.clear();
    bands.recordings.clear();
  }
  return bands;
}

}  // namespace clothid

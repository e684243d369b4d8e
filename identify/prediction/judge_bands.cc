#include "identify/prediction/judge_bands.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <memory>
#include <optional>
#include <utility>

#include "costs/prediction/recording_model.h"
#include "costs/start/start_spread.h"
#include "costs/start/unknown_start.h"
#include "datasets/motion/refined_motion.h"
#include "datasets/observation/observation.h"
#include "identify/base/parallel_for.h"
#include "identify/prediction/bands.h"
#include "identify/prediction/random_force.h"
#include "identify/prediction/random_streams.h"
#include "sim/base/error.h"
#include "sim/base/text_file.h"

namespace clothid {
namespace {

constexpr std::array<double, 4> kHeldLeads = {0.1, 0.3, 1.0, std::numeric_limits<double>::infinity()};  // s
constexpr double kMostHeldNumbers = 5e6;  // of all draws of a recording: 40 MB

// The rows of a residual that are judged, their standard deviations and their times after the start of the scene.
struct JudgedRows {
  std::vector<int> rows;
  Eigen::VectorXd sigma, leads;
};

JudgedRows RowsOf(const RecordingModel& model, int num_draws) {
  const Observation& observation = model.observation();
  const Eigen::VectorXd times = observation.RowTimes().array() - model.scene().start_time;
  std::vector<int> points, forces;
  for (int row = 0; row < observation.num_residuals(); ++row) {
    if (!(times[row] > 0.5 * model.scene().time_step)) continue;  // the start itself
    if (observation.KindOf(row) == PredictedKind::kPoints) points.push_back(row);
    if (observation.KindOf(row) == PredictedKind::kForces) forces.push_back(row);
  }
  const std::vector<int>& all = points.empty() ? forces : points;
  auto stride = static_cast<std::size_t>(std::ceil(static_cast<double>(all.size()) * num_draws / kMostHeldNumbers));
  if (stride > 1 && stride % 3 == 0) ++stride;  // every axis
  JudgedRows judged;
  for (std::size_t i = 0; i < all.size(); i += std::max<std::size_t>(stride, 1)) judged.rows.push_back(all[i]);
  judged.leads = times(judged.rows);
  judged.sigma.resize(judged.leads.size());
  for (Eigen::Index i = 0; i < judged.sigma.size(); ++i) {
    judged.sigma[i] = observation.SigmaOf(judged.rows[static_cast<std::size_t>(i)]);
  }
  return judged;
}

// One held-out recording and the rollouts of it.
class HeldRecording {
 public:
  HeldRecording(const RecordedMotion& motion, int number, int recording, const HeldOutStart& start,
                const std::vector<ParameterBlock>& blocks, const Eigen::VectorXd& values, const FitPosterior& posterior,
                const HeldBandOptions& options)
      : motion_(motion),
        number_(number),
        recording_(recording),
        start_(start),
        blocks_(blocks),
        values_(values),
        posterior_(posterior),
        options_(options),
        drawn_(DrawParameters(posterior, options.num_draws, options.seed)) {
    for (const ParameterBlock& block : blocks) num_fitted_ = std::max(num_fitted_, block.recording + 1);
    const HeldOutBlocks own = BlocksFor(motion_, recording_, blocks_, values_);
    RecordingModel model(motion_, own.blocks, {}, start_.start);
    if (start_.start == nullptr) start_.start = model.shared_start();
    judged_ = RowsOf(model, options.num_draws);
    if (posterior.start && start_.start != nullptr && start_.unknowns.size() == 0) {
      spread_.emplace(motion.scene, posterior.start->position, posterior.start->velocity);
    }
    if (posterior.force && model.cloth().num_free() > 0) {
      field_ = std::make_unique<SmoothField>(model.cloth(), posterior.force->length);
    }
  }

  const JudgedRows& judged() const { return judged_; }
  bool has_force() const { return field_ != nullptr; }

  // Residuals [m] over sigma, with noise where the recording knows it, and so many times the force; empty: the rollout
  // failed.
  Eigen::VectorXd Roll(int draw, double force_factor) const {
    Eigen::VectorXd values = values_;
    for (std::size_t i = 0; i < posterior_.parameters.size(); ++i) {
      values[IndexOfBlock(posterior_.parameters[i].name)] = drawn_(static_cast<Eigen::Index>(i), draw);
    }
    const std::optional<int> like = num_fitted_ > 0 ? std::optional<int>(draw % num_fitted_) : std::nullopt;
    const HeldOutBlocks own = BlocksFor(motion_, recording_, blocks_, values, like);
    RecordingModel model(motion_, own.blocks, {}, start_.start);
    const int stream = number_ * options_.num_draws + draw;
    if (field_ && force_factor > 0.0) {
      LastingForce force = *posterior_.force;
      force.size *= force_factor;
      model.Correct(std::make_shared<RandomForce>(force, *field_, model.cloth(),
                                                  model.ParametersAt(own.coordinates).material, model.num_steps(),
                                                  options_.seed, stream));
    }
    Eigen::VectorXd residuals = ResidualsOf(own, {start_.start, StartOf(stream)}, &model);
    if (residuals.size() > 0 && model.observation().sigma_is_known()) {
      residuals += NormalStream(options_.seed, stream, DrawStream::kNoise).Draw(residuals.size(), 1);
    }
    return residuals;
  }

  // What half the step and a mesh of twice the density change of residuals [m x 2]; zero where that is not known.
  Eigen::MatrixXd RollFiner() const {
    Eigen::MatrixXd changes = Eigen::MatrixXd::Zero(static_cast<Eigen::Index>(judged_.rows.size()), 2);
    Eigen::VectorXd own;
    std::array<Eigen::VectorXd, 2> finer;
    const auto roll = [&](int task) {
      if (task == 2) own = RollEstimate(motion_, start_);
      if (task == 0 && options_.with_step) {
        RecordedMotion halved = motion_;
        halved.scene.time_step *= 0.5;
        finer[0] = RollEstimate(halved, start_);
      }
      // The modes of an unknown start are those of its mesh.
      if (task == 1 && options_.with_mesh && start_.unknowns.size() == 0) finer[1] = RollRefined();
    };
    ParallelFor(3, options_.num_threads, roll);
    for (Eigen::Index i = 0; i < 2; ++i) {
      const Eigen::VectorXd& changed = finer[static_cast<std::size_t>(i)];
      if (own.size() > 0 && changed.size() == own.size()) changes.col(i) = changed - own;
    }
    return changes;
  }

 private:
  Eigen::Index IndexOfBlock(const std::string& name) const {
    const auto found =
        std::find_if(blocks_.begin(), blocks_.end(), [&](const ParameterBlock& block) { return block.name == name; });
    return found - blocks_.begin();
  }

  // The unknowns of the start: those that the fit has estimated, or draws about where it was taken to be, as far off as
  // fitted ones were and handles as far as they were measured.
  Eigen::VectorXd StartOf(int stream) const {
    if (!spread_) return start_.unknowns;
    const UnknownStart& start = *start_.start;
    NormalStream numbers(options_.seed, stream, DrawStream::kStart);
    const Eigen::MatrixXd &positions = spread_->position_root(), &velocities = spread_->velocity_root();
    Eigen::VectorXd unknowns = Eigen::VectorXd::Zero(start.size());
    unknowns.head(positions.cols()) = positions * numbers.Draw(positions.cols(), 1);
    const Eigen::Index first_velocity = start.num_position_unknowns() + start.num_handle_unknowns();
    const Eigen::Index num_velocities = start.size() - first_velocity;
    unknowns.tail(num_velocities) = velocities.topRows(num_velocities) * numbers.Draw(velocities.cols(), 1);
    if (start.num_handle_unknowns() > 0) {
      const Eigen::MatrixXd& root = start.handle_jacobian();
      unknowns.segment(start.num_position_unknowns(), start.num_handle_unknowns()) =
          root.completeOrthogonalDecomposition().solve(numbers.Draw(root.rows(), 1));
    }
    return unknowns;
  }

  Eigen::VectorXd ResidualsOf(const HeldOutBlocks& own, const HeldOutStart& start, RecordingModel* model) const {
    Eigen::MatrixXd predicted;
    ForceTrack forces;
    const PassOptions pass = {Precision::kFull, options_.cancel};
    const Rollout rollout =
        model->Simulate(WithStart(own.coordinates, start), pass, {}, &predicted, /*velocities=*/nullptr, &forces);
    if (!rollout.ok()) return {};
    return model->observation().Residuals(predicted, forces.predicted)(judged_.rows);
  }

  Eigen::VectorXd RollEstimate(const RecordedMotion& motion, const HeldOutStart& start) const {
    const HeldOutBlocks own = BlocksFor(motion, recording_, blocks_, values_);
    RecordingModel model(motion, own.blocks, {}, start.start);
    return ResidualsOf(own, start, &model);
  }

  Eigen::VectorXd RollRefined() const {
    try {
      return RollEstimate(RefineMotion(motion_), {});
    } catch (const Error&) {  // a mesh that cannot be refined
      return {};
    }
  }

  const RecordedMotion& motion_;
  int number_, recording_;
  HeldOutStart start_;
  const std::vector<ParameterBlock>& blocks_;
  const Eigen::VectorXd& values_;
  const FitPosterior& posterior_;
  const HeldBandOptions& options_;
  Eigen::MatrixXd drawn_;  // [p' x D]
  JudgedRows judged_;
  int num_fitted_ = 0;                  // recordings with parameters of their own
  std::optional<StartSpread> spread_;   // none: the start is as certain as the fit has it
  std::unique_ptr<SmoothField> field_;  // null: no force
};

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

void AddRecording(const JudgedRows& judged, const Eigen::MatrixXd& draws, HeldBands* bands) {
  for (Eigen::Index row = 0; row < draws.rows(); ++row) {
    const Eigen::MatrixXd own = draws.row(row);
    const Eigen::RowVectorXd quantiles = BandsOf(own);
    constexpr double kRounding = 1e-9;  // s
    const auto lead = std::find_if(bands->leads.begin(), bands->leads.end(), [&](const HeldBandCell& cell) {
      return judged.leads[row] <= cell.until + kRounding;
    });
    AddToCell(judged.sigma[row], own.transpose(), quantiles, &*lead);
    AddToCell(judged.sigma[row], own.transpose(), quantiles, &bands->all);
  }
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
    AddRecording(next.held->judged(), draws, &bands);
    judged.push_back(std::move(next));
  }
  if (options.calibrates && bands.has_force && bands.why_not.empty()) bands.calibration = Calibrate(options, &judged);
  const auto is_empty = [](const HeldBandCell& cell) { return cell.num == 0.0; };
  bands.leads.erase(std::remove_if(bands.leads.begin(), bands.leads.end(), is_empty), bands.leads.end());
  for (HeldBandCell& cell : bands.leads) Finish(&cell);
  if (bands.all.num > 0.0) {
    Finish(&bands.all);
  } else if (bands.why_not.empty()) {
    bands.why_not = "neither a tracked point nor a force was held out";
  }
  if (!bands.why_not.empty()) bands.leads.clear();
  return bands;
}

}  // namespace clothid

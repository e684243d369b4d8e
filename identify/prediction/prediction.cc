#include "identify/prediction/prediction.h"

#include <Eigen/QR>
#include <algorithm>
#include <cmath>
#include <utility>

#include "datasets/formats/track_checks.h"
#include "datasets/synthetic/synthetic.h"
#include "identify/base/parallel_for.h"
#include "identify/prediction/random_streams.h"
#include "identify/prediction/sampler.h"
#include "sim/base/error.h"

namespace clothid {
namespace {

// What every draw takes of d_s and d_m [D x 2].
Eigen::MatrixXd FinerFactors(const PredictionOptions& options) {
  Eigen::MatrixXd factors(options.num_draws, 2);
  for (int draw = 0; draw < options.num_draws; ++draw) {
    factors.row(draw) = NormalStream(options.seed, draw, DrawStream::kFiner).Draw(1, 2);
  }
  return factors;
}

std::vector<Draw> RollAll(const Sampler& sampler, const PredictionOptions& options) {
  std::vector<Draw> draws(static_cast<std::size_t>(options.num_draws));
  const auto roll = [&](int draw) {
    const bool is_cancelled = options.cancel != nullptr && *options.cancel;
    if (!is_cancelled) draws[static_cast<std::size_t>(draw)] = sampler.Roll(draw);
  };
  const auto tell = [&](int /*draw*/, int num_done) {
    if (options.on_rollout) options.on_rollout(num_done);
  };
  ParallelFor(options.num_draws, options.num_threads, roll, tell);
  return draws;
}

void ExpectOptions(const Scene& scene, const PredictionOptions& options) {
  ExpectUsage(options.num_draws >= kLeastDraws && options.num_draws <= kMostDraws,
              "--draws: expected a number from " + std::to_string(kLeastDraws) + " to " + std::to_string(kMostDraws));
  const Eigen::Index num_frames = FrameSteps(options.frame_rate, scene.time_step, scene.num_steps()).size();
  const double bytes = sizeof(double) * static_cast<double>(scene.initial_positions.size()) *
                       static_cast<double>(num_frames) *
                       (options.num_draws * (options.keeps_draws ? 2 : 1) + static_cast<int>(kBandQuantiles.size()));
  ExpectUsage(bytes <= static_cast<double>(kMaxTrackBytes),
              "--draws: " + std::to_string(options.num_draws) + " draws of " + std::to_string(num_frames) +
                  " frames take " + std::to_string(static_cast<long long>(bytes) >> 20) + " MB; expected at most " +
                  std::to_string(kMaxTrackBytes >> 20) + " MB: fewer draws, or a lower --frame_rate");
}

// Orthonormal bases of centred columns: the coordinates of the parameters [D x p], each of them by itself, and they
// with what is taken of step and mesh [D x (p + 2)].
struct Regressors {
  Eigen::MatrixXd parameters, each, all;
};

Eigen::MatrixXd BasisOf(Eigen::MatrixXd columns) {
  columns.rowwise() -= columns.colwise().mean().eval();
  const Eigen::ColPivHouseholderQR<Eigen::MatrixXd> qr(columns);
  return qr.householderQ() * Eigen::MatrixXd::Identity(columns.rows(), qr.rank());
}

Regressors RegressorsOf(const FitPosterior& posterior, const Eigen::MatrixXd& values,
                        const Eigen::MatrixXd& finer_factors) {
  Eigen::MatrixXd coordinates = values.transpose();
  for (Eigen::Index i = 0; i < coordinates.cols(); ++i) {
    const PosteriorParameter& parameter = posterior.parameters[static_cast<std::size_t>(i)];
    for (double& value : coordinates.col(i)) value = parameter.ToCoordinate(value);
  }
  Regressors regressors;
  regressors.parameters = BasisOf(coordinates);
  coordinates.rowwise() -= coordinates.colwise().mean().eval();
  regressors.each = coordinates;
  for (auto column : regressors.each.colwise()) column.normalize();
  Eigen::MatrixXd all(coordinates.rows(), coordinates.cols() + finer_factors.cols());
  all << regressors.each, finer_factors;
  regressors.all = BasisOf(all);
  return regressors;
}

// `explained` of `total`, less what so many regressors of D draws explain of anything.
double ExplainedShare(double explained, double total, Eigen::Index num_regressors, Eigen::Index num_draws) {
  if (!(total > 0.0)) return std::numeric_limits<double>::quiet_NaN();
  const double chance = static_cast<double>(num_regressors) / static_cast<double>(num_draws - 1);
  return std::clamp((explained / total - chance) / (1.0 - chance), 0.0, 1.0);
}

// Of start and of handles alone [T] m^2.
struct VariancesAlone {
  Eigen::VectorXd start, handles;
};

// Adds frame `frame`, with the draws of its free coordinates [R x D].
void AddShares(const Regressors& regressors, const VariancesAlone& alone, const Eigen::MatrixXd& draws,
               Eigen::Index frame, Prediction* prediction) {
  const Eigen::Index num_draws = draws.cols();
  const Eigen::MatrixXd centred = draws.colwise() - draws.rowwise().mean();
  const double total = centred.squaredNorm();
  prediction->spread[frame] = std::sqrt(total / static_cast<double>(draws.rows() * (num_draws - 1)));
  SpreadShares* shares = &prediction->shares;
  const auto share = [&](const Eigen::MatrixXd& basis) {
    return ExplainedShare((centred * basis).squaredNorm(), total, basis.cols(), num_draws);
  };
  shares->parameters[frame] = share(regressors.parameters);
  const double by_all = share(regressors.all);
  shares->finer[frame] = std::max(by_all - shares->parameters[frame], 0.0);
  const double rest = 1.0 - std::max(by_all, shares->parameters[frame]);
  const double variance = std::pow(prediction->spread[frame], 2);
  shares->start[frame] = std::min(alone.start[frame] / variance, rest);
  shares->handles[frame] = std::min(alone.handles[frame] / variance, rest - shares->start[frame]);
  shares->rest[frame] = rest - shares->start[frame] - shares->handles[frame];
  for (Eigen::Index i = 0; i < regressors.each.cols(); ++i) {
    shares->each(frame, i) = share(regressors.each.col(i));
  }
}

std::vector<int> FreeCoordinates(const Scene& scene) {
  std::vector<char> is_handle(static_cast<std::size_t>(scene.mesh.num_nodes()), 0);
  for (const int node : scene.handles.nodes) is_handle[static_cast<std::size_t>(node)] = 1;
  std::vector<int> free;
  for (int node = 0; node < scene.mesh.num_nodes(); ++node) {
    if (is_handle[static_cast<std::size_t>(node)]) continue;
    for (int axis = 0; axis < 3; ++axis) free.push_back(3 * node + axis);
  }
  return free;
}

// Draws of derived numbers, frame by frame.
class DerivedDraws {
 public:
  DerivedDraws(const Scene& scene, const std::vector<const Draw*>& draws, const FinerChanges& finer,
               const Eigen::MatrixXd& factors, Eigen::Index num_frames, std::vector<DerivedBands>* bands)
      : scene_(scene), draws_(draws), finer_(finer), factors_(factors), bands_(*bands) {
    for (DerivedBands& band : bands_) {
      const bool is_slip = band.request.kind == DerivedKind::kSlip;
      for (Eigen::MatrixXd& quantile : band.quantiles)
        quantile.resize(NumRows(band.request.kind), is_slip ? 1 : num_frames);
      if (is_slip) Set(0, Slips(), &band);
    }
  }

  // `in_frame` [3N x D]: the positions of the draws, with what step and mesh change.
  void AddFrame(Eigen::Index frame, const Eigen::MatrixXd& in_frame) {
    for (DerivedBands& band : bands_) {
      if (band.request.kind != DerivedKind::kSlip) Set(frame, NumbersOf(band.request, frame, in_frame), &band);
    }
  }

 private:
  Eigen::Index NumRows(DerivedKind kind) const {
    if (kind == DerivedKind::kPoint) return 3;
    return kind == DerivedKind::kForce ? draws_.front()->forces.rows() : 1;
  }

  static void Set(Eigen::Index frame, const Eigen::MatrixXd& numbers, DerivedBands* band) {
    const Eigen::MatrixXd quantiles = BandsOf(numbers);
    for (std::size_t q = 0; q < kBandQuantiles.size(); ++q) {
      band->quantiles[q].col(frame) = quantiles.col(static_cast<Eigen::Index>(q));
    }
  }

  // [R x D].
  Eigen::MatrixXd NumbersOf(const DerivedRequest& request, Eigen::Index frame, const Eigen::MatrixXd& in_frame) const {
    if (request.kind == DerivedKind::kPoint) return in_frame.middleRows<3>(3 * request.node);
    Eigen::MatrixXd numbers(NumRows(request.kind), in_frame.cols());
    for (Eigen::Index d = 0; d < numbers.cols(); ++d) {
      if (request.kind == DerivedKind::kArea) numbers(0, d) = CoveredArea(scene_, in_frame.col(d));
      if (request.kind == DerivedKind::kStrain) numbers(0, d) = LargestStrain(scene_.mesh, in_frame.col(d));
      if (request.kind != DerivedKind::kForce) continue;
      numbers.col(d) = draws_[static_cast<std::size_t>(d)]->forces.col(frame);
      if (finer_.step.forces.size() > 0) numbers.col(d) += factors_(d, 0) * finer_.step.forces.col(frame);
      if (finer_.mesh.forces.size() > 0) numbers.col(d) += factors_(d, 1) * finer_.mesh.forces.col(frame);
    }
    return numbers;
  }

  Eigen::MatrixXd Slips() const {
    Eigen::MatrixXd slips(1, static_cast<Eigen::Index>(draws_.size()));
    for (Eigen::Index d = 0; d < slips.cols(); ++d) {
      slips(0, d) = draws_[static_cast<std::size_t>(d)]->slip;
      if (finer_.step.positions.size() > 0) slips(0, d) += factors_(d, 0) * finer_.step.slip;
      if (finer_.mesh.positions.size() > 0) slips(0, d) += factors_(d, 1) * finer_.mesh.slip;
    }
    return slips.cwiseMax(0.0);
  }

  const Scene& scene_;
  const std::vector<const Draw*>& draws_;
  const FinerChanges& finer_;
  const Eigen::MatrixXd& factors_;
  std::vector<DerivedBands>& bands_;
};

}  // namespace

double Prediction::WorthUntil() const {
  double missed = 0.0, missed_at_rest = 0.0;
  for (Eigen::Index frame = 1; frame < times.size(); ++frame) {
    missed += spread[frame] * spread[frame];
    missed_at_rest += moved[frame] * moved[frame];
    if (missed > 0.0 && missed >= missed_at_rest) return times[frame];
  }
  return std::numeric_limits<double>::infinity();
}

Prediction Predict(const Scene& scene, const FitPosterior& posterior, const PredictionOptions& options) {
  ExpectOptions(scene, options);
  const Sampler sampler(scene, posterior, options);
  std::vector<Draw> draws = RollAll(sampler, options);
  Prediction prediction;
  prediction.has_force = sampler.has_force();
  prediction.has_start = sampler.has_start();
  prediction.has_handles = sampler.has_handles();
  const FinerChanges finer = sampler.RollFiner(&prediction.no_step, &prediction.no_mesh);
  std::vector<Eigen::Index> kept;
  for (std::size_t d = 0; d < draws.size(); ++d) {
    if (draws[d].failure.empty()) {
      kept.push_back(static_cast<Eigen::Index>(d));
    } else if (++prediction.num_failed == 1) {
      prediction.failure = draws[d].failure;
    }
  }
  if (options.cancel != nullptr && *options.cancel) return prediction;
  prediction.num_draws = static_cast<int>(kept.size());
  if (prediction.num_draws < kLeastDraws) {
    FailOnData(posterior.path, std::to_string(prediction.num_failed) + " of " + std::to_string(options.num_draws) +
                                   " rollouts failed, expected at least " + std::to_string(kLeastDraws) +
                                   " that do not: " + prediction.failure);
  }
  Eigen::MatrixXd factors = FinerFactors(options)(kept, Eigen::all);
  if (finer.step.positions.size() == 0) factors.col(0).setZero();
  if (finer.mesh.positions.size() == 0) factors.col(1).setZero();
  const Regressors regressors = RegressorsOf(posterior, sampler.values()(Eigen::all, kept), factors);
  const Eigen::Index num_frames = sampler.frame_steps().size(), num_rows = scene.initial_positions.size();
  prediction.times = scene.start_time + (scene.time_step * sampler.frame_steps().array());
  for (Eigen::MatrixXd& quantile : prediction.quantiles) quantile.resize(num_rows, num_frames);
  prediction.spread.setZero(num_frames);
  prediction.moved.setZero(num_frames);
  prediction.shares.parameters.setZero(num_frames);
  prediction.shares.finer.setZero(num_frames);
  prediction.shares.rest.setZero(num_frames);
  prediction.shares.start.setZero(num_frames);
  prediction.shares.handles.setZero(num_frames);
  prediction.shares.each.setZero(num_frames, regressors.each.cols());
  const std::vector<int> free = FreeCoordinates(scene);
  VariancesAlone alone = {Eigen::VectorXd::Zero(num_frames), Eigen::VectorXd::Zero(num_frames)};
  if (prediction.has_start && !free.empty()) alone.start = sampler.VarianceAlone(/*of_start=*/true, free);
  if (prediction.has_handles && !free.empty()) alone.handles = sampler.VarianceAlone(/*of_start=*/false, free);
  std::vector<const Draw*> kept_draws;
  for (const Eigen::Index d : kept) kept_draws.push_back(&draws[static_cast<std::size_t>(d)]);
  for (const DerivedRequest& request : options.derived) prediction.derived.push_back({request, {}});
  prediction.cloths.assign(options.keeps_draws ? kept.size() : std::min<std::size_t>(kShownCloths, kept.size()),
                           Eigen::MatrixXd(num_rows, num_frames));
  DerivedDraws derived(scene, kept_draws, finer, factors, num_frames, &prediction.derived);
  Eigen::MatrixXd in_frame(num_rows, prediction.num_draws);
  for (Eigen::Index frame = 0; frame < num_frames; ++frame) {
    for (Eigen::Index d = 0; d < in_frame.cols(); ++d) {
      in_frame.col(d) = kept_draws[static_cast<std::size_t>(d)]->positions.col(frame);
    }
    if (finer.step.positions.size() > 0) in_frame += finer.step.positions.col(frame) * factors.col(0).transpose();
    if (finer.mesh.positions.size() > 0) in_frame += finer.mesh.positions.col(frame) * factors.col(1).transpose();
    if (!free.empty()) AddShares(regressors, alone, in_frame(free, Eigen::all), frame, &prediction);
    derived.AddFrame(frame, in_frame);
    for (std::size_t i = 0; i < prediction.cloths.size(); ++i) {
      prediction.cloths[i].col(frame) = in_frame.col(static_cast<Eigen::Index>(i));
    }
    const Eigen::MatrixXd bands = BandsOf(in_frame);
    for (std::size_t q = 0; q < kBandQuantiles.size(); ++q) {
      prediction.quantiles[q].col(frame) = bands.col(static_cast<Eigen::Index>(q));
    }
    const Eigen::VectorXd change = (prediction.median().col(frame) - prediction.median().col(0))(free);
    if (!free.empty()) prediction.moved[frame] = change.norm() / std::sqrt(static_cast<double>(change.size()));
  }
  return prediction;
}

}  // namespace clothid

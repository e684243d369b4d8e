#include "identify/prediction/force_match.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <memory>

#include "identify/base/parallel_for.h"
#include "identify/prediction/held_bands.h"
#include "identify/prediction/held_recording.h"
#include "sim/cloth/cloth_model.h"
#include "sim/matrix/dense.h"

namespace clothid {
namespace {

constexpr std::array<double, 3> kMemories = {0.1, 0.3, 1.0};  // s
constexpr double kFirstShare = 0.01;                          // of the weight, where sizes are looked for first
constexpr double kLeastShare = 1e-3;                          // of the weight: less is left out
constexpr double kLengthShare = 1.0 / 3.0;                    // of the size of the cloth, where nothing tells it

using LeadSums = Eigen::Array<double, static_cast<Eigen::Index>(kHeldLeads.size()), 1>;

// The mean squares, m^2, of what rollouts of all recordings miss or are moved by, per lead time.
struct LeadMeans {
  LeadSums squares = LeadSums::Zero(), num = LeadSums::Zero();
  LeadSums variances = LeadSums::Zero();  // of `squares` by noise

  // `changes` over sigma; `less`: the variance of the noise, which is taken off their squares.
  void Add(const JudgedRows& judged, const Eigen::VectorXd& changes, double less) {
    for (Eigen::Index row = 0; row < changes.size(); ++row) {
      const auto lead = static_cast<Eigen::Index>(LeadOf(judged.leads[row]));
      squares[lead] += judged.sigma[row] * judged.sigma[row] * (changes[row] * changes[row] - less);
      variances[lead] += 2.0 * std::pow(judged.sigma[row] * judged.sigma[row] * less, 2);
      num[lead] += 1.0;
    }
  }
  LeadSums Means() const { return squares / num.max(1.0); }
  // Whether a mean is larger than three deviations of its noise.
  bool IsBeyondNoise() const { return (Means() > 3.0 * Deviations()).any(); }
  LeadSums Deviations() const { return variances.sqrt() / num.max(1.0); }  // of the means
};

// All fitted recordings, and their rollouts.
class FittedRollouts {
 public:
  FittedRollouts(const std::vector<RecordedMotion>& motions, const std::vector<ParameterBlock>& blocks,
                 const Eigen::VectorXd& values, const std::vector<HeldOutStart>& starts,
                 const ForceMatchOptions& options)
      : options_(options) {
    const int num = std::max<int>(1, options.num_draws / static_cast<int>(motions.size()));
    band_options_.num_draws = std::max(num, 2);
    band_options_.seed = options.seed;
    band_options_.cancel = options.cancel;
    for (std::size_t r = 0; r < motions.size(); ++r) {
      recordings_.push_back(std::make_unique<HeldRecording>(motions[r], static_cast<int>(r), static_cast<int>(r),
                                                            starts[r], blocks, values, nothing_drawn_, band_options_));
    }
  }

  // E_l, by rollouts that err by less than what may be missing.
  LeadMeans Missed() const {
    const std::vector<Eigen::VectorXd> exact = RollEstimates(Precision::kFull);
    LeadMeans missed;
    for (std::size_t r = 0; r < recordings_.size(); ++r) {
      if (!recordings_[r]->judged().are_forces)
        missed.Add(recordings_[r]->judged(), exact[r], recordings_[r]->noise_variance());
    }
    return missed;
  }

  // For `MovedBy`.
  void RollLoosely() { estimates_ = RollEstimates(Precision::kLoose); }

  // What draws of `force` move.
  LeadSums MovedBy(const LastingForce& force) const {
    const int num_draws = band_options_.num_draws;
    std::vector<Eigen::VectorXd> forced(recordings_.size() * static_cast<std::size_t>(num_draws));
    std::vector<ForceSource> sources;
    for (const auto& recording : recordings_) sources.push_back(recording->Lacking({force}));
    const auto roll = [&](int task) {
      const auto r = static_cast<std::size_t>(task / num_draws);
      if (estimates_[r].size() == 0 || IsCancelled()) return;
      forced[static_cast<std::size_t>(task)] =
          recordings_[r]->RollEstimate(&sources[r], task % num_draws, Precision::kLoose);
    };
    ParallelFor(static_cast<int>(forced.size()), options_.num_threads, roll);
    LeadMeans moved;
    for (std::size_t task = 0; task < forced.size(); ++task) {
      const std::size_t r = task / static_cast<std::size_t>(num_draws);
      if (forced[task].size() > 0 && !recordings_[r]->judged().are_forces)
        moved.Add(recordings_[r]->judged(), forced[task] - estimates_[r], 0.0);
    }
    return moved.Means();
  }

 private:
  // One per recording, as of `HeldRecording::RollEstimate`, without forces.
  std::vector<Eigen::VectorXd> RollEstimates(Precision precision) const {
    std::vector<Eigen::VectorXd> estimates(recordings_.size());
    const auto roll = [&](int r) {
      const auto index = static_cast<std::size_t>(r);
      estimates[index] = recordings_[index]->RollEstimate(nullptr, 0, precision);
    };
    ParallelFor(static_cast<int>(recordings_.size()), options_.num_threads, roll);
    return estimates;
  }
  bool IsCancelled() const { return options_.cancel != nullptr && *options_.cancel; }

  const ForceMatchOptions& options_;
  HeldBandOptions band_options_;
  FitPosterior nothing_drawn_;
  std::vector<std::unique_ptr<HeldRecording>> recordings_;
  std::vector<Eigen::VectorXd> estimates_;  // loose ones
};

// N/m^2: rho g of all cloths, or of any where there is no gravity.
double WeightOf(const std::vector<RecordedMotion>& motions) {
  double weight = 0.0;
  constexpr double kGravity = 9.81;
  for (const RecordedMotion& motion : motions) {
    const double gravity = motion.scene.gravity.norm();
    weight += motion.scene.material.density * (gravity > 0.0 ? gravity : kGravity);
  }
  return weight / static_cast<double>(motions.size());
}

// x_j of forces that move by `moved` what the told one, which moves by F, leaves of E.
Eigen::VectorXd SharesOf(const LeadMeans& missed, const LeadSums& by_told, const std::vector<LeadSums>& moved) {
  const LeadSums means = missed.Means();
  const LeadSums scale = by_told + means.max(0.0) + missed.Deviations();
  std::vector<Eigen::Index> seen;
  for (Eigen::Index lead = 0; lead < scale.size(); ++lead) {
    if (missed.num[lead] > 0.0 && scale[lead] > 0.0) seen.push_back(lead);
  }
  Eigen::MatrixXd columns(static_cast<Eigen::Index>(seen.size()), static_cast<Eigen::Index>(moved.size()));
  for (Eigen::Index j = 0; j < columns.cols(); ++j) {
    columns.col(j) = (moved[static_cast<std::size_t>(j)] / scale)(seen).matrix();
  }
  return NonNegativeLeastSquares(columns, ((means - by_told) / scale)(seen).matrix());
}

}  // namespace

Eigen::VectorXd NonNegativeLeastSquares(const Eigen::MatrixXd& a, const Eigen::VectorXd& b) {
  const Eigen::Index size = a.cols();
  Eigen::VectorXd best = Eigen::VectorXd::Zero(size);
  double least = b.squaredNorm();
  for (unsigned kept = 1; kept < (1U << static_cast<unsigned>(size)); ++kept) {
    std::vector<Eigen::Index> columns;
    for (Eigen::Index j = 0; j < size; ++j) {
      if ((kept >> static_cast<unsigned>(j)) & 1U) columns.push_back(j);
    }
    const Eigen::MatrixXd own = a(Eigen::all, columns);
    const Eigen::VectorXd solution = LeastSquaresSolution(own, b);
    const double rest = (own * solution - b).squaredNorm();
    if (!(solution.minCoeff() >= 0.0) || !(rest < least)) continue;
    least = rest;
    best.setZero();
    best(columns) = solution;
  }
  return best;
}

std::vector<LastingForce> MatchForces(const std::vector<RecordedMotion>& motions,
                                      const std::vector<ParameterBlock>& blocks, const Eigen::VectorXd& values,
                                      const std::vector<HeldOutStart>& starts, const std::optional<LastingForce>& told,
                                      const ForceMatchOptions& options) {
  std::vector<LastingForce> forces;
  if (told) forces.push_back(*told);
  FittedRollouts rollouts(motions, blocks, values, starts, options);
  const LeadMeans missed = rollouts.Missed();
  if (!(missed.num.sum() > 0.0) || !missed.IsBeyondNoise()) return forces;
  rollouts.RollLoosely();
  LeadSums by_told = LeadSums::Zero();
  if (told) by_told = rollouts.MovedBy(*told);
  const double length = told ? told->length : kLengthShare * ClothSize(motions.front().scene.mesh);
  double duration = 0.0;
  for (const RecordedMotion& motion : motions) duration = std::max(duration, motion.times[motion.times.size() - 1]);
  const double weight = WeightOf(motions);
  std::vector<LastingForce> slow;
  for (const double memory : kMemories) {
    if (memory <= duration) slow.push_back({kFirstShare * weight, memory, length});
  }
  for (int pass = 0; pass < 2 && !slow.empty(); ++pass) {
    std::vector<LeadSums> moved;
    for (const LastingForce& force : slow) moved.push_back(rollouts.MovedBy(force));
    const Eigen::VectorXd shares = SharesOf(missed, by_told, moved);
    std::vector<LastingForce> kept;
    for (std::size_t j = 0; j < slow.size(); ++j) {
      const double share = shares[static_cast<Eigen::Index>(j)];
      if (std::sqrt(share) * slow[j].size > kLeastShare * weight)
        kept.push_back({std::sqrt(share) * slow[j].size, slow[j].time, slow[j].length});
    }
    slow = kept;
  }
  forces.insert(forces.end(), slow.begin(), slow.end());
  return forces;
}

}  // namespace clothid

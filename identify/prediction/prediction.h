// A motion that nobody has seen, simulated with what a fit has learnt, and how far that may be off.
//
// Every draw is a rollout of the scene with parameters of the posterior (identify/prediction/posterior.h) and, where
// the fit has found a force that its model lacks, a draw of such a force (identify/prediction/random_force.h). What
// step and mesh of the scene itself do, nobody has fitted: rollouts of the estimates with half the step, and on a mesh
// of twice the density, differ from one without by d_s and d_m of every node and time, and a draw moves by
//   e_s d_s + e_m d_m,   e_s, e_m of a normal distribution of variance one.
//
// The quantile p of D draws is between those of rank floor(p (D + 1)) and the next, so that in the mean over draws so
// much of what follows lies below it: bands of 90 % need 19 draws.
//
// Shares tell what makes the spread. Of every coordinate and time the draws are regressed on the coordinates q of the
// parameters, and on these with e_s and e_m; what p regressors explain of anything, p/(D - 1), is taken off.
#ifndef CLOTHID_IDENTIFY_PREDICTION_PREDICTION_H_
#define CLOTHID_IDENTIFY_PREDICTION_PREDICTION_H_

#include <Eigen/Core>
#include <array>
#include <atomic>
#include <cstdint>
#include <functional>
#include <limits>
#include <string>
#include <utility>
#include <vector>

#include "identify/prediction/posterior.h"
#include "sim/scene/scene.h"

namespace clothid {

inline constexpr int kLeastDraws = 19, kMostDraws = 10000;
inline constexpr std::array<double, 5> kBandQuantiles = {0.05, 0.25, 0.5, 0.75, 0.95};

struct PredictionOptions {
  int num_draws = 50;
  std::uint64_t seed = 1;
  bool with_force = true;                   // what the model lacks, where the fit has found it
  bool with_step = true, with_mesh = true;  // what those of the scene are off by
  double frame_rate = 0.0;                  // Hz; 0: a frame per step
  int num_threads = 1;                      // that run rollouts side by side; the result does not depend on them
  const std::atomic<bool>* cancel = nullptr;
  std::function<void(int num_done)> on_rollout = {};  // never two at a time
};

// Quantiles [R x 5], `kBandQuantiles`, of the rows of draws [R x D].
Eigen::MatrixXd BandsOf(const Eigen::MatrixXd& draws);

// Of the spread in a frame [T]; NaN where nothing is spread.
struct SpreadShares {
  Eigen::VectorXd parameters;  // of all parameters together
  Eigen::MatrixXd each;        // [T x p] what would go if that one were known; correlated ones share what they have
  Eigen::VectorXd finer;       // of step and mesh of the scene
  Eigen::VectorXd rest;        // of the force, and what is not linear in the parameters
};

struct Prediction {
  Eigen::VectorXd times;                     // [T] s
  std::array<Eigen::MatrixXd, 5> quantiles;  // [3N x T] m each, of kBandQuantiles
  Eigen::VectorXd spread;  // [T] m, root mean square over free nodes of the draws' deviation, of an axis
  Eigen::VectorXd moved;   // [T] m, likewise how far the median is from the start
  SpreadShares shares;
  int num_draws = 0, num_failed = 0;  // those that failed are in no number
  std::string failure;                // of the first that failed; empty: none
  bool has_force = false;
  // Why the error of step or mesh of the scene is not known, though it was asked for; empty: it is.
  std::string no_step, no_mesh;

  const Eigen::MatrixXd& median() const { return quantiles[2]; }
  // s: until when, over the time so far, the median has been nearer to what the draws do than the cloth at rest, its
  // start, as root mean squares. Infinite: to the end.
  double WorthUntil() const;
};

// Throws `Error`: kUsage for numbers of draws and frame rates out of range, and for more than 4 GB of positions;
// kBadData where so many draws fail that kLeastDraws are not left. `posterior` must fit the scene (`FitToScene`).
// Where it was cancelled the result is not to be used.
Prediction Predict(const Scene& scene, const Posterior& posterior, const PredictionOptions& options);

}  // namespace clothid

#endif  // CLOTHID_IDENTIFY_PREDICTION_PREDICTION_H_

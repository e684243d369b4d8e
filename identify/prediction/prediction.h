// A motion that nobody has seen, simulated with what a fit has learnt, and how far that may be off.
//
// Every draw is a rollout of the scene with parameters of the posterior (identify/prediction/posterior.h) and, where
// the fit has found a force that its model lacks, a draw of such a force (identify/prediction/random_force.h). What
// step and mesh of the scene itself do, nobody has fitted: rollouts of the estimates with half the step, and on a mesh
// of twice the density, differ from one without by d_s and d_m of every node and time, and a draw moves by
//   e_s d_s + e_m d_m,   e_s, e_m of a normal distribution of variance one.
//
// Where the fit has estimated how its recordings started, so may the scene, and the path of its handles
// (identify/prediction/random_start.h).
//
// Shares tell what makes the spread. Of every coordinate and time the draws are regressed on the coordinates q of the
// parameters, and on these with e_s and e_m; what p regressors explain of anything, p/(D - 1), is taken off. Start and
// handles have too many numbers for that: theirs is the variance of `kDrawsAlone` rollouts of the estimates in which
// nothing else is drawn.
#ifndef CLOTHID_IDENTIFY_PREDICTION_PREDICTION_H_
#define CLOTHID_IDENTIFY_PREDICTION_PREDICTION_H_

#include <Eigen/Core>
#include <array>
#include <string>
#include <vector>

#include "identify/prediction/bands.h"
#include "identify/prediction/derived.h"
#include "identify/prediction/posterior.h"
#include "identify/prediction/prediction_options.h"
#include "sim/scene/scene.h"

namespace clothid {

// Of the spread in a frame [T]; NaN where nothing is spread.
struct SpreadShares {
  Eigen::VectorXd parameters;  // of all parameters together
  Eigen::MatrixXd each;        // [T x p] what would go if that one were known; correlated ones share what they have
  Eigen::VectorXd finer;       // of step and mesh of the scene
  Eigen::VectorXd start;       // of the start
  Eigen::VectorXd handles;     // of the path of the handles
  Eigen::VectorXd rest;        // of the force, and what is not linear in the parameters
};

inline constexpr int kShownCloths = 8;

struct Prediction {
  Eigen::VectorXd times;                     // [T] s
  std::array<Eigen::MatrixXd, 5> quantiles;  // [3N x T] m each, of kBandQuantiles
  Eigen::VectorXd spread;  // [T] m, root mean square over free nodes of the draws' deviation, of an axis
  Eigen::VectorXd moved;   // [T] m, likewise how far the median is from the start
  SpreadShares shares;
  std::vector<DerivedBands> derived;    // of `PredictionOptions::derived`
  std::vector<Eigen::MatrixXd> cloths;  // [3N x T] m, draws that worked: the first kShownCloths to look at, or all
  int num_draws = 0, num_failed = 0;    // those that failed are in no number
  std::string failure;                  // of the first that failed; empty: none
  bool has_force = false, has_start = false, has_handles = false;  // whether it was drawn
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
Prediction Predict(const Scene& scene, const FitPosterior& posterior, const PredictionOptions& options);

}  // namespace clothid

#endif  // CLOTHID_IDENTIFY_PREDICTION_PREDICTION_H_

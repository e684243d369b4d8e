// Draws of what may happen: the bands that they make, and how good they are once it has happened.
#ifndef CLOTHID_IDENTIFY_PREDICTION_BANDS_H_
#define CLOTHID_IDENTIFY_PREDICTION_BANDS_H_

#include <Eigen/Core>
#include <array>

namespace clothid {

inline constexpr int kLeastDraws = 19, kMostDraws = 10000;
inline constexpr std::array<double, 5> kBandQuantiles = {0.05, 0.25, 0.5, 0.75, 0.95};

// Where the quantile p of D sorted draws is: between those of rank floor(p (D + 1)), counted from 1, and the next, so
// that in the mean over draws so much of what follows lies below it: bands of 90 % need 19 draws. Beyond the first and
// the last draw it is these.
struct BandRank {
  Eigen::Index below = 0, above = 0;  // counted from 0
  double share = 0.0;                 // of the way between them
};
BandRank RankOf(double quantile, Eigen::Index num_draws);
// So far on the way from `below` to `above`, which may be infinite.
double Between(double below, double above, double share);

// Quantiles [R x 5], `kBandQuantiles`, of the rows of draws [R x D], D >= 1, which may be infinite.
Eigen::MatrixXd BandsOf(const Eigen::MatrixXd& draws);

// The continuous ranked probability score of draws x [D] of what turned out to be `seen`,
//   int (F(z) - 1[z >= seen])^2 dz = 1/D sum |x_i - seen| - 1/(2 D^2) sum |x_i - x_j|,
// F the share of draws up to z: in their unit, 0 at best. That of one draw is its absolute error, and draws far from
// each other are no better than ones that miss as far (Gneiting and Raftery 2007).
double RankedScore(const Eigen::VectorXd& draws, double seen);

}  // namespace clothid

#endif  // CLOTHID_IDENTIFY_PREDICTION_BANDS_H_

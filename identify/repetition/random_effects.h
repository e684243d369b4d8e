// Repetitions of one experiment: estimates y_r with known standard deviations s_r of a parameter that varies from one
// recording to the next, by another piece of fabric, another set-up, or what the model leaves out.
//
//   y_r ~ N(m, tau^2 + s_r^2),   r = 1 .. R,   w_r = 1/(tau^2 + s_r^2),   W = sum w_r
//   m = sum w_r y_r/W
//   tau: restricted maximum likelihood (Patterson and Thompson 1971; Viechtbauer 2005, Journal of Educational and
//     Behavioral Statistics 30): the tau^2 >= 0 of the largest
//       l(tau^2) = 1/2 sum log w_r - 1/2 log W - 1/2 sum w_r (y_r - m)^2,
//     a root of its score sum w_r^2 (y_r - m)^2 - W + sum w_r^2/W, or zero. Beside it that of Paule and Mandel (1982),
//     where sum w_r (y_r - m)^2 = R - 1.
//   interval of tau (Viechtbauer 2007, Statistics in Medicine 26, "Q profile"): where sum w_r (y_r - m)^2, which falls
//     with tau, passes the 97.5 and the 2.5 % quantile of chi-square with R - 1 degrees of freedom.
//   interval of m (Hartung and Knapp 2001, Statistics in Medicine 20): m +- t_{R-1} sqrt(var(m)), with
//       var(m) = max(1, sum w_r (y_r - m)^2/(R - 1))/W,
//     never less than the s_r alone leave (Knapp and Hartung 2003): that few estimates are close by chance is no
//     knowledge.
//   interval of the next specimen: of its true value, not of its estimate: m +- t_{R-2} sqrt(tau^2 + var(m)), R >= 3.
//   Cochran's Q = sum (y_r - m_0)^2/s_r^2, m_0 being m at tau = 0: chi-square with R - 1 degrees of freedom where
//     nothing but the s_r scatters.
//   typical s (Higgins and Thompson 2002): s^2 = (R - 1) sum s_r^-2/((sum s_r^-2)^2 - sum s_r^-4), s_r where all are
//     equal. sqrt(tau^2 + s^2) is how far estimates differ, s what their own intervals explain of it.
//   leave one out: (y_r - m_(r))/sqrt(tau_(r)^2 + s_r^2 + 1/W_(r)), all with (r) from the others alone, in joint
//   standard
//     deviations; R >= 3, for two cannot tell which of them is off. A recording does not fit the others where Student's
//     t with R - 2 degrees of freedom is that large with a probability below 0.05/R (Bonferroni).
//
// **A common error**: y_r have an error b_r, known in size alone, that is the same in all repetitions, as that of the
// time step is. It scatters nothing, so it is no part of s_r; it moves m by b = sum w_r b_r/W, and the intervals of m
// and of the next specimen have the half-widths hypot(those above, 1.96 b).
//
// All numbers are in one coordinate: of the logarithm for what is a scale (costs/prediction/parameter_block.h).
#ifndef CLOTHID_IDENTIFY_REPETITION_RANDOM_EFFECTS_H_
#define CLOTHID_IDENTIFY_REPETITION_RANDOM_EFFECTS_H_

#include <Eigen/Core>
#include <limits>
#include <vector>

namespace clothid {

struct LeftOutEstimate {
  double mean = std::numeric_limits<double>::quiet_NaN();       // m_(r), of the others
  double deviation = std::numeric_limits<double>::quiet_NaN();  // in joint standard deviations; NaN: fewer than three
  bool fits = true;                                             // the others
};

struct RandomEffects {
  double mean = std::numeric_limits<double>::quiet_NaN();      // m
  double mean_std = std::numeric_limits<double>::quiet_NaN();  // sqrt(var(m)); with one recording s_1
  double common_error = 0.0;                                   // b
  // Half-widths of 95 % intervals about m, with the common error; NaN: of the mean for one recording, of the next
  // specimen for fewer than three.
  double mean_half_width = std::numeric_limits<double>::quiet_NaN();
  double next_half_width = std::numeric_limits<double>::quiet_NaN();
  // tau by restricted maximum likelihood, its interval, and by Paule and Mandel; NaN for one recording.
  double tau = std::numeric_limits<double>::quiet_NaN();
  double tau_lower95 = std::numeric_limits<double>::quiet_NaN();
  double tau_upper95 = std::numeric_limits<double>::quiet_NaN();
  double tau_paule_mandel = std::numeric_limits<double>::quiet_NaN();
  double typical_std = std::numeric_limits<double>::quiet_NaN();  // s; with one recording s_1
  double q = 0.0;                                                 // Cochran's
  double p_value = 1.0;                                           // of Q where tau is 0
  Eigen::VectorXd weights;                                        // [R] w_r/W
  std::vector<LeftOutEstimate> left_out;                          // [R]

  double scatter() const;  // sqrt(tau^2 + s^2)
  // Q is too large by chance of one in twenty: the recordings differ by more than their s_r say.
  bool varies() const { return p_value < 0.05 && tau > 0.0; }
};

// `estimates` y, `deviations` s > 0 and `common_errors` b >= 0, each [R], R >= 1. Throws `Error` (kUsage) for other
// sizes, s_r that are not positive, and numbers that are not finite. The same bytes for the same numbers.
RandomEffects PoolRepetitions(const Eigen::VectorXd& estimates, const Eigen::VectorXd& deviations,
                              const Eigen::VectorXd& common_errors);

}  // namespace clothid

#endif  // CLOTHID_IDENTIFY_REPETITION_RANDOM_EFFECTS_H_

// How strongly a recording corrects the rollout that is compared with it.
//
// At the end of a step in which frames were recorded, the state is drawn to them,
//   x <- x + alpha u,   v <- v + beta/dt u,
// where u is the innovation e = y - P x, what was measured less what was predicted, over the cloth
// (costs/assimilation/recording_correction.h), and dt the time since the frames before. Gains follow from dt and the
// memory tau, after which a rollout has forgotten its state but for 1/e (Kalata 1984):
//   r = exp(-dt/tau),   alpha = 1 - r^2,   beta = 2 (1 - r)^2.
// So between frames the simulator runs as it is, and what is compared with the recording are predictions from a state
// that the frames before have corrected: the prediction error method. With the true parameters and no noise all e are
// zero whatever the memory, so none moves the minimum of the cost; a short one makes that cost smooth, as it cannot
// depend on what was long ago, and keeps apart what a model misses at one time from all later ones.
#ifndef CLOTHID_COSTS_ASSIMILATION_ASSIMILATION_H_
#define CLOTHID_COSTS_ASSIMILATION_ASSIMILATION_H_

#include <functional>
#include <limits>
#include <optional>

namespace clothid {

struct Assimilation {
  double memory = 0.0;  // tau, s; 0: nothing is corrected
  // l, m: waves that are shorter than about 6 l are corrected less, and so follow noise less. Absent: about an edge of
  // the mesh, the square root of its area per node.
  std::optional<double> smoothing = std::nullopt;
  double until = std::numeric_limits<double>::infinity();  // s: later frames correct nothing

  bool is_on() const { return memory > 0.0; }
};

// Whether both correct alike.
bool IsSame(const Assimilation& a, const Assimilation& b);

// What a point counts for whose innovation is s = |e/sigma|^2 of its noise: rho'(s), and rho''(s).
struct Influence {
  double factor = 1.0, slope = 0.0;
};
using InfluenceOf = std::function<Influence(double squared)>;

struct CorrectionGains {
  double positions = 0.0;   // alpha
  double velocities = 0.0;  // beta/dt, 1/s
};

// `interval`: dt > 0, s. `memory`: tau > 0, s.
CorrectionGains GainsOver(double interval, double memory);

}  // namespace clothid

#endif  // CLOTHID_COSTS_ASSIMILATION_ASSIMILATION_H_

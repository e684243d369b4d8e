// The gradient of a rollout by the adjoint sweep against central differences, where those say anything.
//
// Over the first 60 steps at most. The scalar is C = sum of w_s . x_s over the states x_s after a third, two thirds and
// all of them, with random weights w_s in [-1, 1]. Components are scaled: p dC/dp. The central difference D(e) =
// (C(p (1 + e)) - C(p (1 - e)))/(2 e) is a derivative only where both rollouts have
//   the contact branches and substeps of the one between them: across these C has kinks and jumps;
//   the same solution of every step: a stiff step of cloth that buckles has several. They follow the one between them
//   (RolloutOptions::followed); one that meets another solution all the same is off by more than sqrt(e) of the cloth's
//   size.
// And it must have settled: D(e) and D(e/10) agree to 1e-5 for some e from 1e-7 to 1e-3, or at least, for the best of
// these, to 1e-4. Steps are solved to 1e-12, or to what rounding allows where that is more, and one iteration
// beyond.
#ifndef CLOTHID_TOOLS_BENCHMARK_STEPS_STABILITY_GRADIENT_H_
#define CLOTHID_TOOLS_BENCHMARK_STEPS_STABILITY_GRADIENT_H_

#include <cstdint>
#include <string>
#include <vector>

#include "sim/scene/scene.h"

namespace clothid {

struct ComponentCheck {
  std::string parameter;
  double adjoint = 0.0;     // p dC/dp, m
  double difference = 0.0;  // D(e), m; NaN: none
  double step = 0.0;        // e; NaN: none
  double settled = 0.0;     // |D(e) - D(e/10)|, relative as the error; NaN: none
  double error = 0.0;       // |adjoint - D(e)|, relative to max(|adjoint|, 1e-3 |gradient|); NaN: could not be checked
  std::string reason;       // why it could not be checked; empty: it could
};

struct StabilityGradient {
  std::vector<ComponentCheck> components;
  std::string reason;  // why there is none; empty: there are

  bool is_checkable() const;    // every component
  double error() const;         // the largest of those that could be checked; NaN: none
  std::string Reasons() const;  // "mu: branches differ; ..", one line
};

// Of k_stretch; of mu where mu > 0 and nodes slip; without obstacles of k_bend and drag where the scene has them.
StabilityGradient CheckGradient(Scene scene, std::uint64_t seed);

}  // namespace clothid

#endif  // CLOTHID_TOOLS_BENCHMARK_STEPS_STABILITY_GRADIENT_H_

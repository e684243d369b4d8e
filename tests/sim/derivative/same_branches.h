// Whether two rollouts run through the same contacts: what a difference between them needs to be a derivative.
#ifndef CLOTHID_TESTS_SIM_DERIVATIVE_SAME_BRANCHES_H_
#define CLOTHID_TESTS_SIM_DERIVATIVE_SAME_BRANCHES_H_

#include <cstddef>

#include "sim/rollout/correction.h"
#include "sim/rollout/rollout.h"

namespace clothid {

// Whether contacts leave the same of both corrections, which may be null.
inline bool HaveSameLimits(const CorrectedState* one, const CorrectedState* other) {
  if (one == nullptr || other == nullptr) return one == other;
  if (one->scale != other->scale || one->limits.size() != other->limits.size()) return false;
  for (std::size_t i = 0; i < one->limits.size(); ++i) {
    const CorrectionLimit &a = one->limits[i], &b = other->limits[i];
    if (a.node != b.node || a.obstacle != b.obstacle || a.touches != b.touches || a.is_outside != b.is_outside) {
      return false;
    }
  }
  return true;
}

// Both worked, with as many solves, and at the end of each the same nodes stick and slip on the same obstacles, and the
// same pairs of the cloth with itself.
inline bool HaveSameBranches(const Rollout& one, const Rollout& other) {
  if (!one.ok() || !other.ok() || one.records.size() != other.records.size()) return false;
  for (std::size_t i = 0; i < one.records.size(); ++i) {
    if (!HaveSameLimits(one.records[i].correction.get(), other.records[i].correction.get())) return false;
    if (NumDifferences(one.records[i].contacts, other.records[i].contacts) > 0) return false;
  }
  return true;
}

}  // namespace clothid

#endif  // CLOTHID_TESTS_SIM_DERIVATIVE_SAME_BRANCHES_H_

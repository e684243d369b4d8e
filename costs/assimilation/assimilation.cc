#include "costs/assimilation/assimilation.h"

#include <cmath>

namespace clothid {

bool IsSame(const Assimilation& a, const Assimilation& b) {
  if (!a.is_on() || !b.is_on()) return a.is_on() == b.is_on();
  return a.memory == b.memory && a.smoothing == b.smoothing && a.until == b.until;
}

CorrectionGains GainsOver(double interval, double memory) {
  const double forgotten = -std::expm1(-interval / memory);  // 1 - r
  return {forgotten * (2.0 - forgotten), 2.0 * forgotten * forgotten / interval};
}

}  // namespace clothid

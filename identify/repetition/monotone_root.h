// Where a function of one number changes its sign.
#ifndef CLOTHID_IDENTIFY_REPETITION_MONOTONE_ROOT_H_
#define CLOTHID_IDENTIFY_REPETITION_MONOTONE_ROOT_H_

namespace clothid {

// Halves [low, high], low >= 0, until its ends are neighbours, the sign of `function` being that at `low` on one side
// of the root and not on the other; exact, whatever the size of the root.
template <typename Function>
double MonotoneRoot(const Function& function, double low, double high) {
  const bool is_positive_below = function(low) > 0.0;
  for (;;) {
    const double middle = low + 0.5 * (high - low);
    if (!(middle > low && middle < high)) return low;
    const bool is_below = (function(middle) > 0.0) == is_positive_below;
    (is_below ? low : high) = middle;
  }
}

}  // namespace clothid

#endif  // CLOTHID_IDENTIFY_REPETITION_MONOTONE_ROOT_H_

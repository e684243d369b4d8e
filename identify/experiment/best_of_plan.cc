// What tells a parameter best.
#include <cmath>
#include <limits>
#include <vector>

#include "identify/experiment/experiment_plan.h"

namespace clothid {
namespace {

// Goes through those that tell the parameter, and keeps the one whose interval over `told_share` is the narrowest.
class Best {
 public:
  void Consider(int index, const std::string& name, const std::vector<ExpectedParameter>& parameters) {
    for (const ExpectedParameter& expected : parameters) {
      if (expected.name != name || !expected.is_told) continue;
      const double step = std::isnan(expected.step_error) ? 0.0 : expected.step_error;
      const double width = std::hypot(expected.std, step) / expected.told_share;
      if (width >= least_) continue;
      least_ = width;
      index_ = index;
    }
  }
  int index() const { return index_; }

 private:
  double least_ = std::numeric_limits<double>::infinity();
  int index_ = -1;
};

// The first of the narrowest; NaN: nothing is predicted, or it failed.
template <typename Planned>
int Narrowest(const std::vector<Planned>& all) {
  int narrowest = -1;
  double least = std::numeric_limits<double>::infinity();
  for (std::size_t i = 0; i < all.size(); ++i) {
    if (!(all[i].prediction_width < least)) continue;
    least = all[i].prediction_width;
    narrowest = static_cast<int>(i);
  }
  return narrowest;
}

}  // namespace

int BestCandidate(const Plan& plan, std::size_t parameter) {
  Best best;
  for (std::size_t c = 0; c < plan.candidates.size(); ++c) {
    best.Consider(static_cast<int>(c), plan.parameters[parameter], plan.candidates[c].parameters);
  }
  return best.index();
}

int BestPair(const Plan& plan, std::size_t parameter) {
  Best best;
  for (std::size_t k = 0; k < plan.pairs.size(); ++k) {
    best.Consider(static_cast<int>(k), plan.parameters[parameter], plan.pairs[k].parameters);
  }
  return best.index();
}

int BestCandidateToPredict(const Plan& plan) { return Narrowest(plan.candidates); }

int BestPairToPredict(const Plan& plan) { return Narrowest(plan.pairs); }

}  // namespace clothid

// What tells a parameter best.
#include <limits>
#include <vector>

#include "identify/experiment/experiment_plan.h"

namespace clothid {
namespace {

// Goes through those that tell the parameter, and keeps the one whose interval is the narrowest.
class Best {
 public:
  void Consider(int index, const std::string& name, const std::vector<ExpectedParameter>& parameters) {
    for (const ExpectedParameter& expected : parameters) {
      if (expected.name != name || !expected.is_told || expected.share_of_belief >= least_) continue;
      least_ = expected.share_of_belief;
      index_ = index;
    }
  }
  int index() const { return index_; }

 private:
  double least_ = std::numeric_limits<double>::infinity();
  int index_ = -1;
};

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

}  // namespace clothid

// Bounded coordinates from free ones, for optimisers that know no bounds.
#ifndef CLOTHID_IDENTIFY_FIT_SIGMOID_MAP_H_
#define CLOTHID_IDENTIFY_FIT_SIGMOID_MAP_H_

#include <Eigen/Core>
#include <vector>

#include "costs/prediction/parameter_block.h"

namespace clothid {

// Per free (not frozen) block with internal coordinate q in (lower, upper):
//   q = lower + (upper - lower) sigmoid(4 u/(upper - lower) + c),   u = 0 at the start.
// The factor 4/(upper - lower) makes dq/du = 1 in the middle of the bounds, so that a step of u means what a step of q
// does.
class SigmoidMap {
 public:
  explicit SigmoidMap(const std::vector<ParameterBlock>& blocks);

  int num_free() const { return static_cast<int>(free_.size()); }
  // u [num_free] -> q [p]; frozen blocks stand at their start.
  Eigen::VectorXd ToCoordinates(const double* u) const;
  // dL/dq [p] -> dL/du [num_free].
  void PullBack(const double* u, const Eigen::VectorXd& coordinate_gradient, double* gradient) const;

 private:
  double Sigmoid(int i, double u) const;

  std::vector<int> free_;
  Eigen::VectorXd start_;                  // [p] q
  Eigen::VectorXd lower_, range_, shift_;  // [num_free]
};

}  // namespace clothid

#endif  // CLOTHID_IDENTIFY_FIT_SIGMOID_MAP_H_

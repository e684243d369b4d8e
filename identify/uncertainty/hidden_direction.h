// A direction in which parameters can move between their bounds unseen.
#ifndef CLOTHID_IDENTIFY_UNCERTAINTY_HIDDEN_DIRECTION_H_
#define CLOTHID_IDENTIFY_UNCERTAINTY_HIDDEN_DIRECTION_H_

#include <Eigen/Core>
#include <string>
#include <vector>

#include "costs/prediction/parameter_block.h"

namespace clothid {

struct HiddenDirection {
  Eigen::VectorXd coordinates;  // [p] change of q, the largest entry 1
  double visible_change = 0.0;  // of the whitened prediction over the bounds, in standard deviations
  std::string words;            // "k_stretch, k_bend, density and drag multiplied by one factor"
};

// The words of a direction [p].
std::string DescribeDirection(const std::vector<ParameterBlock>& blocks, const Eigen::VectorXd& direction);

}  // namespace clothid

#endif  // CLOTHID_IDENTIFY_UNCERTAINTY_HIDDEN_DIRECTION_H_

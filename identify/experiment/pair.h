// Two candidates that are recorded and fitted jointly.
#ifndef CLOTHID_IDENTIFY_EXPERIMENT_PAIR_H_
#define CLOTHID_IDENTIFY_EXPERIMENT_PAIR_H_

#include <Eigen/Core>
#include <vector>

#include "identify/experiment/candidate.h"
#include "identify/experiment/cloth_information.h"
#include "identify/experiment/expectation.h"

namespace clothid {

// The cloths that both could simulate, the nominal one first: rows of both, in the columns of the joint fit's blocks.
struct JointCloths {
  std::vector<ClothRows> cloths;
  // [p] of q, of the nominal cloth: the mean of both by what either knows of a parameter, 1/std^2, as of errors that
  // have nothing to do with each other. What is not known counts as 0.
  Eigen::VectorXd step_errors;
};

// `of_first`, `of_second`: cloth by cloth, the nominal one first, which must not have failed.
JointCloths JoinCloths(const PlanOptions& options, const Candidate& first, const Candidate& second,
                       const std::vector<ClothInformation>& of_first, const std::vector<ClothInformation>& of_second);

}  // namespace clothid

#endif  // CLOTHID_IDENTIFY_EXPERIMENT_PAIR_H_

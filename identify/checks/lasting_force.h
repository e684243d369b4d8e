// What is known of a force that the model lacks, as of a random field: how large, how long and how far it is alike.
//
// Of the forces f [3N x T] in frames dt apart (identify/checks/correction_check.h), of which noise makes a part that
// has another sign from frame to frame, products of frames tell what lasts,
//   c_k = mean of f_i f_{i+k} over frames, axes and the area that is free to move,   r = c_2/c_1:
//   size^2 = c_1/r,   time = dt/-log r,   length^2 = c_1/(mean of grad f_i . grad f_{i+1}).
// As c_k ~ r^k, size is that at k = 0. Nothing lasts where c_1 <= 0.
#ifndef CLOTHID_IDENTIFY_CHECKS_LASTING_FORCE_H_
#define CLOTHID_IDENTIFY_CHECKS_LASTING_FORCE_H_

#include <Eigen/Core>

namespace clothid {

class ClothModel;

struct LastingForce {
  double size = 0.0;    // N/m^2, the standard deviation of one axis; 0: nothing lasts
  double time = 0.0;    // s, after which it has forgotten itself but for 1/e: from dt to all of the frames
  double length = 0.0;  // m: from an edge of the mesh, the root of its area per node, to the size of the cloth
};

// `times` [T] s. Frames before the first correction, which must be the first alone, count nothing.
LastingForce DescribeLastingForce(const Eigen::MatrixXd& forces, const Eigen::VectorXd& times, const ClothModel& cloth);

}  // namespace clothid

#endif  // CLOTHID_IDENTIFY_CHECKS_LASTING_FORCE_H_

// The smoothest ways in which a cloth can be displaced.
#ifndef CLOTHID_COSTS_START_SMOOTH_MODES_H_
#define CLOTHID_COSTS_START_SMOOTH_MODES_H_

#include <Eigen/Core>
#include <vector>

#include "sim/cloth/cloth_model.h"

namespace clothid {

// The lowest `count` modes phi of  L phi = lambda M phi  on the nodes that are not `fixed`, L the cotangent Laplacian
// and M the lumped areas of `model`, whose own handles do not matter: [N x K], zero at fixed nodes, in the order of
// lambda; K = `count`, or as many nodes as move. Over the whole cloth the root mean square of a mode is 1. The same
// arguments give the same modes.
Eigen::MatrixXd SmoothModes(const ClothModel& model, const std::vector<int>& fixed, int count);

// Every mode [N x K] along every axis, those of one mode side by side: [3N x 3K].
Eigen::MatrixXd AlongAxes(const Eigen::MatrixXd& modes);

}  // namespace clothid

#endif  // CLOTHID_COSTS_START_SMOOTH_MODES_H_

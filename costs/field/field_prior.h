// What is believed of fields before: that they are smooth.
//
// With theta the logarithms at the control nodes, B theta is the Laplacian of every field over the square that its
// control grid spans, of side 1, times the root of the area of a control node, with no slope across the border:
// |B theta|^2 is the integral of the squared Laplacian. So its weight means the same on any control grid, and nothing
// is said of the mean. It is no part of the cost of a recording: all recordings have the fields in common.
//
// The eigenvectors of B are products of cosines, the smoothest first: the modes.
#ifndef CLOTHID_COSTS_FIELD_FIELD_PRIOR_H_
#define CLOTHID_COSTS_FIELD_FIELD_PRIOR_H_

#include <Eigen/Core>
#include <Eigen/SparseCore>
#include <vector>

#include "costs/field/field_request.h"

namespace clothid {

// B of one field [size x size], and of several, one after the other.
Eigen::SparseMatrix<double> SmoothnessRoot(int rows, int columns);
Eigen::SparseMatrix<double> SmoothnessRoot(const std::vector<FieldRequest>& requests);

// The modes of a field with less than `most_per_side` half waves along either side of the control grid, row by row:
// orthonormal columns [size x modes]; all modes where no side has more control nodes.
Eigen::MatrixXd FieldModes(int rows, int columns, int most_per_side);
// The variances at the control nodes that the prior of weight 1 leaves to all other modes [size].
Eigen::VectorXd RoughVariances(int rows, int columns, int most_per_side);

}  // namespace clothid

#endif  // CLOTHID_COSTS_FIELD_FIELD_PRIOR_H_

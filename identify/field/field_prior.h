// What is believed of fields before: that they are smooth.
//
// With theta the logarithms at the control nodes, B theta is the Laplacian of every field over the square that its
// control grid spans, of side 1, times the root of the area of a control node, with no slope across the border:
// |B theta|^2 is the integral of the squared Laplacian. So its weight means the same on any control grid, and nothing
// is said of the mean.
#ifndef CLOTHID_IDENTIFY_FIELD_FIELD_PRIOR_H_
#define CLOTHID_IDENTIFY_FIELD_FIELD_PRIOR_H_

#include <Eigen/SparseCore>
#include <vector>

#include "identify/field/field_request.h"

namespace clothid {

// B of one field [size x size], and of several, one after the other.
Eigen::SparseMatrix<double> SmoothnessRoot(int rows, int columns);
Eigen::SparseMatrix<double> SmoothnessRoot(const std::vector<FieldRequest>& requests);

}  // namespace clothid

#endif  // CLOTHID_IDENTIFY_FIELD_FIELD_PRIOR_H_

// Constants of the material that vary over the cloth (sim/scene/material_field.h) as unknowns of a fit.
//
// The unknowns theta [f] are the logarithms of the fields at their control nodes, over those of the scene's fields of
// the same kinds, one field after the other, each row by row. The level of a field, its geometric mean over the area,
// is a parameter of its own, so theta counts without its mean: with W the bilinear weights (`ControlWeights`) and a the
// areas of the triangles over their sum, the logarithms of a field's factors change by
//   W theta - 1 (a^T W theta),
// nothing where theta is the same everywhere. Other fields of the scene stay as they are. In the coordinates of a
// recording theta stands behind the parameters and the unknowns of its start (costs/prediction/recording_model.h).
#ifndef CLOTHID_COSTS_FIELD_FIELD_UNKNOWNS_H_
#define CLOTHID_COSTS_FIELD_FIELD_UNKNOWNS_H_

#include <Eigen/Core>
#include <Eigen/SparseCore>
#include <memory>
#include <string>
#include <vector>

#include "costs/field/field_request.h"
#include "sim/scene/material_field.h"
#include "sim/scene/scene.h"

namespace clothid {

class FieldUnknowns {
 public:
  // `scene`: has a field of every request's kind (`SetField`), else `std::logic_error` is thrown. Keeps no reference to
  // it. Throws as `ControlWeights` does, prefixed by `source`.
  FieldUnknowns(const std::vector<FieldRequest>& requests, const Scene& scene, const std::string& source);

  int size() const { return size_; }  // f

  // All K fields of the scene at theta [f].
  std::shared_ptr<const std::vector<FieldFactors>> FactorsAt(const Eigen::VectorXd& theta) const;
  // The change of their logarithms per triangle, those of the first field first: of theta [f x c], [K F x c].
  Eigen::MatrixXd OverTriangles(const Eigen::MatrixXd& theta) const;
  // Of theta [f x c], what its fields have at the control nodes over their levels: without the means over the area.
  Eigen::MatrixXd WithoutMeans(const Eigen::MatrixXd& theta) const;
  // The transpose of `OverTriangles`: of [K F x s], [f x s].
  Eigen::MatrixXd PullBack(const Eigen::MatrixXd& by_triangle) const;

 private:
  // Of one request.
  struct Part {
    Eigen::SparseMatrix<double> weights;  // W [F x size]
    Eigen::Index first_unknown, first_row;
  };

  std::shared_ptr<const std::vector<FieldFactors>> base_;  // those of the scene
  Eigen::VectorXd areas_;                                  // a [F]
  std::vector<Part> parts_;
  int size_ = 0;
};

}  // namespace clothid

#endif  // CLOTHID_COSTS_FIELD_FIELD_UNKNOWNS_H_

// A constant of the material that varies over the cloth: a field.
//
// Its logarithm is bilinear on a control grid over the cloth at rest, and every triangle has that of its centre:
//   log k_f = sum_c W_fc log k_c,   sum_c W_fc = 1
// The grid spans the box around the nodes, seen along the mean normal of the rest shape. Its columns run along that
// axis x, y or z which lies nearest to the plane of view, its rows across, the way in which the larger component of
// that direction grows. So a flat cloth is seen as it is, and one that is curved at rest as it looks from the front.
//
// The level of a field is the geometric mean over the area of the cloth. It is the value that the material has; the
// field itself are the factors to it.
#ifndef CLOTHID_SIM_SCENE_MATERIAL_FIELD_H_
#define CLOTHID_SIM_SCENE_MATERIAL_FIELD_H_

#include <Eigen/Core>
#include <Eigen/SparseCore>
#include <string>
#include <vector>

#include "sim/mesh/mesh.h"
#include "sim/scene/parameters.h"

namespace clothid {

inline constexpr int kMaxFieldSide = 256;  // rows or columns of a control grid

// Of a scene.
struct GridField {
  ParameterKind kind = ParameterKind::kStretchStiffness;
  Eigen::MatrixXd values;  // [rows x columns] at the control nodes, > 0, in the parameter's unit
};

// Of `Parameters`.
struct FieldFactors {
  ParameterKind kind = ParameterKind::kStretchStiffness;
  Eigen::VectorXd log_factors;  // [F] of every triangle, to the value of the material
};

// Which constants can be fields: stiffnesses of the membrane, rigidities of bending, density.
bool CanBeField(ParameterKind kind);
// That of a name. Throws `Error` (kUsage), prefixed by `source` and with the names of those that can, where it is none.
ParameterKind ParseFieldKind(const std::string& name, const std::string& source);

// The columns' and the rows' direction of that view [3 x 2], unit vectors; with a rest place per corner those of u and
// v. Throws as `FieldCoordinates` does.
Eigen::Matrix<double, 3, 2> FrontAxes(const Mesh& mesh, const std::string& source);

// The nodes at rest as that view shows them [2 x N] m, from a corner of the box around them. Throws as
// `FieldCoordinates` does.
Eigen::Matrix2Xd FrontView(const Mesh& mesh, const std::string& source);

// Where the centres of the triangles are in the box around the cloth [2 x F]: along the columns and along the rows, 0
// to 1. Throws `Error` (kBadData), prefixed by `source`, where the rest shape has no front: its normals cancel,
// or there is a place per corner of a triangle.
Eigen::Matrix2Xd FieldCoordinates(const Mesh& mesh, const std::string& source);

// W [F x rows columns], the control nodes row by row. Throws as `FieldCoordinates` does.
Eigen::SparseMatrix<double> ControlWeights(const Mesh& mesh, int rows, int columns, const std::string& source);

// What is bilinear between `values` [rows x columns] of the control nodes, at a place in the box, 0 to 1 along either.
double BetweenControlNodes(const Eigen::MatrixXd& values, const Eigen::Vector2d& place);

// The values at the control nodes, row by row, as logarithms [rows columns].
Eigen::VectorXd LogsOf(const Eigen::MatrixXd& values);

// The field over the triangles, and its level. Throws as `FieldCoordinates` does.
FieldFactors FieldOverTriangles(const GridField& grid, const Mesh& mesh, double* level);

// Throws `Error` (kBadData), prefixed by `source`, unless every field is of a constant that can be one, no two of the
// same, with 1 to kMaxFieldSide rows and columns of finite numbers > 0.
void ValidateFields(const std::vector<GridField>& fields, const Mesh& mesh, const std::string& source);

// The control grid in a .npy file, an array of two dimensions. Throws `Error`: kIo where it cannot be read, kBadData
// naming file and fault.
Eigen::MatrixXd ReadFieldValues(const std::string& path);
std::string FieldValuesNpy(const Eigen::MatrixXd& values);  // its bytes

}  // namespace clothid

#endif  // CLOTHID_SIM_SCENE_MATERIAL_FIELD_H_

#include "sim/scene/material_field.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>

#include "sim/base/error.h"
#include "sim/base/npy_file.h"
#include "sim/base/text_file.h"
#include "sim/scene/parameter_table.h"

namespace clothid {
namespace {

// Below this share of its area the mean normal of a rest shape is what rounding leaves of normals that cancel.
constexpr double kSmallestFront = 1e-6;

// The two of `count` control nodes on a line that are next to a place in [0, 1], and the weight of the second.
struct Neighbours {
  int first, second;
  double weight;
};

Neighbours NeighboursAt(double place, int count) {
  if (count == 1) return {0, 0, 0.0};
  const double along = place * (count - 1);
  const int first = std::clamp(static_cast<int>(along), 0, count - 2);
  return {first, first + 1, along - first};
}

}  // namespace

bool CanBeField(ParameterKind kind) {
  const ParameterRow& row = RowOf(kind);
  const bool is_stiffness = row.term == ParameterTerm::kMembrane && row.domain == ParameterDomain::kPositive;
  return is_stiffness || row.term == ParameterTerm::kBending || kind == ParameterKind::kDensity;
}

ParameterKind ParseFieldKind(const std::string& name, const std::string& source) {
  std::string names;
  for (const ParameterRow& row : ParameterTable()) {
    if (!CanBeField(row.kind)) continue;
    if (name == row.name) return row.kind;
    names += (names.empty() ? "" : ", ") + std::string(row.name);
  }
  throw Error(ErrorKind::kUsage, source + ": '" + Printable(name) + "' can be no field; expected one of " + names);
}

Eigen::Matrix<double, 3, 2> FrontAxes(const Mesh& mesh, const std::string& source) {
  if (mesh.has_corner_rest()) return Eigen::Matrix<double, 3, 2>::Identity();
  Eigen::Vector3d sum = Eigen::Vector3d::Zero();  // of twice the areas, as vectors
  double size = 0.0;
  for (int f = 0; f < mesh.num_faces(); ++f) {
    const Eigen::Vector3d a = mesh.rest_positions.col(mesh.faces(0, f));
    const Eigen::Vector3d e1 = mesh.rest_positions.col(mesh.faces(1, f)) - a;
    const Eigen::Vector3d normal = e1.cross(mesh.rest_positions.col(mesh.faces(2, f)) - a);
    sum += normal;
    size += normal.norm();
  }
  if (!(sum.norm() > kSmallestFront * size)) {
    throw Error(ErrorKind::kBadData, source + ": expected a cloth with a front at rest; its normals cancel");
  }
  const Eigen::Vector3d normal = sum.normalized();
  // The first of those that are as near, but for rounding.
  Eigen::Index nearest = 0;
  for (Eigen::Index axis = 1; axis < 3; ++axis) {
    if (std::abs(normal[axis]) < std::abs(normal[nearest]) - 1e-9) nearest = axis;
  }
  Eigen::Matrix<double, 3, 2> axes;
  axes.col(0) = (Eigen::Vector3d::Unit(nearest) - normal[nearest] * normal).normalized();
  axes.col(1) = normal.cross(axes.col(0));
  Eigen::Index largest;
  axes.col(1).cwiseAbs().maxCoeff(&largest);
  if (axes(largest, 1) < 0.0) axes.col(1) = -axes.col(1);
  return axes;
}

Eigen::Matrix2Xd FrontView(const Mesh& mesh, const std::string& source) {
  if (mesh.has_corner_rest()) {
    throw Error(ErrorKind::kBadData, source +
                                         ": expected a cloth without \"rest\": \"uv\"; its nodes have no one "
                                         "place at rest, over which a field could spread");
  }
  const Eigen::Matrix2Xd nodes = FrontAxes(mesh, source).transpose() * mesh.rest_positions;
  return nodes.colwise() - nodes.rowwise().minCoeff();
}

Eigen::Matrix2Xd FieldCoordinates(const Mesh& mesh, const std::string& source) {
  const Eigen::Matrix2Xd nodes = FrontView(mesh, source);
  const Eigen::Vector2d size = nodes.rowwise().maxCoeff();
  Eigen::Matrix2Xd centres(2, mesh.num_faces());
  for (int f = 0; f < mesh.num_faces(); ++f) {
    const Eigen::Vector2d sum = nodes.col(mesh.faces(0, f)) + nodes.col(mesh.faces(1, f)) + nodes.col(mesh.faces(2, f));
    centres.col(f) = (sum.array() / (3.0 * size).array()).cwiseMax(0.0).cwiseMin(1.0);
  }
  return centres;
}

Eigen::SparseMatrix<double> ControlWeights(const Mesh& mesh, int rows, int columns, const std::string& source) {
  const Eigen::Matrix2Xd places = FieldCoordinates(mesh, source);
  std::vector<Eigen::Triplet<double>> triplets;
  for (int f = 0; f < mesh.num_faces(); ++f) {
    const Neighbours along = NeighboursAt(places(0, f), columns), across = NeighboursAt(places(1, f), rows);
    triplets.emplace_back(f, across.first * columns + along.first, (1.0 - across.weight) * (1.0 - along.weight));
    triplets.emplace_back(f, across.first * columns + along.second, (1.0 - across.weight) * along.weight);
    triplets.emplace_back(f, across.second * columns + along.first, across.weight * (1.0 - along.weight));
    triplets.emplace_back(f, across.second * columns + along.second, across.weight * along.weight);
  }
  Eigen::SparseMatrix<double> weights(mesh.num_faces(), rows * columns);
  weights.setFromTriplets(triplets.begin(), triplets.end());
  return weights;
}

double BetweenControlNodes(const Eigen::MatrixXd& values, const Eigen::Vector2d& place) {
  const Neighbours along = NeighboursAt(place.x(), static_cast<int>(values.cols()));
  const Neighbours across = NeighboursAt(place.y(), static_cast<int>(values.rows()));
  const auto on_row = [&](int row) {
    return (1.0 - along.weight) * values(row, along.first) + along.weight * values(row, along.second);
  };
  return (1.0 - across.weight) * on_row(across.first) + across.weight * on_row(across.second);
}

Eigen::VectorXd LogsOf(const Eigen::MatrixXd& values) { return values.array().log().matrix().transpose().reshaped(); }

FieldFactors FieldOverTriangles(const GridField& grid, const Mesh& mesh, double* level) {
  const double first = grid.values(0, 0);
  if ((grid.values.array() == first).all()) {  // flat, to the last digit
    *level = first;
    return {grid.kind, Eigen::VectorXd::Zero(mesh.num_faces())};
  }
  const int rows = static_cast<int>(grid.values.rows()), columns = static_cast<int>(grid.values.cols());
  const Eigen::VectorXd logs = ControlWeights(mesh, rows, columns, "fields") * LogsOf(grid.values);
  const Eigen::VectorXd areas = TriangleAreas(mesh);
  const double mean = areas.dot(logs) / areas.sum();
  *level = std::exp(mean);
  return {grid.kind, logs.array() - mean};
}

void ValidateFields(const std::vector<GridField>& fields, const Mesh& mesh, const std::string& source) {
  for (std::size_t i = 0; i < fields.size(); ++i) {
    const GridField& field = fields[i];
    const std::string key = source + ": key 'fields." + ParameterName({field.kind}, {}) + "': expected ";
    const auto expect = [&key](bool condition, const std::string& expected) {
      if (!condition) throw Error(ErrorKind::kBadData, key + expected);
    };
    expect(CanBeField(field.kind), "a stiffness, a rigidity or density");
    for (std::size_t j = 0; j < i; ++j) expect(fields[j].kind != field.kind, "it once");
    const Eigen::Index rows = field.values.rows(), columns = field.values.cols();
    expect(rows >= 1 && columns >= 1 && rows <= kMaxFieldSide && columns <= kMaxFieldSide,
           "1 to " + std::to_string(kMaxFieldSide) + " rows and columns");
    expect(field.values.allFinite() && field.values.minCoeff() > 0.0, "finite numbers > 0");
  }
  FieldCoordinates(mesh, source);
}

Eigen::MatrixXd ReadFieldValues(const std::string& path) {
  const NpyArray array = ReadNpy(path);
  const auto fail = [&path](const std::string& expected) {
    throw Error(ErrorKind::kBadData, path + ": expected " + expected);
  };
  const auto fits = [](long long side) { return side >= 1 && side <= kMaxFieldSide; };
  if (array.shape.size() != 2 || !fits(array.shape[0]) || !fits(array.shape[1])) {
    fail("an array of 1 to " + std::to_string(kMaxFieldSide) + " rows and as many columns");
  }
  using RowMajor = Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor>;
  const Eigen::MatrixXd values = Eigen::Map<const RowMajor>(array.values.data(), array.shape[0], array.shape[1]);
  if (!values.allFinite() || !(values.minCoeff() > 0.0)) fail("finite numbers > 0");
  return values;
}

std::string FieldValuesNpy(const Eigen::MatrixXd& values) {
  const Eigen::VectorXd row_by_row = values.transpose().reshaped();
  return NpyBytes(NpyArray{{values.rows(), values.cols()}, {row_by_row.begin(), row_by_row.end()}});
}

}  // namespace clothid

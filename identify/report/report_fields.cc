#include "identify/report/report_fields.h"

#include <Eigen/Core>
#include <Eigen/LU>
#include <algorithm>
#include <cmath>
#include <map>
#include <utility>

#include "identify/page/page_template.h"
#include "sim/scene/material_field.h"

namespace clothid {
namespace {

using Json = nlohmann::ordered_json;

constexpr int kCells = 64;  // along the longer side
constexpr int kFieldDigits = 4;
constexpr double kOnEdge = 1e-9;  // of a triangle's size: a cell's centre on an edge is inside

// The cloth as it is seen from the front.
struct Raster {
  Eigen::Matrix2Xd nodes;  // m
  Eigen::Vector2d size;    // m
  double cell = 0.0;       // m
  int rows = 0, columns = 0;
  Eigen::Matrix<bool, Eigen::Dynamic, Eigen::Dynamic> is_on_cloth;  // [rows x columns]

  Eigen::Vector2d Centre(int row, int column) const { return cell * Eigen::Vector2d(column + 0.5, row + 0.5); }
};

// The cells whose centres are in a triangle.
void MarkTriangle(const Eigen::Matrix<double, 2, 3>& corners, Raster* raster) {
  Eigen::Matrix2d edges;
  edges << corners.col(1) - corners.col(0), corners.col(2) - corners.col(0);
  if (!(std::abs(edges.determinant()) > 0.0)) return;  // seen from its side
  const Eigen::Matrix2d inverse = edges.inverse();
  const Eigen::Vector2d low = corners.rowwise().minCoeff() / raster->cell;
  const Eigen::Vector2d high = corners.rowwise().maxCoeff() / raster->cell;
  const int last_row = std::min(raster->rows - 1, static_cast<int>(high.y()));
  const int last_column = std::min(raster->columns - 1, static_cast<int>(high.x()));
  for (int row = std::max(0, static_cast<int>(low.y()) - 1); row <= last_row; ++row) {
    for (int column = std::max(0, static_cast<int>(low.x()) - 1); column <= last_column; ++column) {
      const Eigen::Vector2d weights = inverse * (raster->Centre(row, column) - corners.col(0));
      if (weights.minCoeff() >= -kOnEdge && weights.sum() <= 1.0 + kOnEdge) raster->is_on_cloth(row, column) = true;
    }
  }
}

Raster MakeRaster(const Mesh& mesh) {
  Raster raster;
  raster.nodes = FrontView(mesh, "fields");
  raster.size = raster.nodes.rowwise().maxCoeff();
  raster.cell = raster.size.maxCoeff() / kCells;
  raster.rows = std::max(1, static_cast<int>(std::ceil(raster.size.y() / raster.cell - kOnEdge)));
  raster.columns = std::max(1, static_cast<int>(std::ceil(raster.size.x() / raster.cell - kOnEdge)));
  raster.is_on_cloth.setConstant(raster.rows, raster.columns, false);
  for (int f = 0; f < mesh.num_faces(); ++f) {
    Eigen::Matrix<double, 2, 3> corners;
    for (int k = 0; k < 3; ++k) corners.col(k) = raster.nodes.col(mesh.faces(k, f));
    MarkTriangle(corners, &raster);
  }
  return raster;
}

// Edges of one triangle alone; null between them.
Json OutlineJson(const Mesh& mesh, const Raster& raster) {
  std::map<std::pair<int, int>, int> counts;
  for (int f = 0; f < mesh.num_faces(); ++f) {
    for (int k = 0; k < 3; ++k) ++counts[std::minmax(int{mesh.faces(k, f)}, int{mesh.faces((k + 1) % 3, f)})];
  }
  Json x = Json::array(), y = Json::array();
  for (const auto& [edge, count] : counts) {
    if (count != 1) continue;
    for (const int node : {edge.first, edge.second}) {
      x.push_back(RoundedJson(raster.nodes(0, node), kFieldDigits));
      y.push_back(RoundedJson(raster.nodes(1, node), kFieldDigits));
    }
    x.push_back(nullptr);
    y.push_back(nullptr);
  }
  return {{"x", x}, {"y", y}};
}

// Rows of `value(place)`.
template <typename Value>
Json CellsJson(const Raster& raster, const Value& value) {
  Json rows = Json::array();
  for (int r = 0; r < raster.rows; ++r) {
    Json row = Json::array();
    for (int c = 0; c < raster.columns; ++c) {
      const Eigen::Vector2d place = raster.Centre(r, c).cwiseQuotient(raster.size).cwiseMin(1.0);
      row.push_back(raster.is_on_cloth(r, c) ? Json(value(place)) : Json(nullptr));
    }
    rows.push_back(row);
  }
  return rows;
}

Json CentresJson(const Raster& raster, int count) {
  Json centres = Json::array();
  for (int i = 0; i < count; ++i) centres.push_back(RoundedJson(raster.cell * (i + 0.5), 6));
  return centres;
}

Json FieldMapJson(const FittedField& field, const Raster& raster) {
  const Eigen::MatrixXd logs = field.values.array().log();
  Json json = {{"name", field.request.name},
               {"x", CentresJson(raster, raster.columns)},
               {"y", CentresJson(raster, raster.rows)},
               {"value", CellsJson(raster, [&](const Eigen::Vector2d& place) {
                  return RoundedJson(std::exp(BetweenControlNodes(logs, place)), kFieldDigits);
                })}};
  if (field.log_std.size() == 0) return json;
  json["std"] = CellsJson(
      raster, [&](const Eigen::Vector2d& place) { return RoundedJson(BetweenControlNodes(field.log_std, place), 3); });
  json["determined"] = CellsJson(raster, [&](const Eigen::Vector2d& place) {
    return IsDetermined(BetweenControlNodes(field.log_std, place), BetweenControlNodes(field.deviation_std, place),
                        BetweenControlNodes(field.prior_deviation_std, place))
               ? 1
               : 0;
  });
  return json;
}

}  // namespace

Json FieldMapsJson(const FieldResult& result, const Mesh& mesh) {
  Json maps = Json::array();
  if (result.fields.empty()) return maps;
  const Raster raster = MakeRaster(mesh);
  const Json outline = OutlineJson(mesh, raster);
  for (const FittedField& field : result.fields) {
    Json map = FieldMapJson(field, raster);
    map["outline"] = outline;
    map["line"] = DescribeField(field);
    maps.push_back(std::move(map));
  }
  return maps;
}

}  // namespace clothid

// Fields in report.html: their picture on the cloth.
#include "identify/report/report_fields.h"

#include <gtest/gtest.h>

#include <cmath>

#include "identify/report/report_page.h"
#include "sim/scene/material_field.h"
#include "tests/costs/synthetic_motion.h"
#include "tests/identify/report/packed_page.h"

namespace clothid::report_fields_test {
namespace {

using Json = nlohmann::ordered_json;

// Upright, 0.4 m wide and 0.2 m high, of which the triangle above the diagonal is left: x + z' <= 1 of its size.
Mesh HalfCloth() {
  GridOptions grid;
  grid.nodes = {9, 5};
  grid.size = {0.4, 0.2};
  grid.axes = {Eigen::Vector3d::UnitX(), Eigen::Vector3d::UnitZ()};
  Mesh mesh = MakeGrid(grid);
  std::vector<int> kept;
  for (int f = 0; f < mesh.num_faces(); ++f) {
    double sum = 0.0;
    for (int k = 0; k < 3; ++k) {
      const Eigen::Vector3d node = mesh.rest_positions.col(mesh.faces(k, f));
      sum += (node.x() / 0.4 + node.z() / 0.2) / 3.0;
    }
    if (sum < 0.75) kept.push_back(f);
  }
  Eigen::Matrix3Xi faces(3, static_cast<Eigen::Index>(kept.size()));
  for (std::size_t i = 0; i < kept.size(); ++i) faces.col(static_cast<Eigen::Index>(i)) = mesh.faces.col(kept[i]);
  mesh.faces = faces;
  return mesh;
}

FieldResult MakeResult() {
  FieldResult result;
  FittedField& field = result.fields.emplace_back();
  field.request = {"k_bend", ParameterKind::kBendingStiffness, 2, 2};
  field.values.resize(2, 2);
  field.values << 1e-3, 2e-3, 4e-3, 8e-3;
  field.log_std.resize(2, 2);
  field.log_std << 0.06, 0.22, 0.06, 0.22;  // 0.1 a quarter along the rows
  field.deviation_std = field.log_std;
  field.prior_deviation_std = Eigen::MatrixXd::Constant(2, 2, 1.0);
  return result;
}

TEST(ReportFieldsTest, CellsHoldWhatLiesBetweenControlNodes) {
  const Json maps = FieldMapsJson(MakeResult(), HalfCloth());
  ASSERT_EQ(maps.size(), 1u);
  const Json& map = maps[0];
  EXPECT_EQ(map["name"], "k_bend");
  ASSERT_EQ(map["x"].size(), 64u);
  ASSERT_EQ(map["y"].size(), 32u);
  EXPECT_NEAR(map["x"][63], 0.4 - 0.4 / 128, 1e-6);
  for (int r = 0; r < 32; ++r) {
    for (int c = 0; c < 64; ++c) {
      const double x = map["x"][c].get<double>() / 0.4, y = map["y"][r].get<double>() / 0.2;
      const Json& value = map["value"][r][c];
      // Off the cloth, but for the steps of its border.
      if (x + y > 1.0) {
        EXPECT_TRUE(value.is_null()) << x << " " << y;
      }
      if (x + y > 0.5) continue;
      ASSERT_FALSE(value.is_null()) << x << " " << y;
      EXPECT_NEAR(value.get<double>(), 1e-3 * std::exp2(x + 2.0 * y), 1e-3 * value.get<double>());
      EXPECT_EQ(map["determined"][r][c], x < 0.25 ? 1 : 0) << x << " " << y;
      EXPECT_NEAR(map["std"][r][c], 0.06 + 0.16 * x, 1e-3);
    }
  }
  EXPECT_EQ(map["outline"]["x"].size(), map["outline"]["y"].size());
  EXPECT_GE(map["outline"]["x"].size(), 3u * 12u);
}

TEST(ReportFieldsTest, WithoutDeviationsNothingIsSaidOfThem) {
  FieldResult result = MakeResult();
  result.fields.front().log_std.resize(0, 0);
  const Json maps = FieldMapsJson(result, HalfCloth());
  EXPECT_FALSE(maps[0].contains("std"));
  EXPECT_FALSE(maps[0].contains("determined"));
}

TEST(ReportFieldsTest, PageWithoutOneHasNothingOfIt) {
  MotionOptions made;
  made.noise = 1e-3;
  const RecordedMotion motion = MakeMotion(SphereScene(), made);
  FitOptions options;
  options.parameters = {"k_stretch"};
  FitProblem problem({motion}, options);
  FitSummary summary = Fit(options, &problem);
  const FitChecks checks;
  const std::string without = ReportHtml(summary, checks, {motion});
  EXPECT_EQ(without.find("showField"), std::string::npos);
  EXPECT_FALSE(PageData(without).contains("fields"));
  summary.fields = MakeResult();
  const std::string with = ReportHtml(summary, checks, {motion});
  EXPECT_NE(with.find("showField"), std::string::npos);
  EXPECT_EQ(PageData(with)["fields"].size(), 1u);
  EXPECT_LE(with.size(), kMaxReportBytes);
}

}  // namespace
}  // namespace clothid::report_fields_test

#include "datasets/curves/curve_table.h"

#include <vector>

#include "datasets/curves/lab_table.h"

namespace clothid {

namespace {

constexpr char kExample[] = "Extension [mm];Force [N]";

const LabColumn kWidth = {{"width", "breite", "transverse strain", "lateral strain", "querdehnung"},
                          {LabQuantity::kLength, LabQuantity::kStrain},
                          "mm, cm, m, % or 1"};
const LabColumn kElongation = {
    {"extension", "elongation", "displacement", "stroke", "travel", "position", "weg", "strain", "dehnung"},
    {LabQuantity::kLength, LabQuantity::kStrain},
    "mm, cm, m, % or 1"};
const LabColumn kForce = {{"force", "load", "kraft"},
                          {LabQuantity::kForce, LabQuantity::kForcePerWidth},
                          "N, mN, kN, cN, gf, kgf, N/m, N/cm or N/mm"};

}  // namespace

CurveTable ReadCurveTable(const std::string& path) {
  static const std::vector<LabForm> forms = {
      {{kWidth, kElongation, kForce}, "", kExample},
      {{kElongation, kForce}, "columns of force and of extension, displacement or strain", kExample}};
  const LabTable table = ReadLabTable(path, forms);
  const Eigen::Index first = table.form == 0 ? 1 : 0;  // of the elongation
  const auto quantity = [&](Eigen::Index column) { return table.quantities[static_cast<std::size_t>(column)]; };
  const auto title = [&](Eigen::Index column) { return table.columns[static_cast<std::size_t>(column)]; };
  CurveTable curve;
  curve.name = table.name;
  curve.elongations = table.values.col(first);
  curve.forces = table.values.col(first + 1);
  curve.is_strain = quantity(first) == LabQuantity::kStrain;
  curve.is_per_width = quantity(first + 1) == LabQuantity::kForcePerWidth;
  curve.width = table.width;
  curve.gauge_length = table.gauge_length;
  curve.columns = title(first) + " and " + title(first + 1);
  if (first == 0 || (table.values.col(0).array() == table.values(0, 0)).all()) return curve;
  curve.widths = table.values.col(0);
  curve.is_width_strain = quantity(0) == LabQuantity::kStrain;
  curve.columns = title(0) + ", " + curve.columns;
  return curve;
}

}  // namespace clothid

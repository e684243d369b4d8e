#include "datasets/curves/curve_table.h"

#include "datasets/curves/lab_table.h"

namespace clothid {

CurveTable ReadCurveTable(const std::string& path) {
  static const LabForm form = {
      {{{"extension", "elongation", "displacement", "stroke", "travel", "position", "weg", "strain", "dehnung"},
        {LabQuantity::kLength, LabQuantity::kStrain},
        "mm, cm, m, % or 1"},
       {{"force", "load", "kraft"},
        {LabQuantity::kForce, LabQuantity::kForcePerWidth},
        "N, mN, kN, cN, gf, kgf, N/m, N/cm or N/mm"}},
      "columns of force and of extension, displacement or strain",
      "Extension [mm];Force [N]"};
  const LabTable table = ReadLabTable(path, {form});
  return {table.name,
          table.values.col(0),
          table.values.col(1),
          table.quantities[0] == LabQuantity::kStrain,
          table.quantities[1] == LabQuantity::kForcePerWidth,
          table.width,
          table.gauge_length,
          table.columns[0] + " and " + table.columns[1]};
}

}  // namespace clothid

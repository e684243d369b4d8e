// Curves of force over elongation, as testing machines export them.
//
// Lines of text about the test, a header that names the columns, a row of units, then one row per reading:
//
//   "Width";"95,92";"mm"
//   "Gauge length";"45,25";"mm"
//   "Time";"Extension";"Force"
//   "s";"mm";"N"
//   0,0000;0,0012;0,0000
//
// Cells (sim/base/csv_row.h) stand between semicolons, where the header has one, commas or tabs; but between commas a
// number may have a decimal comma: all of them, or none. A unit stands in brackets behind the name of the column,
// "Force [N]", or in a row below. The header is the first line with both columns:
//   force         named force, load or kraft; N, mN, kN, cN, gf, kgf, or per width N/m, N/cm, N/mm
//   elongation    named extension, elongation, displacement, stroke, travel, position or weg, else strain or dehnung;
//                 m, cm, mm, or of the gauge length %, 1, mm/mm, m/m
// Letter case does not matter, and a name may have words before it, "Tensile strain". Of several the first in this list
// is taken, the plain name before one with words. Of the lines above the header, Width and Gauge length are read, with
// a number and a unit.
#ifndef CLOTHID_DATASETS_CURVES_CURVE_TABLE_H_
#define CLOTHID_DATASETS_CURVES_CURVE_TABLE_H_

#include <Eigen/Core>
#include <cstdint>
#include <optional>
#include <string>

namespace clothid {

inline constexpr std::uint64_t kMaxCurveBytes = std::uint64_t{1} << 28;

struct CurveTable {
  std::string name;                           // for messages: the file
  Eigen::VectorXd elongations;                // [R] m, or of the gauge length (1), in the order of the file
  Eigen::VectorXd forces;                     // [R] N, or N per m of width
  bool is_strain = false;                     // elongations are strains
  bool is_per_width = false;                  // forces are per width
  std::optional<double> width, gauge_length;  // m, of the specimen, where the file tells them
  std::string columns;                        // what was read, "'Extension' in mm and 'Force' in N"
};

// Throws `Error`: kIo where the file cannot be read; kBadData, naming file and line and what was expected, for a file
// of more than kMaxCurveBytes, a header that is missing or names a column twice, a unit that is missing or unknown, a
// row of another number of cells than the header or with a cell that is no finite number, and for a table without rows.
CurveTable ReadCurveTable(const std::string& path);

}  // namespace clothid

#endif  // CLOTHID_DATASETS_CURVES_CURVE_TABLE_H_

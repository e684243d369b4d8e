// Tables of a laboratory, as testing machines and spreadsheets export them.
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
// "Force [N]", or in a row below:
//   force         N, mN, kN, cN, gf, kgf, or per width N/m, N/cm, N/mm
//   length        m, cm, mm, or of another length %, 1, mm/mm, m/m
//   angle         deg, degrees, rad
// Letter case of names does not matter, and a name may have words before it, "Tensile strain". Of the lines above the
// header, Width and Gauge length are read, with a number and a unit.
#ifndef CLOTHID_DATASETS_CURVES_LAB_TABLE_H_
#define CLOTHID_DATASETS_CURVES_LAB_TABLE_H_

#include <Eigen/Core>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

namespace clothid {

inline constexpr std::uint64_t kMaxCurveBytes = std::uint64_t{1} << 28;

enum class LabQuantity { kForce, kForcePerWidth, kLength, kStrain, kAngle };

// A column that is looked for, among those that the columns before it in the form have left. Of several in a table the
// one whose name stands first here is taken, the plain name before one with words.
struct LabColumn {
  std::vector<std::string_view> names;  // in small letters
  std::vector<LabQuantity> quantities;  // that it may have
  const char* units;                    // of these, for messages
};

// A kind of table: the columns that its header must have.
struct LabForm {
  std::vector<LabColumn> columns;
  const char* wanted;   // for messages, "columns of force and of extension"; empty: another form with more columns
  const char* example;  // a header, "Extension [mm];Force [N]"
};

struct LabTable {
  std::string name;                           // for messages: the file
  std::size_t form = 0;                       // which of those that were looked for
  Eigen::MatrixXd values;                     // [R x C] N, N/m, m, 1 or rad, in the order of the form's columns
  std::vector<int> lines;                     // [R] of the file
  std::vector<LabQuantity> quantities;        // [C]
  std::vector<std::string> columns;           // [C] what was read, "'Extension' in mm"
  std::optional<double> width, gauge_length;  // m, of the specimen, where the file tells them
};

// The header is the first line with all columns of a form; of several forms the first counts. Throws `Error`: kIo where
// the file cannot be read; kBadData, naming file and line and what was expected, for a file of more than
// kMaxCurveBytes, a header that is missing or names a column twice, a unit that is missing or unknown, a row of another
// number of cells than the header or with a cell that is no finite number, and for a table without rows.
LabTable ReadLabTable(const std::string& path, const std::vector<LabForm>& forms);

}  // namespace clothid

#endif  // CLOTHID_DATASETS_CURVES_LAB_TABLE_H_

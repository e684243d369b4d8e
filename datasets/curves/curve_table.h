// Curves of force over elongation, as testing machines export them: tables (datasets/curves/lab_table.h) with columns
//   force         named force, load or kraft
//   elongation    named extension, elongation, displacement, stroke, travel, position or weg, else strain or dehnung;
//                 a length, or a strain of the gauge length
// and, where the strip was seen from the front, one across the pull at half its length
//   width         named width or breite, a length: the distance of two marks; transverse strain, lateral strain or
//                 querdehnung: the strain of the whole width, below 0 where the cloth contracts
#ifndef CLOTHID_DATASETS_CURVES_CURVE_TABLE_H_
#define CLOTHID_DATASETS_CURVES_CURVE_TABLE_H_

#include <Eigen/Core>
#include <optional>
#include <string>

namespace clothid {

struct CurveTable {
  std::string name;                           // for messages: the file
  Eigen::VectorXd elongations;                // [R] m, or of the gauge length (1), in the order of the file
  Eigen::VectorXd forces;                     // [R] N, or N per m of width
  Eigen::VectorXd widths;                     // [R] m, or a strain (1); empty: not measured, or the same all the time
  bool is_strain = false;                     // elongations are strains
  bool is_width_strain = false;               // widths are strains
  bool is_per_width = false;                  // forces are per width
  std::optional<double> width, gauge_length;  // m, of the specimen, where the file tells them
  std::string columns;                        // what was read, "'Extension' in mm and 'Force' in N"
};

// Throws `Error` as `ReadLabTable`.
CurveTable ReadCurveTable(const std::string& path);

}  // namespace clothid

#endif  // CLOTHID_DATASETS_CURVES_CURVE_TABLE_H_

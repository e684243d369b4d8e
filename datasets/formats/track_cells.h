// Cells of tables of points. Internal to datasets/.
#ifndef CLOTHID_DATASETS_FORMATS_TRACK_CELLS_H_
#define CLOTHID_DATASETS_FORMATS_TRACK_CELLS_H_

#include <optional>
#include <string>
#include <string_view>

namespace clothid {

// A coordinate: a finite number, or NaN for an empty cell and for the word "nan" in any letter case; else nothing.
std::optional<double> ParseCoordinate(std::string_view cell);

// The cell of which `ParseCoordinate` makes exactly `value`, which must be finite or NaN.
std::string CoordinateText(double value);

}  // namespace clothid

#endif  // CLOTHID_DATASETS_FORMATS_TRACK_CELLS_H_

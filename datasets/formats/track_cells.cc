#include "datasets/formats/track_cells.h"

#include <cmath>
#include <limits>

#include "sim/base/csv_row.h"
#include "sim/base/text_file.h"

namespace clothid {

std::optional<double> ParseCoordinate(std::string_view cell) {
  if (cell.empty() || IsNanWord(cell)) return std::numeric_limits<double>::quiet_NaN();
  return ParseNumber(cell);
}

std::string CoordinateText(double value) { return std::isnan(value) ? "" : ShortestText(value); }

}  // namespace clothid

#include "datasets/importing/missing_value.h"

#include <algorithm>
#include <limits>
#include <optional>

#include "sim/base/error.h"
#include "sim/base/text_file.h"

namespace clothid {
namespace {

bool IsSame(double found, double value) {
  return found == value || found == static_cast<double>(static_cast<float>(value));
}

}  // namespace

MissingValues MissingValues::Parse(const std::string& text, const std::string& source) {
  if (text.empty()) return {};
  std::vector<Eigen::Vector3d> positions;
  for (const std::string& item : Split(text, ':')) {
    const std::vector<std::string> words = Split(item, ',');
    Eigen::Vector3d position;
    for (std::size_t k = 0; k < 3; ++k) {
      const std::optional<double> number = ParseNumber(words[words.size() == 1 ? 0 : std::min(k, words.size() - 1)]);
      if (!number || (words.size() != 1 && words.size() != 3)) {
        throw Error(ErrorKind::kUsage, source + ": expected a position as in 0,0,0 or one number, several separated " +
                                           "by colons, got '" + Printable(item) + "'");
      }
      position[static_cast<Eigen::Index>(k)] = *number;
    }
    positions.push_back(position);
  }
  return MissingValues(std::move(positions));
}

bool MissingValues::Contains(const Eigen::Ref<const Eigen::Vector3d>& point) const {
  return std::any_of(positions_.begin(), positions_.end(), [&](const Eigen::Vector3d& value) {
    return IsSame(point[0], value[0]) && IsSame(point[1], value[1]) && IsSame(point[2], value[2]);
  });
}

void MissingValues::Erase(double divisor, Eigen::MatrixXd* positions) const {
  if (is_empty()) return;
  MissingValues divided = *this;
  for (Eigen::Vector3d& value : divided.positions_) value /= divisor;
  for (auto point : positions->reshaped(3, positions->size() / 3).colwise()) {
    if (divided.Contains(point)) point.setConstant(std::numeric_limits<double>::quiet_NaN());
  }
}

}  // namespace clothid

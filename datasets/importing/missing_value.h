// Numbers that a file holds in place of points that were not seen, as depth cameras write (0, 0, 0).
#ifndef CLOTHID_DATASETS_IMPORTING_MISSING_VALUE_H_
#define CLOTHID_DATASETS_IMPORTING_MISSING_VALUE_H_

#include <Eigen/Core>
#include <string>
#include <utility>
#include <vector>

namespace clothid {

// Positions in the unit and axes of the file, any of which stands for "not seen".
class MissingValues {
 public:
  MissingValues() = default;
  explicit MissingValues(std::vector<Eigen::Vector3d> positions) : positions_(std::move(positions)) {}

  // "0,0,0", or one number that all three coordinates are; several separated by colons, as in "0:-1e6". Empty: none.
  // Throws `Error` (kUsage), led by `source`, for anything else.
  static MissingValues Parse(const std::string& text, const std::string& source);

  bool is_empty() const { return positions_.empty(); }
  // Whether a point is one of them: all coordinates are the same, as doubles or rounded to float32, as the file may
  // have kept them.
  bool Contains(const Eigen::Ref<const Eigen::Vector3d>& point) const;
  // Makes gaps (NaN) of them in `positions` [3P x T], which are the numbers of the file over `divisor`.
  void Erase(double divisor, Eigen::MatrixXd* positions) const;

 private:
  std::vector<Eigen::Vector3d> positions_;
};

}  // namespace clothid

#endif  // CLOTHID_DATASETS_IMPORTING_MISSING_VALUE_H_

#include "identify/estimate/fitted_field.h"

#include <cstdio>

namespace clothid {
bool IsDetermined(const FittedField& field, Eigen::Index row, Eigen::Index column) {
  if (field.log_std.size() == 0) return false;
  return IsDetermined(field.log_std(row, column), field.deviation_std(row, column),
                      field.prior_deviation_std(row, column));
}

double ShareDetermined(const FittedField& field) {
  double count = 0.0;
  for (Eigen::Index r = 0; r < field.values.rows(); ++r) {
    for (Eigen::Index c = 0; c < field.values.cols(); ++c) count += IsDetermined(field, r, c) ? 1.0 : 0.0;
  }
  return count / static_cast<double>(field.values.size());
}

std::string DescribeField(const FittedField& field) {
  const auto size = static_cast<int>(field.values.size());
  char text[200];
  std::snprintf(text, sizeof(text), "%s over %d x %d: %.4g .. %.4g %s", field.request.name.c_str(), field.request.rows,
                field.request.columns, field.values.minCoeff(), field.values.maxCoeff(),
                RowOf(field.request.kind).unit);
  std::string line = text;
  if (field.log_std.size() == 0) return line + ", how sure was not estimated";
  std::snprintf(text, sizeof(text), ", determined at %.0f of %d control nodes", ShareDetermined(field) * size, size);
  return line + text;
}

}  // namespace clothid

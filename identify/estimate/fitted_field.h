// What a fit found out about fields.
#ifndef CLOTHID_IDENTIFY_ESTIMATE_FITTED_FIELD_H_
#define CLOTHID_IDENTIFY_ESTIMATE_FITTED_FIELD_H_

#include <Eigen/Core>
#include <string>
#include <vector>

#include "costs/field/field_request.h"

namespace clothid {

struct FittedField {
  FieldRequest request;
  Eigen::MatrixXd values;  // [rows x columns] at the control nodes, in the parameter's unit
  // Standard deviations of the logarithms: of the value, and of its deviation from the mean, after the recordings and
  // as the prior alone has it. Empty where they were not estimated.
  Eigen::MatrixXd log_std, deviation_std, prior_deviation_std;
  double start = 0.0;  // the same everywhere
};

struct FieldResult {
  std::vector<FittedField> fields;
  double weight = 0.0;  // of the prior (identify/problem/problem.h)
  bool weight_is_chosen = false;
  double num_determined = 0.0;  // effective number of unknowns that the recordings determine; 0 where not estimated
};

// A control node is determined where the logarithm of its value has at most this standard deviation, ..
inline constexpr double kDeterminedStd = 0.1;
// .. and its deviation from the mean at most this share of what the prior leaves it.
inline constexpr double kDeterminedShare = 0.5;

// Of the three deviations of `FittedField` at a place.
inline bool IsDetermined(double log_std, double deviation_std, double prior_deviation_std) {
  return log_std <= kDeterminedStd && deviation_std <= kDeterminedShare * prior_deviation_std;
}
bool IsDetermined(const FittedField& field, Eigen::Index row, Eigen::Index column);
double ShareDetermined(const FittedField& field);  // of the control nodes

// One line: "k_stretch over 8 x 8: 52.1 .. 81.3 N/m, determined at 55 of 64 control nodes".
std::string DescribeField(const FittedField& field);

}  // namespace clothid

#endif  // CLOTHID_IDENTIFY_ESTIMATE_FITTED_FIELD_H_

#include "costs/rows/rollout_evaluation.h"

#include <cstddef>
#include <string_view>

#include "datasets/files/sha256.h"

namespace clothid {

std::string DigestOf(const Eigen::MatrixXd& combinations) {
  if (combinations.cols() == 0) return {};
  const Eigen::Index shape[] = {combinations.rows(), combinations.cols()};
  return Sha256Hex({{reinterpret_cast<const char*>(shape), sizeof(shape)},
                    {reinterpret_cast<const char*>(combinations.data()),
                     static_cast<std::size_t>(combinations.size()) * sizeof(double)}});
}

bool RolloutEvaluation::Lacks(const EvaluationKey& key) const {
  switch (key.need) {
    case EvaluationNeed::kCost:
    case EvaluationNeed::kCostAlone:
      return is_new();
    case EvaluationNeed::kRows:
      return is_new() || !has_rows || !rows.Covers(key.active);
    case EvaluationNeed::kGradient:
      return is_new() || !has_gradient;
    case EvaluationNeed::kExactRows:
      return is_new() || !has_exact_rows || !exact_rows.Covers(key.active) ||
             exact_rows.along != DigestOf(key.combinations);
    case EvaluationNeed::kProduct:
    case EvaluationNeed::kPullBack:
      break;
  }
  return true;
}

}  // namespace clothid

// Values of result.json that several of its parts have.
#ifndef CLOTHID_IDENTIFY_RESULT_NAMED_JSON_H_
#define CLOTHID_IDENTIFY_RESULT_NAMED_JSON_H_

#include <Eigen/Core>
#include <limits>
#include <nlohmann/json.hpp>
#include <vector>

#include "identify/estimate/fit_summary.h"

namespace clothid {

// JSON text has null for NaN and infinity.
inline constexpr double kJsonNull = std::numeric_limits<double>::quiet_NaN();

// Each value by the name of its parameter; null where there are no values.
inline nlohmann::ordered_json NamedJson(const std::vector<FittedParameter>& parameters, const Eigen::VectorXd& values) {
  if (values.size() == 0) return nullptr;
  nlohmann::ordered_json json = nlohmann::ordered_json::object();
  for (std::size_t i = 0; i < parameters.size(); ++i) {
    json[parameters[i].name] = values[static_cast<Eigen::Index>(i)];
  }
  return json;
}

}  // namespace clothid

#endif  // CLOTHID_IDENTIFY_RESULT_NAMED_JSON_H_

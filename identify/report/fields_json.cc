#include "identify/report/fields_json.h"

namespace clothid {
namespace {

using Json = nlohmann::ordered_json;

template <typename Matrix>
Json RowsJson(const Matrix& values) {
  Json rows = Json::array();
  for (Eigen::Index r = 0; r < values.rows(); ++r) {
    Json row = Json::array();
    for (Eigen::Index c = 0; c < values.cols(); ++c) row.push_back(values(r, c));
    rows.push_back(row);
  }
  return rows;
}

Json FieldJson(const FittedField& field) {
  Json json = {{"values", RowsJson(field.values)}, {"start", field.start}};
  if (field.log_std.size() == 0) return json;
  Eigen::Matrix<bool, Eigen::Dynamic, Eigen::Dynamic> determined(field.values.rows(), field.values.cols());
  for (Eigen::Index r = 0; r < determined.rows(); ++r) {
    for (Eigen::Index c = 0; c < determined.cols(); ++c) determined(r, c) = IsDetermined(field, r, c);
  }
  json["log_std"] = RowsJson(field.log_std);
  json["determined"] = RowsJson(determined);
  return json;
}

}  // namespace

nlohmann::ordered_json FieldsJson(const FieldResult& result) {
  Json fields = Json::object();
  for (const FittedField& field : result.fields) fields[field.request.name] = FieldJson(field);
  return {{"fields", fields},
          {"weight", result.weight},
          {"weight_is_chosen", result.weight_is_chosen},
          {"num_determined", result.num_determined},
          {"converged", result.has_converged},
          {"message", result.message},
          {"iterations", result.num_iterations},
          {"rollouts", result.num_rollouts},
          {"sweeps", result.num_sweeps}};
}

}  // namespace clothid

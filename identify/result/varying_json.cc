#include "identify/result/varying_json.h"

#include <string>

namespace clothid {
namespace {

using Json = nlohmann::ordered_json;

template <typename Matrix>
Json RowsJson(const Matrix& values) {
  Json rows = Json::array();
  for (const auto& row : values.rowwise()) rows.push_back(row);
  return rows;
}

Json FieldJson(const FittedField& field) {
  Json json = {{"values", RowsJson(field.values)}, {"start", field.start}};
  if (field.log_std.size() == 0) return json;
  using Flags = Eigen::Matrix<bool, Eigen::Dynamic, Eigen::Dynamic>;
  const Flags determined =
      Flags::NullaryExpr(field.values.rows(), field.values.cols(),
                         [&](Eigen::Index row, Eigen::Index column) { return IsDetermined(field, row, column); });
  json["log_std"] = RowsJson(field.log_std);
  json["determined"] = RowsJson(determined);
  return json;
}

Json ProfileJson(const WindProfile& profile) {
  return {{"times", profile.times}, {"velocities", RowsJson(profile.velocities.transpose())}};
}

}  // namespace

nlohmann::ordered_json FieldsJson(const FieldResult& result) {
  Json fields = Json::object();
  for (const FittedField& field : result.fields) fields[field.request.name] = FieldJson(field);
  return {{"fields", fields},
          {"weight", result.weight},
          {"weight_is_chosen", result.weight_is_chosen},
          {"num_determined", result.num_determined}};
}

nlohmann::ordered_json WindJson(const WindResult& result) {
  Json recordings = Json::array();
  for (const WindProfile& profile : result.profiles) {
    recordings.push_back({{"profile", ProfileJson(profile)}, {"fitted", Json::array()}});
  }
  for (const FittedWind& wind : result.winds) {
    recordings[wind.recording]["fitted"].push_back({{"component", std::string(1, "xyz"[wind.axis])},
                                                    {"values", wind.values},
                                                    {"lower95", wind.lower95},
                                                    {"upper95", wind.upper95},
                                                    {"start", wind.start},
                                                    {"knots_told", wind.num_told}});
  }
  return {{"smoothness", result.smoothness > 0.0 ? Json(result.smoothness) : Json(nullptr)},
          {"smoothness_source", SmoothnessWords(result.smoothness_source)},
          {"recordings", recordings}};
}

}  // namespace clothid

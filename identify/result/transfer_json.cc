#include "identify/result/transfer_json.h"

#include <cmath>

namespace clothid {
namespace {

using Json = nlohmann::ordered_json;

}  // namespace

Json HeldBandCellJson(const HeldBandCell& cell) {
  return {{"inside", cell.inside},
          {"inside_if_right", {cell.inside_if_right.low, cell.inside_if_right.high}},
          {"measurements", static_cast<long long>(cell.num)},
          {"median_rmse", cell.rmse},
          {"median_rmse_if_right", {cell.rmse_if_right.low, cell.rmse_if_right.high}},
          {"crps", cell.score},
          {"half_width", cell.half_width}};
}

Json HeldRecordingsJson(const std::vector<HeldRecordingBands>& recordings) {
  Json json = Json::array();
  for (const HeldRecordingBands& recording : recordings) {
    Json own = {{"name", recording.name}};
    own.update(HeldBandCellJson(recording.all));
    own["worth_until_s"] = std::isfinite(recording.worth_until) ? Json(recording.worth_until) : Json(nullptr);
    json.push_back(own);
  }
  return json;
}

Json TransferJson(const Transfer& transfer) {
  Json json = Json::array();
  for (const TransferRow& row : transfer.rows) {
    json.push_back({{"name", row.name},
                    {"why_not", row.why_not.empty() ? Json(nullptr) : Json(row.why_not)},
                    {"unit", row.has_only_forces ? "N" : "m"},
                    {"predicted", HeldRecordingsJson(row.predicted)}});
  }
  return json;
}

}  // namespace clothid

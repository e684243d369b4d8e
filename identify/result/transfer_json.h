// How well bands hold what was seen, for programs (identify/prediction/transfer.h).
#ifndef CLOTHID_IDENTIFY_RESULT_TRANSFER_JSON_H_
#define CLOTHID_IDENTIFY_RESULT_TRANSFER_JSON_H_

#include <nlohmann/json.hpp>
#include <vector>

#include "identify/prediction/transfer.h"

namespace clothid {

nlohmann::ordered_json HeldBandCellJson(const HeldBandCell& cell);
// One per recording: its "name", as of `HeldBandCellJson`, and "worth_until_s", null: to the end.
nlohmann::ordered_json HeldRecordingsJson(const std::vector<HeldRecordingBands>& recordings);

// "transfer" of result.json: of every fitted recording its "name", "why_not" or null, and "predicted".
nlohmann::ordered_json TransferJson(const Transfer& transfer);

}  // namespace clothid

#endif  // CLOTHID_IDENTIFY_RESULT_TRANSFER_JSON_H_

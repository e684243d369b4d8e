// Who predicts whom: every recording of a run is fitted for itself, and what it tells predicts the others, with bands
// that are judged (identify/prediction/held_bands.h).
#ifndef CLOTHID_IDENTIFY_PREDICTION_TRANSFER_H_
#define CLOTHID_IDENTIFY_PREDICTION_TRANSFER_H_

#include <string>
#include <vector>

#include "identify/prediction/held_bands.h"

namespace clothid {

// By the fit of one recording.
struct TransferRow {
  std::string name;
  std::string why_not;                        // nothing was predicted, in one line; empty: it was
  std::vector<HeldRecordingBands> predicted;  // the others, in their order; those without measurements left out
  bool has_only_forces = false;               // lengths are N
};

struct Transfer {
  std::vector<TransferRow> rows;  // of all recordings, in their order
};

}  // namespace clothid

#endif  // CLOTHID_IDENTIFY_PREDICTION_TRANSFER_H_

// Who predicts whom, for people (identify/prediction/transfer.h).
#ifndef CLOTHID_IDENTIFY_REPORT_TRANSFER_REPORT_H_
#define CLOTHID_IDENTIFY_REPORT_TRANSFER_REPORT_H_

#include <string>

#include "identify/prediction/transfer.h"

namespace clothid {

// A line per pair for the terminal, below a line of what its numbers are.
std::string TransferRows(const Transfer& transfer);

}  // namespace clothid

#endif  // CLOTHID_IDENTIFY_REPORT_TRANSFER_REPORT_H_

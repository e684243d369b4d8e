#include "identify/report/transfer_report.h"

#include <cmath>
#include <sstream>

#include "identify/base/join_words.h"

namespace clothid {
namespace {

std::string WorthText(double worth_until) {
  if (std::isnan(worth_until)) return "";
  if (std::isinf(worth_until)) return "; worth more than the cloth at rest to the end";
  if (worth_until == 0.0) return "; worth no more than the cloth at rest";
  return "; worth more than the cloth at rest to " + NumberText(worth_until, 3) + " s";
}

std::string PairText(const HeldRecordingBands& predicted, bool has_only_forces) {
  const auto length = [&](double value) {
    return has_only_forces ? NumberText(value, 2) + " N" : MillimetreText(value, 2);
  };
  const HeldBandCell& all = predicted.all;
  const char* verdict = all.IsTooNarrow() ? ", too narrow" : all.IsTooWide() ? ", too wide" : "";
  return predicted.name + ": " + std::to_string(std::lround(100.0 * all.inside)) +
         " % (right: " + RangeText(all.inside_if_right) + ") in +- " + length(all.half_width) + verdict +
         ", misses by " + length(all.rmse) + " (right: " + length(all.rmse_if_right.low) + " to " +
         length(all.rmse_if_right.high) + "), CRPS " + length(all.score) + WorthText(predicted.worth_until);
}

}  // namespace

std::string TransferRows(const Transfer& transfer) {
  std::ostringstream rows;
  rows << "transfer        each recording fitted for itself predicts the others: bands of 90 % hold so much\n";
  for (const TransferRow& row : transfer.rows) {
    if (!row.why_not.empty()) rows << "  " << row.name << " predicts nothing: " << row.why_not << "\n";
    for (const HeldRecordingBands& predicted : row.predicted) {
      rows << "  " << row.name << " predicts " << PairText(predicted, row.has_only_forces) << "\n";
    }
  }
  return rows.str();
}

}  // namespace clothid

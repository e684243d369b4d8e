#include "identify/prediction/held_bands.h"

#include <cmath>
#include <vector>

#include "identify/base/join_words.h"

namespace clothid {

namespace {

std::string BandPercent(double share) { return std::to_string(std::lround(100.0 * share)) + " %"; }

std::string LeadsText(const std::vector<HeldBandCell>& leads) {
  if (leads.size() < 2) return "";
  std::vector<std::string> cells;
  for (const HeldBandCell& cell : leads) {
    cells.push_back(BandPercent(cell.inside) +
                    (std::isinf(cell.until) ? " after that" : " to " + NumberText(cell.until) + " s") +
                    " (right: " + RangeText(cell.inside_if_right) + ")");
  }
  return "; " + JoinWords(cells);
}

std::string CalibrationText(const HeldBands& bands) {
  if (!bands.calibration) return "";
  if (bands.calibration->factor == 1.0) return "; not calibrated: they hold what right bands may hold";
  return "; calibrated: with " + NumberText(bands.calibration->factor, 2) +
         " times the force that the model lacks they hold " + BandPercent(bands.calibration->inside);
}

}  // namespace

std::size_t LeadOf(double time) {
  constexpr double kRounding = 1e-9;  // s
  std::size_t lead = 0;
  while (time > kHeldLeads[lead] + kRounding) ++lead;
  return lead;
}

std::string RangeText(const RightRange& range) {
  return std::to_string(std::lround(100.0 * range.low)) + " to " + BandPercent(range.high);
}

std::string HeldBandsText(const HeldBands& bands, bool has_only_forces) {
  if (!bands.why_not.empty()) return "no bands of predictions: " + bands.why_not;
  const auto length = [&](double value) {
    return has_only_forces ? NumberText(value, 2) + " N" : MillimetreText(value, 2);
  };
  const HeldBandCell& all = bands.all;
  const std::string held = all.IsTooNarrow() ? "bands of 90 % are too narrow: they held "
                           : all.IsTooWide() ? "bands of 90 % are too wide: they held "
                                             : "bands of 90 % held ";
  return held + BandPercent(all.inside) +
         " of what was held out (a right prediction: " + RangeText(all.inside_if_right) + ")" + LeadsText(bands.leads) +
         "; +- " + length(all.half_width) + " about a median that misses by " + length(all.rmse) +
         " (right: " + length(all.rmse_if_right.low) + " to " + length(all.rmse_if_right.high) + "), CRPS " +
         length(all.score) + CalibrationText(bands);
}

}  // namespace clothid

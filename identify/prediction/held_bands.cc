#include "identify/prediction/held_bands.h"

#include <cmath>
#include <vector>

#include "identify/base/join_words.h"

namespace clothid {

namespace {

std::string BandPercent(double share) { return std::to_string(std::lround(100.0 * share)) + " %"; }

std::string CalibrationText(const HeldBands& bands) {
  if (!bands.calibration) return "";
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

std::string HeldBandsText(const HeldBands& bands, bool has_only_forces) {
  if (!bands.why_not.empty()) return "no bands of predictions: " + bands.why_not;
  const auto length = [&](double value) {
    return has_only_forces ? NumberText(value, 2) + " N" : MillimetreText(value, 2);
  };
  std::vector<std::string> leads;
  for (const HeldBandCell& cell : bands.leads) {
    leads.push_back(BandPercent(cell.inside) +
                    (std::isinf(cell.until) ? " after that" : " to " + NumberText(cell.until) + " s"));
  }
  return "bands of 90 % held " + BandPercent(bands.all.inside) + " of what was held out" +
         (leads.size() > 1 ? " (" + JoinWords(leads) + ")" : "") + ", +- " + length(bands.all.half_width) +
         " about a median that misses by " + length(bands.all.rmse) + ", CRPS " + length(bands.all.score) +
         CalibrationText(bands);
}

}  // namespace clothid

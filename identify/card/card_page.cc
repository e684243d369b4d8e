#include "identify/card/card_page.h"

#include <algorithm>
#include <cmath>
#include <nlohmann/json.hpp>
#include <string_view>

#include "identify/card/card_of_fit.h"
#include "identify/card/seen_ranges.h"
#include "identify/page/page_template.h"

namespace clothid {

// Files embedded by CMake.
std::string_view CardPage();    // card_page.html
std::string_view CardScript();  // its scripts

namespace {

using Json = nlohmann::ordered_json;

constexpr int kCardDigits = 6;
constexpr Eigen::Index kMaxCardReadings = 500;  // of a curve

// The values [T] at `times` [T], on straight lines at time `time`.
double Interpolated(const Eigen::VectorXd& times, const Eigen::VectorXd& values, double time) {
  Eigen::Index i = 1;
  while (i + 1 < times.size() && times[i] < time) ++i;
  const double share = std::clamp((time - times[i - 1]) / (times[i] - times[i - 1]), 0.0, 1.0);
  return (1.0 - share) * values[i - 1] + share * values[i];
}

// The strain of the cloth over time along what it is pulled along.
Eigen::VectorXd PulledStrains(const Scene& scene, const Eigen::MatrixXd& nodes) {
  if (scene.membrane == MembraneLaw::kArap) return MeanStrains(scene, nodes, ParameterKind::kStretchStiffness);
  const Eigen::VectorXd warp = MeanStrains(scene, nodes, ParameterKind::kWarpStiffness);
  const Eigen::VectorXd weft = MeanStrains(scene, nodes, ParameterKind::kWeftStiffness);
  return warp[warp.size() - 1] > weft[weft.size() - 1] ? warp : weft;
}

// The component that is measured and largest, positive where the cloth pulls most.
Json TensileCurveJson(const RecordedMotion& motion, const Eigen::MatrixXd& predicted, const Eigen::MatrixXd& nodes) {
  const Eigen::MatrixXd measured = motion.forces.values.array().isNaN().select(0.0, motion.forces.values.array());
  Eigen::Index row = 0, at = 0;
  measured.cwiseAbs().maxCoeff(&row, &at);
  const double sign = measured(row, at) < 0.0 ? -1.0 : 1.0;
  const Eigen::VectorXd strains = PulledStrains(motion.scene, nodes);
  const Eigen::Index every = motion.forces.num_readings() / kMaxCardReadings + 1;
  Json json = {
      {"name", motion.name}, {"strain", Json::array()}, {"measured", Json::array()}, {"fitted", Json::array()}};
  for (Eigen::Index i = 0; i < motion.forces.num_readings(); i += every) {
    json["strain"].push_back(RoundedJson(Interpolated(motion.times, strains, motion.forces.times[i]), kCardDigits));
    json["measured"].push_back(RoundedJson(sign * motion.forces.values(row, i) + 0.0, kCardDigits));
    json["fitted"].push_back(RoundedJson(sign * predicted(row, i), kCardDigits));
  }
  return json;
}

}  // namespace

std::string CardHtml(const FabricCard& card, const FitSummary& summary, const std::vector<RecordedMotion>& motions,
                     const std::vector<Eigen::MatrixXd>& nodes) {
  Json data = {{"card", Json::parse(FabricCardJson(card))}, {"curves", Json::array()}};
  for (std::size_t r = 0; r < motions.size(); ++r) {
    const bool has_forces = r < summary.forces.size() && summary.forces[r].cols() > 0;
    const bool is_curve = has_forces && IsTensileCurve(motions[r]) && nodes[r].cols() > 1;
    if (is_curve) data["curves"].push_back(TensileCurveJson(motions[r], summary.forces[r], nodes[r]));
  }
  return MakePage({"Fabric card", CardPage(), {}, /*has_charts=*/false, {CardScript()}}, ScriptText(data));
}

}  // namespace clothid

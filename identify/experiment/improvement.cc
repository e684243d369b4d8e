#include "identify/experiment/improvement.h"

#include <algorithm>
#include <cmath>
#include <utility>

namespace clothid {
namespace {

// The block of a name, or of the first recording's own; -1: there is none.
int FindBlock(const std::vector<ParameterBlock>& blocks, const std::string& name) {
  const auto found = std::find_if(blocks.begin(), blocks.end(),
                                  [&](const ParameterBlock& block) { return BaseName(block.name) == name; });
  return found == blocks.end() ? -1 : static_cast<int>(found - blocks.begin());
}

// From the widths `before`, of `planned`, to those `after`, of `improved`.
Improvement Compare(ImprovementKind kind, const std::vector<std::string>& names, const Expectation& planned,
                    const Eigen::VectorXd& before, const Expectation& improved, const Eigen::VectorXd& after) {
  Improvement improvement;
  improvement.kind = kind;
  improvement.factors = Eigen::VectorXd::Ones(static_cast<Eigen::Index>(names.size()));
  for (std::size_t k = 0; k < names.size(); ++k) {
    const int old_block = FindBlock(planned.blocks(), names[k]), new_block = FindBlock(improved.blocks(), names[k]);
    if (new_block < 0 || improved.blocks()[new_block].frozen) continue;
    const double was = old_block < 0 ? StdBefore(improved.blocks()[new_block]) : before[old_block];
    improvement.factors[static_cast<Eigen::Index>(k)] = after[new_block] / was;
    const bool was_told = old_block >= 0 && planned.is_told(old_block);
    if (!was_told && improved.is_told(new_block)) improvement.tells.push_back(names[k]);
  }
  return improvement;
}

}  // namespace

std::vector<ClothRows> PlannedRows(const std::vector<ClothInformation>& cloths) {
  std::vector<ClothRows> rows;
  for (const ClothInformation& cloth : cloths) {
    if (cloth.failure.empty()) rows.push_back(RowsOf(cloth, cloth.planned));
  }
  return rows;
}

std::vector<Improvement> FindImprovements(const std::vector<std::string>& names,
                                          const std::vector<ClothInformation>& cloths, const Expectation& planned) {
  std::vector<Improvement> improvements;
  for (const auto& [kind, nominal_rows] : cloths.front().improved) {
    std::vector<ClothRows> before, after;  // of the cloths that it was looked for
    for (const ClothInformation& cloth : cloths) {
      const auto improved = cloth.improved.find(kind);
      if (!cloth.failure.empty() || improved == cloth.improved.end()) continue;
      before.push_back(RowsOf(cloth, cloth.planned));
      after.push_back(RowsOf(cloth, improved->second));
    }
    const Expectation improved(after, {});
    improvements.push_back(
        Compare(kind, names, planned, Expectation(before, {}).Widths(0.0), improved, improved.Widths(0.0)));
  }
  if ((cloths.front().step_errors.array() > 0.0).any()) {
    improvements.push_back(
        Compare(ImprovementKind::kHalfStep, names, planned, planned.Widths(1.0), planned, planned.Widths(0.5)));
  }
  return improvements;
}

Improvement FindPartner(const std::vector<std::string>& names, const Expectation& planned, const Expectation& of_joint,
                        int partner) {
  Improvement improvement =
      Compare(ImprovementKind::kBothScenes, names, planned, planned.Widths(0.0), of_joint, of_joint.Widths(0.0));
  improvement.partner = partner;
  return improvement;
}

void SortImprovements(int worst_told, std::vector<Improvement>* improvements) {
  for (Improvement& improvement : *improvements) improvement.worst = improvement.factors[worst_told];
  const auto key = [](const Improvement& improvement) {
    return std::pair(improvement.worst, improvement.factors.array().log().sum());
  };
  std::stable_sort(improvements->begin(), improvements->end(),
                   [&](const Improvement& a, const Improvement& b) { return key(a) < key(b); });
}

std::string ImprovementName(ImprovementKind kind) {
  switch (kind) {
    case ImprovementKind::kTwiceFrames:
      return "twice the frame rate";
    case ImprovementKind::kHalfNoise:
      return "half the noise";
    case ImprovementKind::kGauge:
      return "a gauge at the gripper";
    case ImprovementKind::kMoreMarkers:
      return "twice the markers";
    case ImprovementKind::kLonger:
      return "half as long again";
    case ImprovementKind::kKnownStart:
      return "a known start";
    case ImprovementKind::kHalfStep:
      return "half the time step";
    case ImprovementKind::kBothScenes:
      return "both scenes";
  }
  return "";
}

}  // namespace clothid

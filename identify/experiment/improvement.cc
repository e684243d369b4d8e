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

// Compares `improved` with `planned`, whose widths over the same cloths are `before`.
Improvement Compare(ImprovementKind kind, const std::vector<std::string>& names, const Expectation& planned,
                    const Eigen::VectorXd& before, const Expectation& improved, double step_share) {
  Improvement improvement;
  improvement.kind = kind;
  improvement.factors = Eigen::VectorXd::Ones(static_cast<Eigen::Index>(names.size()));
  const Eigen::VectorXd after = improved.Widths(step_share);
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
    if (cloth.failure.empty()) rows.push_back({cloth.blocks, cloth.coordinates, cloth.planned, cloth.num_measurements});
  }
  return rows;
}

std::vector<Improvement> FindImprovements(const std::vector<std::string>& names,
                                          const std::vector<ClothInformation>& cloths, const Expectation& planned) {
  std::vector<Improvement> improvements;
  const Eigen::VectorXd& step_errors = cloths.front().step_errors;
  for (const auto& [kind, nominal_rows] : cloths.front().improved) {
    std::vector<ClothRows> before, after;  // of the cloths that it was looked for
    for (const ClothInformation& cloth : cloths) {
      const auto improved = cloth.improved.find(kind);
      if (!cloth.failure.empty() || improved == cloth.improved.end()) continue;
      before.push_back({cloth.blocks, cloth.coordinates, cloth.planned, cloth.num_measurements});
      after.push_back({cloth.blocks, cloth.coordinates, improved->second, cloth.num_measurements});
    }
    improvements.push_back(
        Compare(kind, names, planned, Expectation(before, step_errors).Widths(), Expectation(after, step_errors), 1.0));
  }
  if ((step_errors.array() > 0.0).any()) {
    improvements.push_back(
        Compare(ImprovementKind::kHalfStep, names, planned, planned.Widths(), planned, /*step_share=*/0.5));
  }
  return improvements;
}

Improvement FindPartner(const std::vector<std::string>& names, const Expectation& planned, const Expectation& of_joint,
                        int partner) {
  Improvement improvement =
      Compare(ImprovementKind::kBothScenes, names, planned, planned.Widths(), of_joint, /*step_share=*/1.0);
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

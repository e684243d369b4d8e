#include "sim/step/step_counts.h"

#include <cstddef>
#include <iterator>

namespace clothid {
namespace {

constexpr int RolloutCounts::*kCounts[] = {&RolloutCounts::steps,           &RolloutCounts::newton_iterations,
                                           &RolloutCounts::factorizations,  &RolloutCounts::linear_iterations,
                                           &RolloutCounts::fallbacks,       &RolloutCounts::substeps,
                                           &RolloutCounts::failed_steps,    &RolloutCounts::contacts,
                                           &RolloutCounts::nodes_joined,    &RolloutCounts::nodes_left,
                                           &RolloutCounts::branch_switches, &RolloutCounts::obstacle_switches,
                                           &RolloutCounts::self_contacts,   &RolloutCounts::pair_changes,
                                           &RolloutCounts::second_solves};
static_assert(sizeof(RolloutCounts) == sizeof(int) * std::size(kCounts), "every count is listed");

}  // namespace

RolloutCounts& RolloutCounts::operator+=(const RolloutCounts& other) {
  for (int RolloutCounts::*const count : kCounts) this->*count += other.*count;
  return *this;
}

RolloutCounts& RolloutCounts::operator-=(const RolloutCounts& other) {
  for (int RolloutCounts::*const count : kCounts) this->*count -= other.*count;
  return *this;
}

void CountContactChanges(const std::vector<ContactRecord>& before, const std::vector<ContactRecord>& after,
                         RolloutCounts* counts) {
  counts->contacts += static_cast<int>(after.size());
  size_t i = 0, j = 0;  // both are in ascending order of nodes
  while (i < before.size() || j < after.size()) {
    const bool left = j == after.size() || (i < before.size() && before[i].node < after[j].node);
    const bool joined = i == before.size() || (j < after.size() && after[j].node < before[i].node);
    if (left) {
      ++counts->nodes_left;
    } else if (joined) {
      ++counts->nodes_joined;
    } else {
      counts->branch_switches += before[i].branch != after[j].branch;
      counts->obstacle_switches += before[i].obstacle != after[j].obstacle;
    }
    if (!joined) ++i;
    if (!left) ++j;
  }
}

void CountPairChanges(const std::vector<PairContactRecord>& before, const std::vector<PairContactRecord>& after,
                      RolloutCounts* counts) {
  counts->self_contacts += static_cast<int>(after.size());
  size_t i = 0, j = 0;
  while (i < before.size() || j < after.size()) {
    const bool left = j == after.size() || (i < before.size() && before[i].features < after[j].features);
    const bool joined = i == before.size() || (j < after.size() && after[j].features < before[i].features);
    counts->pair_changes += left || joined || before[i].branch != after[j].branch;
    if (!joined) ++i;
    if (!left) ++j;
  }
}

}  // namespace clothid

#include "sim/step/step_counts.h"

#include <cstddef>
#include <iterator>
#include <vector>

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

bool Precedes(const ContactRecord& a, const ContactRecord& b) { return a.node < b.node; }
bool Precedes(const PairContactRecord& a, const PairContactRecord& b) { return a.features < b.features; }

// Calls `visit` with every contact as it was and is, null where it was not or is not. Both are in ascending order.
template <class Record, class Function>
void Match(const std::vector<Record>& before, const std::vector<Record>& after, const Function& visit) {
  size_t i = 0, j = 0;
  while (i < before.size() || j < after.size()) {
    const bool left = j == after.size() || (i < before.size() && Precedes(before[i], after[j]));
    const bool joined = i == before.size() || (j < after.size() && Precedes(after[j], before[i]));
    visit(joined ? nullptr : &before[i], left ? nullptr : &after[j]);
    if (!joined) ++i;
    if (!left) ++j;
  }
}

}  // namespace

RolloutCounts& RolloutCounts::operator+=(const RolloutCounts& other) {
  for (int RolloutCounts::*const count : kCounts) this->*count += other.*count;
  return *this;
}

RolloutCounts& RolloutCounts::operator-=(const RolloutCounts& other) {
  for (int RolloutCounts::*const count : kCounts) this->*count -= other.*count;
  return *this;
}

void CountContactChanges(const ContactRecords& before, const ContactRecords& after, RolloutCounts* counts) {
  counts->contacts += static_cast<int>(after.nodes.size());
  counts->self_contacts += static_cast<int>(after.pairs.size());
  Match(before.nodes, after.nodes, [&](const ContactRecord* was, const ContactRecord* is) {
    if (is == nullptr) {
      ++counts->nodes_left;
    } else if (was == nullptr) {
      ++counts->nodes_joined;
    } else {
      counts->branch_switches += was->branch != is->branch;
      counts->obstacle_switches += was->obstacle != is->obstacle;
    }
  });
  Match(before.pairs, after.pairs, [&](const PairContactRecord* was, const PairContactRecord* is) {
    counts->pair_changes += was == nullptr || is == nullptr || was->branch != is->branch;
  });
}

}  // namespace clothid

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

void CountContactChanges(const ContactRecords& before, const ContactRecords& after, RolloutCounts* counts) {
  counts->contacts += static_cast<int>(after.nodes.size());
  counts->self_contacts += static_cast<int>(after.pairs.size());
  const ContactChanges changes = CompareContacts(before, after);
  counts->nodes_joined += changes.joined;
  counts->nodes_left += changes.left;
  counts->branch_switches += changes.branches;
  counts->obstacle_switches += changes.obstacles;
  counts->pair_changes += changes.pairs;
}

}  // namespace clothid

#include "sim/contact/contact_set.h"

#include <algorithm>

namespace clothid {
namespace {

// Calls `visit` with every contact as it was and is, null where it was not or is not. Both are in ascending order.
template <class Record, class Function>
void Match(const std::vector<Record>& before, const std::vector<Record>& after, const Function& visit) {
  std::size_t i = 0, j = 0;
  while (i < before.size() || j < after.size()) {
    const bool left = j == after.size() || (i < before.size() && before[i] < after[j]);
    const bool joined = i == before.size() || (j < after.size() && after[j] < before[i]);
    visit(joined ? nullptr : &before[i], left ? nullptr : &after[j]);
    if (!joined) ++i;
    if (!left) ++j;
  }
}

bool AreAlike(const ContactRecord& a, const ContactRecord& b) {
  return a.branch == b.branch && a.obstacle == b.obstacle;
}
bool AreAlike(const PairContactRecord& a, const PairContactRecord& b) {
  return a.branch == b.branch && a.has_friction == b.has_friction;
}

}  // namespace

bool ContactRecords::depend() const {
  return std::any_of(pairs.begin(), pairs.end(), [](const PairContactRecord& pair) { return !pair.has_friction; });
}

std::vector<std::array<int, 4>> ContactRecords::TouchingNodes() const {
  std::vector<std::array<int, 4>> touching;
  touching.reserve(pairs.size());
  for (const PairContactRecord& pair : pairs) touching.push_back(pair.features.nodes);
  return touching;
}

std::size_t BytesPerNode(bool has_obstacles, bool has_self_contact) {
  return (has_obstacles ? sizeof(ContactRecord) : 0) + (has_self_contact ? sizeof(PairContactRecord) : 0);
}

ContactRecords RecordContacts(const ContactSet& contacts) {
  ContactRecords records;
  records.nodes.reserve(contacts.nodes.size());
  for (const Contact& contact : contacts.nodes) {
    records.nodes.push_back(
        {contact.candidate.node, contact.candidate.obstacle, contact.response.branch, contact.force});
  }
  for (const PairContact& contact : contacts.pairs) {
    if (contact.response.branch == ContactBranch::kTakeOff) continue;
    records.pairs.push_back(
        {contact.candidate.features, contact.force, contact.response.branch, contact.candidate.has_friction});
  }
  return records;
}

ContactChanges CompareContacts(const ContactRecords& before, const ContactRecords& after) {
  ContactChanges changes;
  Match(before.nodes, after.nodes, [&](const ContactRecord* was, const ContactRecord* is) {
    if (is == nullptr) {
      ++changes.left;
    } else if (was == nullptr) {
      ++changes.joined;
    } else {
      changes.branches += was->branch != is->branch;
      changes.obstacles += was->obstacle != is->obstacle;
    }
  });
  Match(before.pairs, after.pairs, [&](const PairContactRecord* was, const PairContactRecord* is) {
    changes.pairs += was == nullptr || is == nullptr || was->branch != is->branch;
  });
  return changes;
}

int NumDifferences(const ContactRecords& one, const ContactRecords& other) {
  int num_differences = 0;
  const auto count = [&](const auto* was, const auto* is) {
    num_differences += was == nullptr || is == nullptr ? 1 : AreAlike(*was, *is) ? 0 : 2;
  };
  Match(one.nodes, other.nodes, count);
  Match(one.pairs, other.pairs, count);
  return num_differences;
}

}  // namespace clothid

// All contacts of a cloth in a solve, and what a rollout keeps of them.
#ifndef CLOTHID_SIM_CONTACT_CONTACT_SET_H_
#define CLOTHID_SIM_CONTACT_CONTACT_SET_H_

#include <cstddef>
#include <vector>

#include "sim/contact/contact.h"
#include "sim/contact/self_contact.h"

namespace clothid {

struct ContactSet {
  std::vector<Contact> nodes;      // with obstacles, ascending
  std::vector<PairContact> pairs;  // of the cloth with itself, ascending; those that leave may be among them

  bool empty() const { return nodes.empty() && pairs.empty(); }
};

// Of the contacts that stick or slip, in the order of their set.
struct ContactRecords {
  std::vector<ContactRecord> nodes = {};
  std::vector<PairContactRecord> pairs = {};

  bool empty() const { return nodes.empty() && pairs.empty(); }
  std::size_t bytes() const {
    return nodes.capacity() * sizeof(ContactRecord) + pairs.capacity() * sizeof(PairContactRecord);
  }
};

ContactRecords RecordContacts(const ContactSet& contacts);

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

// Of contacts that are in one of the two alone; one that is in both, but in another branch, at another obstacle or
// with other friction, counts twice.
int NumDifferences(const ContactRecords& one, const ContactRecords& other);

}  // namespace clothid

#endif  // CLOTHID_SIM_CONTACT_CONTACT_SET_H_

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
  std::vector<PairContact> pairs;  // of the cloth with itself, ascending

  bool empty() const { return nodes.empty() && pairs.empty(); }
};

// Of a ContactSet, in its order.
struct ContactRecords {
  std::vector<ContactRecord> nodes = {};
  std::vector<PairContactRecord> pairs = {};

  bool empty() const { return nodes.empty() && pairs.empty(); }
  std::size_t bytes() const {
    return nodes.capacity() * sizeof(ContactRecord) + pairs.capacity() * sizeof(PairContactRecord);
  }
};

ContactRecords RecordContacts(const ContactSet& contacts);

// Whether the same contacts are in the same branches.
bool HaveSameBranches(const ContactRecords& one, const ContactRecords& other);

}  // namespace clothid

#endif  // CLOTHID_SIM_CONTACT_CONTACT_SET_H_

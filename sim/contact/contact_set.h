// All contacts of a cloth in a solve, and what a rollout keeps of them.
#ifndef CLOTHID_SIM_CONTACT_CONTACT_SET_H_
#define CLOTHID_SIM_CONTACT_CONTACT_SET_H_

#include <array>
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
  // Whether thinning had left one of them out (pair_thinning.h): contacts may depend on each other, and the derivative
  // of the step is not certain.
  bool depend() const;
  // The nodes of the cloth that every contact with itself holds together, unused places -1.
  std::vector<std::array<int, 4>> TouchingNodes() const;
};

// That a record takes where every node is in contact with an obstacle and with the cloth, as far as the scene has them.
std::size_t BytesPerNode(bool has_obstacles, bool has_self_contact);

ContactRecords RecordContacts(const ContactSet& contacts);

// What has changed between the ends of two steps.
struct ContactChanges {
  int joined = 0, left = 0;         // nodes at obstacles
  int branches = 0, obstacles = 0;  // nodes that stayed, in another branch, or at another obstacle
  int pairs = 0;                    // of the cloth with itself: joined, left, or in another branch
};
ContactChanges CompareContacts(const ContactRecords& before, const ContactRecords& after);

// Of contacts that are in one of the two alone; one that is in both, but in another branch, at another obstacle or
// with other friction, counts twice.
int NumDifferences(const ContactRecords& one, const ContactRecords& other);

}  // namespace clothid

#endif  // CLOTHID_SIM_CONTACT_CONTACT_SET_H_

// All contacts of a cloth in a solve.
#ifndef CLOTHID_SIM_CONTACT_CONTACT_SET_H_
#define CLOTHID_SIM_CONTACT_CONTACT_SET_H_

#include <vector>

#include "sim/contact/contact.h"
#include "sim/contact/self_contact.h"

namespace clothid {

struct ContactSet {
  std::vector<Contact> nodes;      // with obstacles, ascending
  std::vector<PairContact> pairs;  // of the cloth with itself, ascending

  bool empty() const { return nodes.empty() && pairs.empty(); }
};

}  // namespace clothid

#endif  // CLOTHID_SIM_CONTACT_CONTACT_SET_H_

// Which node of each pair in contact follows the others.
#ifndef CLOTHID_SIM_CONTACT_PAIR_SLAVES_H_
#define CLOTHID_SIM_CONTACT_PAIR_SLAVES_H_

#include <vector>

#include "sim/contact/self_contact.h"

namespace clothid {

struct PairSlaves {
  std::vector<int> places;  // of the slave among the nodes of each pair; -1: none
  std::vector<int> order;   // of the pairs with slaves: one whose slave another one follows comes first
};

// No node is the slave of two pairs, none follows itself, directly or through others, and handles and the blocks `held`
// are no slaves. A slave has a |weight| of 0.05 at least. Vertices follow what they touch first, then the node with the
// largest |weight| that can follows in each of the others, in their order: thinning (pair_thinning.h) leaves pairs for
// which there are slaves, but those at obstacles and those that are taken back may find none. Pairs that leave have
// none. `num_blocks`: Nf.
PairSlaves ChooseSlaves(const std::vector<PairContact>& contacts, const std::vector<int>& held, int num_blocks);

}  // namespace clothid

#endif  // CLOTHID_SIM_CONTACT_PAIR_SLAVES_H_

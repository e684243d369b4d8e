#include "sim/contact/contact_set.h"

#include <algorithm>

namespace clothid {

ContactRecords RecordContacts(const ContactSet& contacts) {
  ContactRecords records;
  records.nodes.reserve(contacts.nodes.size());
  for (const Contact& contact : contacts.nodes) {
    records.nodes.push_back(
        {contact.candidate.node, contact.candidate.obstacle, contact.response.branch, contact.force});
  }
  records.pairs.reserve(contacts.pairs.size());
  for (const PairContact& contact : contacts.pairs) {
    records.pairs.push_back(
        {contact.candidate.features, contact.force, contact.response.branch, contact.candidate.has_friction});
  }
  return records;
}

bool HaveSameBranches(const ContactRecords& one, const ContactRecords& other) {
  return std::equal(one.nodes.begin(), one.nodes.end(), other.nodes.begin(), other.nodes.end(),
                    [](const ContactRecord& a, const ContactRecord& b) {
                      return a.node == b.node && a.obstacle == b.obstacle && a.branch == b.branch;
                    }) &&
         std::equal(one.pairs.begin(), one.pairs.end(), other.pairs.begin(), other.pairs.end(),
                    [](const PairContactRecord& a, const PairContactRecord& b) {
                      return a.features == b.features && a.branch == b.branch && a.has_friction == b.has_friction;
                    });
}

}  // namespace clothid

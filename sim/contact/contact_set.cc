#include "sim/contact/contact_set.h"

namespace clothid {
namespace {

bool AreAlike(const ContactRecord& a, const ContactRecord& b) {
  return a.branch == b.branch && a.obstacle == b.obstacle;
}
bool AreAlike(const PairContactRecord& a, const PairContactRecord& b) {
  return a.branch == b.branch && a.has_friction == b.has_friction;
}

}  // namespace

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

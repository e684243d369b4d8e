#include "sim/contact/pair_slaves.h"

#include <cmath>

namespace clothid {
namespace {

constexpr double kLeastWeight = 0.05;  // what the velocity of a slave is divided by
constexpr int kNone = -1, kHeld = -2;  // of a block: the slave of no pair, and not to be one

class Choice {
 public:
  Choice(const std::vector<PairContact>& contacts, const std::vector<int>& held, int num_blocks)
      : contacts_(contacts), pair_of_(num_blocks, kNone), last_visit_(num_blocks, 0) {
    slaves_.places.assign(contacts.size(), -1);
    for (const int block : held) pair_of_[block] = kHeld;
  }

  PairSlaves Run() {
    for (const bool vertices : {true, false}) {
      for (int c = 0; c < size(); ++c) {
        if (contacts_[c].response.branch != ContactBranch::kTakeOff && slaves_.places[c] < 0) Choose(c, vertices);
      }
    }
    is_ordered_.assign(contacts_.size(), false);
    for (int c = 0; c < size(); ++c) Order(c);
    return std::move(slaves_);
  }

 private:
  int size() const { return static_cast<int>(contacts_.size()); }
  int block(int c, int place) const { return contacts_[c].candidate.blocks[place]; }
  double size_of_weight(int c, int place) const { return std::abs(contacts_[c].candidate.geometry.weights[place]); }

  void Choose(int c, bool vertices) {
    if (vertices && contacts_[c].candidate.features.kind == PairKind::kEdgeEdge) return;
    int best = -1;
    for (int place = 0; place < (vertices ? 1 : 4); ++place) {
      if (best >= 0 && size_of_weight(c, place) <= size_of_weight(c, best)) continue;
      if (CanFollow(c, place)) best = place;
    }
    if (best < 0) return;
    slaves_.places[c] = best;
    pair_of_[block(c, best)] = c;
  }

  bool CanFollow(int c, int place) {
    const int slave = block(c, place);
    if (slave < 0 || pair_of_[slave] != kNone || size_of_weight(c, place) < kLeastWeight) return false;
    ++visit_;
    PushOthers(c, place);
    bool follows_itself = false;
    while (!stack_.empty()) {
      const int node = stack_.back();
      stack_.pop_back();
      if (node == slave) follows_itself = true;
      if (last_visit_[node] == visit_ || follows_itself) continue;
      last_visit_[node] = visit_;
      if (pair_of_[node] >= 0) PushOthers(pair_of_[node], slaves_.places[pair_of_[node]]);
    }
    return !follows_itself;
  }

  void PushOthers(int c, int place) {
    for (int i = 0; i < 4; ++i) {
      if (i != place && block(c, i) >= 0) stack_.push_back(block(c, i));
    }
  }

  void Order(int c) {
    if (slaves_.places[c] < 0 || is_ordered_[c]) return;
    is_ordered_[c] = true;
    for (int i = 0; i < 4; ++i) {
      if (i != slaves_.places[c] && block(c, i) >= 0 && pair_of_[block(c, i)] >= 0) Order(pair_of_[block(c, i)]);
    }
    slaves_.order.push_back(c);
  }

  const std::vector<PairContact>& contacts_;
  PairSlaves slaves_;
  std::vector<int> pair_of_;  // of which a block is the slave
  std::vector<int> last_visit_, stack_;
  int visit_ = 0;
  std::vector<bool> is_ordered_;
};

}  // namespace

PairSlaves ChooseSlaves(const std::vector<PairContact>& contacts, const std::vector<int>& held, int num_blocks) {
  return Choice(contacts, held, num_blocks).Run();
}

}  // namespace clothid

#include "sim/contact/pair_thinning.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <functional>
#include <numeric>
#include <queue>
#include <tuple>
#include <utility>

namespace clothid {
namespace {

using Eigen::Vector3d;

constexpr double kLeastSlaveWeight = 0.05;  // what a row is divided by, to find where its slave is
constexpr double kSizesPerOctave = 2.0;     // of edges that count as different

// When a pair's turn comes among those of equal gap.
enum class Turn : char { kContinues, kNew, kAgainst, kEdges, kOtherSlave, kNever };

// A node of a pair, by its place in it.
struct Seat {
  int pair = -1;
  int place = 0;
};

bool IsInFirst(PairKind kind, int place) { return place < (kind == PairKind::kEdgeEdge ? 2 : 1); }

class Thinning {
 public:
  Thinning(const std::vector<ThinningPair>& pairs, const std::vector<bool>& can_follow,
           const std::vector<int>& follow_order, double tie)
      : pairs_(pairs),
        can_follow_(can_follow),
        follow_order_(follow_order),
        slave_place_(pairs.size(), -1),
        is_decided_(pairs.size(), false),
        is_open_(pairs.size(), false),
        followed_(can_follow.size()),
        num_slaves_(can_follow.size(), 0),
        last_visit_(can_follow.size(), 0) {
    CollectIncident();
    Sort(tie);
  }

  ThinnedPairs Run() {
    for (std::size_t begin = 0, end = 0; begin < order_.size(); begin = end) {
      while (end < order_.size() && level_[end] == level_[begin]) is_open_[order_[end++]] = true;
      for (std::size_t i = begin; i < end; ++i) Push(order_[i]);
      while (!queue_.empty()) {
        const auto [turn, rank] = queue_.top();
        queue_.pop();
        if (!is_decided_[order_[rank]]) Decide(order_[rank], turn);
      }
    }
    for (std::size_t i = 0; i < pairs_.size(); ++i) {
      if (slave_place_[i] < 0) thinned_.rejected.push_back(static_cast<int>(i));
    }
    return std::move(thinned_);
  }

 private:
  void Sort(double tie) {
    std::vector<double> levels;
    std::vector<int> seeds;
    for (std::size_t i = 0; i < pairs_.size(); ++i) {
      order_.push_back(static_cast<int>(i));
      levels.push_back(std::max(0.0, std::round(pairs_[i].gap / tie)));
      seeds.push_back(FirstToFollow(pairs_[i].features));
    }
    const auto key = [&](int i) { return std::tie(levels[i], seeds[i], pairs_[i].gap, pairs_[i].features); };
    std::sort(order_.begin(), order_.end(), [&](int a, int b) { return key(a) < key(b); });
    rank_.resize(order_.size());
    for (std::size_t i = 0; i < order_.size(); ++i) {
      rank_[order_[i]] = static_cast<int>(i);
      level_.push_back(levels[order_[i]]);
    }
  }

  // The place of its vertex in the order.
  int FirstToFollow(const PairFeatures& features) const {
    const int place = PlaceInOrder(features.nodes[0]);
    return features.kind == PairKind::kVertexVertex ? std::min(place, PlaceInOrder(features.nodes[1])) : place;
  }

  int PlaceInOrder(int node) const { return follow_order_.empty() ? node : follow_order_[node]; }

  void CollectIncident() {
    first_incident_.assign(can_follow_.size() + 1, 0);
    for (const ThinningPair& pair : pairs_) {
      for (int k = 0; k < pair.features.num_nodes(); ++k) ++first_incident_[pair.features.nodes[k] + 1];
    }
    std::partial_sum(first_incident_.begin(), first_incident_.end(), first_incident_.begin());
    incident_.resize(first_incident_.back());
    std::vector<int> next(first_incident_.begin(), first_incident_.end() - 1);
    for (int i = 0; i < static_cast<int>(pairs_.size()); ++i) {
      const PairFeatures& features = pairs_[i].features;
      for (int k = 0; k < features.num_nodes(); ++k) incident_[next[features.nodes[k]]++] = {i, k};
    }
  }

  bool CanFollow(int node) const { return can_follow_[node] && followed_[node].pair < 0; }

  // From a node of a pair towards the other feature.
  Vector3d Across(const Seat& seat) const {
    const auto& [features, geometry, gap] = pairs_[seat.pair];
    return IsInFirst(features.kind, seat.place) ? -geometry.normal : geometry.normal;
  }

  // Whether a slave of `node` lies on the side of `direction`.
  bool IsFollowedFrom(int node, const Vector3d& direction) const {
    if (num_slaves_[node] == 0) return false;
    for (int i = first_incident_[node]; i < first_incident_[node + 1]; ++i) {
      const Seat& seat = incident_[i];
      if (slave_place_[seat.pair] < 0) continue;
      const PairKind kind = pairs_[seat.pair].features.kind;
      const bool is_across = IsInFirst(kind, seat.place) != IsInFirst(kind, slave_place_[seat.pair]);
      if (is_across && Across(seat).dot(direction) > 0.0) return true;
    }
    return false;
  }

  bool FollowsTowards(int node, const Vector3d& direction) const {
    return followed_[node].pair >= 0 && Across(followed_[node]).dot(direction) > 0.0;
  }

  // With the vertex at `place` as the slave.
  Turn TurnOf(int pair, int place) const {
    const PairFeatures& features = pairs_[pair].features;
    const int vertex = features.nodes[place];
    if (!CanFollow(vertex)) return Turn::kOtherSlave;
    const Vector3d across = Across({pair, place});
    if (IsFollowedFrom(vertex, across)) return Turn::kNever;
    Turn turn = Turn::kNew;
    for (int k = 0; k < features.num_nodes(); ++k) {
      if (k == place) continue;
      if (FollowsTowards(features.nodes[k], -across)) return Turn::kAgainst;
      if (IsFollowedFrom(features.nodes[k], -across)) turn = Turn::kContinues;
    }
    return turn;
  }

  Turn TurnOf(int pair) const {
    const PairKind kind = pairs_[pair].features.kind;
    if (kind == PairKind::kEdgeEdge) return Turn::kEdges;
    if (kind == PairKind::kVertexVertex) return std::min(TurnOf(pair, 0), TurnOf(pair, 1));
    return TurnOf(pair, 0);
  }

  void Push(int pair) { queue_.emplace(TurnOf(pair), rank_[pair]); }

  void Decide(int pair, Turn turn) {
    const Turn now = TurnOf(pair);
    if (now > turn) return Push(pair);
    is_decided_[pair] = true;
    if (now == Turn::kNever) return;
    if (now >= Turn::kEdges) return AcceptByWeight(pair);
    const auto& [kind, nodes] = pairs_[pair].features;
    std::array<int, 2> places = {0, kind == PairKind::kVertexVertex ? 1 : 0};
    if (PlaceInOrder(nodes[places[1]]) < PlaceInOrder(nodes[places[0]])) std::swap(places[0], places[1]);
    for (const int place : places) {
      if (TurnOf(pair, place) == now && TryAccept({pair, place})) return;
    }
  }

  void AcceptByWeight(int pair) {
    const Eigen::Vector4d weights = pairs_[pair].geometry.weights.cwiseAbs();
    std::array<int, 4> places = {0, 1, 2, 3};
    std::stable_sort(places.begin(), places.end(), [&](int a, int b) { return weights[a] > weights[b]; });
    for (const int place : places) {
      if (!(weights[place] > kLeastSlaveWeight)) return;
      if (CanFollow(pairs_[pair].features.nodes[place]) && TryAccept({pair, place})) return;
    }
  }

  // Does nothing where the slave would follow itself by way of others.
  bool TryAccept(const Seat& seat) {
    const PairFeatures& features = pairs_[seat.pair].features;
    const int slave = features.nodes[seat.place];
    if (num_slaves_[slave] > 0 && LeadTo(seat, slave)) return false;
    slave_place_[seat.pair] = seat.place;
    followed_[slave] = seat;
    thinned_.accepted.push_back({seat.pair, slave});
    for (int k = 0; k < features.num_nodes(); ++k) {
      if (k != seat.place) ++num_slaves_[features.nodes[k]];
    }
    for (int k = 0; k < features.num_nodes(); ++k) {
      if (k != seat.place) PushContinuing(features.nodes[k]);
    }
    return true;
  }

  void PushContinuing(int node) {
    for (int i = first_incident_[node]; i < first_incident_[node + 1]; ++i) {
      const int pair = incident_[i].pair;
      if (is_open_[pair] && !is_decided_[pair] && TurnOf(pair) == Turn::kContinues) Push(pair);
    }
  }

  // Whether a way leads from the nodes that `slave` would follow to itself.
  bool LeadTo(const Seat& seat, int slave) {
    ++visit_;
    stack_.clear();
    const auto add_others = [this](const Seat& of) {
      const PairFeatures& features = pairs_[of.pair].features;
      for (int k = 0; k < features.num_nodes(); ++k) {
        const int node = features.nodes[k];
        if (k == of.place || last_visit_[node] == visit_) continue;
        last_visit_[node] = visit_;
        stack_.push_back(node);
      }
    };
    add_others(seat);
    while (!stack_.empty()) {
      const int node = stack_.back();
      stack_.pop_back();
      if (node == slave) return true;
      if (followed_[node].pair >= 0) add_others(followed_[node]);
    }
    return false;
  }

  const std::vector<ThinningPair>& pairs_;
  const std::vector<bool>& can_follow_;
  const std::vector<int>& follow_order_;

  std::vector<int> order_, rank_;    // [P] pairs in their order, and where a pair is among them
  std::vector<double> level_;        // [P] of order_: the multiple of `tie`
  std::vector<Seat> incident_;       // of node 0, of node 1, ...
  std::vector<int> first_incident_;  // [N + 1] where these begin

  std::vector<int> slave_place_;  // [P] -1: not accepted
  std::vector<bool> is_decided_;  // [P]
  std::vector<bool> is_open_;     // [P] of this level or an earlier one
  std::vector<Seat> followed_;    // [N] where a node is the slave; pair -1: nowhere
  std::vector<int> num_slaves_;   // [N]
  ThinnedPairs thinned_;

  using Entry = std::pair<Turn, int>;  // when, and rank_
  std::priority_queue<Entry, std::vector<Entry>, std::greater<Entry>> queue_;

  int visit_ = 0;
  std::vector<int> last_visit_, stack_;
};

}  // namespace

std::vector<int> FollowOrder(const Mesh& mesh) {
  std::vector<double> lengths(mesh.num_nodes(), 0.0), counts(mesh.num_nodes(), 0.0);
  for (int f = 0; f < mesh.num_faces(); ++f) {
    for (int side = 0; side < 3; ++side) {
      const double length = RestLength(mesh, f, side);
      for (const int node : {mesh.faces(side, f), mesh.faces((side + 1) % 3, f)}) {
        lengths[node] += length;
        counts[node] += 1.0;
      }
    }
  }
  for (std::size_t i = 0; i < lengths.size(); ++i) {
    lengths[i] = std::round(kSizesPerOctave * std::log2(lengths[i] / counts[i]));
  }
  std::vector<int> nodes(mesh.num_nodes()), order(mesh.num_nodes());
  std::iota(nodes.begin(), nodes.end(), 0);
  std::stable_sort(nodes.begin(), nodes.end(), [&](int a, int b) { return lengths[a] < lengths[b]; });
  for (std::size_t i = 0; i < nodes.size(); ++i) order[nodes[i]] = static_cast<int>(i);
  return order;
}

ThinnedPairs ThinPairs(const std::vector<ThinningPair>& pairs, const std::vector<bool>& can_follow, double tie,
                       const std::vector<int>& follow_order) {
  return Thinning(pairs, can_follow, follow_order, tie).Run();
}

}  // namespace clothid

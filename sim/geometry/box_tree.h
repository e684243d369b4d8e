// Which of many boxes overlap a box: a tree that is built once and follows its items as they move.
#ifndef CLOTHID_SIM_GEOMETRY_BOX_TREE_H_
#define CLOTHID_SIM_GEOMETRY_BOX_TREE_H_

#include <Eigen/Core>
#include <Eigen/Geometry>
#include <algorithm>
#include <vector>

namespace clothid {

// Axis-aligned boxes (Eigen::AlignedBox3d; an empty one overlaps nothing), halved at the median of their centres along
// the longest side of the box of the centres, down to a few items. Building costs O(n log n), `Refit` O(n). Items that
// were near each other when the tree was built should stay so, as neighbours in a cloth do: otherwise queries are slow,
// not wrong. Queries allocate nothing and may run in several threads.
class BoxTree {
 public:
  using Box = Eigen::AlignedBox3d;

  BoxTree() = default;
  explicit BoxTree(const std::vector<Box>& boxes);  // of the items 0 .. n - 1

  // Where the items are now; as many as the tree was built of.
  void Refit(const std::vector<Box>& boxes);

  // Calls visit(item) for every item whose box overlaps or touches `box`, always in the order of the tree. Leaves out
  // what is below a node of the tree for which descend(node) is false; nodes are numbered from 0, the root.
  template <class Descend, class Visitor>
  void VisitOverlaps(const Box& box, Descend&& descend, Visitor&& visit) const;
  template <class Visitor>
  void VisitOverlaps(const Box& box, Visitor&& visit) const {
    VisitOverlaps(
        box, [](int) { return true; }, visit);
  }

  // Calls visit(a, b), a < b, once for every two items whose boxes overlap or touch.
  template <class Visitor>
  void VisitPairs(Visitor&& visit) const;

  // What holds for all items below a node, from values of items [n]: join(&value, other) adds another to `value`, which
  // starts as Value().
  template <class Value, class Join>
  void Gather(const std::vector<Value>& of_items, Join&& join, std::vector<Value>* of_nodes) const;

  int num_items() const { return static_cast<int>(items_.size()); }

 private:
  // In the order of a walk from the root, left children first: the left child of a node that is no leaf is the next
  // one, and `after` is the first node beyond its part of the tree.
  struct Node {
    Box box;
    int after = 0;
    int first_item = 0, last_item = 0;  // first <= i < last in items_; none but in a leaf
  };

  void Build(const std::vector<Eigen::Vector3d>& centres, int first_item, int last_item);

  static bool Overlaps(const Box& a, const Box& b) {
    return (a.min().array() <= b.max().array()).all() && (b.min().array() <= a.max().array()).all();
  }

  std::vector<Node> nodes_;
  std::vector<int> items_;  // [n]
  std::vector<Box> boxes_;  // [n] in the order of items_
};

template <class Descend, class Visitor>
void BoxTree::VisitOverlaps(const Box& box, Descend&& descend, Visitor&& visit) const {
  const int num_nodes = static_cast<int>(nodes_.size());
  for (int i = 0; i < num_nodes;) {
    const Node& node = nodes_[i];
    if (!Overlaps(node.box, box) || !descend(i)) {
      i = node.after;
      continue;
    }
    for (int k = node.first_item; k < node.last_item; ++k) {
      if (Overlaps(boxes_[k], box)) visit(items_[k]);
    }
    ++i;
  }
}

// Every leaf with itself and with those after it.
template <class Visitor>
void BoxTree::VisitPairs(Visitor&& visit) const {
  const auto visit_pair = [&](int k, int l) {
    if (Overlaps(boxes_[k], boxes_[l])) visit(std::min(items_[k], items_[l]), std::max(items_[k], items_[l]));
  };
  const int num_nodes = static_cast<int>(nodes_.size());
  for (const Node& leaf : nodes_) {
    if (leaf.first_item == leaf.last_item) continue;
    for (int k = leaf.first_item; k < leaf.last_item; ++k) {
      for (int l = k + 1; l < leaf.last_item; ++l) visit_pair(k, l);
    }
    for (int i = leaf.after; i < num_nodes;) {
      const Node& node = nodes_[i];
      if (!Overlaps(node.box, leaf.box)) {
        i = node.after;
        continue;
      }
      for (int k = leaf.first_item; k < leaf.last_item; ++k) {
        for (int l = node.first_item; l < node.last_item; ++l) visit_pair(k, l);
      }
      ++i;
    }
  }
}

template <class Value, class Join>
void BoxTree::Gather(const std::vector<Value>& of_items, Join&& join, std::vector<Value>* of_nodes) const {
  of_nodes->assign(nodes_.size(), Value());
  for (int i = static_cast<int>(nodes_.size()) - 1; i >= 0; --i) {
    Value* value = &(*of_nodes)[i];
    for (int k = nodes_[i].first_item; k < nodes_[i].last_item; ++k) join(value, of_items[items_[k]]);
    for (int child = i + 1; child < nodes_[i].after; child = nodes_[child].after) join(value, (*of_nodes)[child]);
  }
}

}  // namespace clothid

#endif  // CLOTHID_SIM_GEOMETRY_BOX_TREE_H_

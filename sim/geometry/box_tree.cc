#include "sim/geometry/box_tree.h"

#include <algorithm>
#include <numeric>

namespace clothid {
namespace {

constexpr int kItemsPerLeaf = 4;

}  // namespace

BoxTree::BoxTree(const std::vector<Box>& boxes) : items_(boxes.size()), boxes_(boxes.size()) {
  std::vector<Eigen::Vector3d> centres;
  centres.reserve(boxes.size());
  for (const Box& box : boxes) centres.push_back(box.center());
  std::iota(items_.begin(), items_.end(), 0);
  if (!boxes.empty()) Build(centres, 0, num_items());
  Refit(boxes);
}

void BoxTree::Build(const std::vector<Eigen::Vector3d>& centres, int first_item, int last_item) {
  const std::size_t self = nodes_.size();
  nodes_.emplace_back();
  const auto first = items_.begin() + first_item, last = items_.begin() + last_item;
  if (last_item - first_item <= kItemsPerLeaf) {
    std::sort(first, last);
    nodes_[self].first_item = first_item;
    nodes_[self].last_item = last_item;
  } else {
    Box span;
    for (auto item = first; item != last; ++item) span.extend(centres[*item]);
    Eigen::Index axis = 0;
    span.sizes().maxCoeff(&axis);
    const int middle = first_item + (last_item - first_item) / 2;
    // Equal places are ordered by item, so that the halves are the same everywhere.
    std::nth_element(first, items_.begin() + middle, last, [&](int a, int b) {
      return centres[a][axis] != centres[b][axis] ? centres[a][axis] < centres[b][axis] : a < b;
    });
    Build(centres, first_item, middle);
    Build(centres, middle, last_item);
  }
  nodes_[self].after = static_cast<int>(nodes_.size());
}

void BoxTree::Refit(const std::vector<Box>& boxes) {
  for (std::size_t k = 0; k < items_.size(); ++k) boxes_[k] = boxes[items_[k]];
  for (int i = static_cast<int>(nodes_.size()) - 1; i >= 0; --i) {
    Node& node = nodes_[i];
    node.box.setEmpty();
    for (int k = node.first_item; k < node.last_item; ++k) node.box.extend(boxes_[k]);
    for (int child = i + 1; child < node.after; child = nodes_[child].after) node.box.extend(nodes_[child].box);
  }
}

}  // namespace clothid

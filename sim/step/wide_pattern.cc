#include "sim/step/wide_pattern.h"

#include <algorithm>

#include "sim/matrix/fill_reducing_order.h"

namespace clothid {
namespace {

// Times the operations of a factor where the order was made; above, a new order saves more than it costs.
constexpr double kMostFlops = 1.05;

using Neighbours = std::vector<std::vector<int>>;

Neighbours NeighboursOf(const BlockPattern& pattern) {
  Neighbours neighbours(pattern.num_blocks());
  for (int i = 0; i < pattern.num_blocks(); ++i) {
    neighbours[i].assign(pattern.rows_begin(i), pattern.rows_begin(i) + pattern.num_rows(i));
  }
  return neighbours;
}

void AddCliques(const std::vector<std::array<int, 4>>& cliques, Neighbours* neighbours) {
  for (const std::array<int, 4>& clique : cliques) {
    for (const int i : clique) {
      for (const int j : clique) {
        if (i >= 0 && j >= 0 && i != j) (*neighbours)[i].push_back(j);
      }
    }
  }
}

// Without repetitions and the diagonal.
void Tidy(Neighbours* neighbours) {
  for (std::size_t i = 0; i < neighbours->size(); ++i) {
    std::vector<int>& row = (*neighbours)[i];
    std::sort(row.begin(), row.end());
    row.erase(std::unique(row.begin(), row.end()), row.end());
    row.erase(std::remove(row.begin(), row.end(), static_cast<int>(i)), row.end());
  }
}

Neighbours Renumbered(const Neighbours& neighbours, const std::vector<int>& places) {
  Neighbours result(neighbours.size());
  for (std::size_t i = 0; i < neighbours.size(); ++i) {
    for (const int j : neighbours[i]) result[places[i]].push_back(places[j]);
  }
  return result;
}

std::vector<int> Inverse(const std::vector<int>& permutation) {
  std::vector<int> inverse(permutation.size());
  for (std::size_t k = 0; k < permutation.size(); ++k) inverse[permutation[k]] = static_cast<int>(k);
  return inverse;
}

// The order in which blocks have `places`, postordered.
std::vector<int> Postordered(const Neighbours& neighbours, const std::vector<int>& places) {
  const std::vector<int> order = Inverse(places);
  std::vector<int> postorder = Postorder(Renumbered(neighbours, places));
  for (int& block : postorder) block = order[block];
  return postorder;
}

}  // namespace

WidePattern::WidePattern(const BlockPattern& pattern, const std::vector<std::array<int, 4>>& cliques,
                         const WidePattern* before) {
  Neighbours neighbours = NeighboursOf(pattern);
  AddCliques(cliques, &neighbours);
  Tidy(&neighbours);
  pattern_ = std::make_shared<const BlockPattern>(neighbours);
  std::shared_ptr<const BlockPattern> ordered;
  if (before != nullptr) {
    ordered = Analyze(neighbours, Postordered(neighbours, before->places_));
    first_flops_ = before->first_flops_;
  }
  if (before == nullptr || cholesky_->num_flops() > kMostFlops * first_flops_) {
    ordered = Analyze(neighbours, FillReducingOrder(neighbours));
    first_flops_ = cholesky_->num_flops();
  }
  MapValues(*ordered);
}

std::shared_ptr<const BlockPattern> WidePattern::Analyze(const Neighbours& neighbours, const std::vector<int>& order) {
  places_ = Inverse(order);
  auto ordered = std::make_shared<const BlockPattern>(Renumbered(neighbours, places_));
  cholesky_ = std::make_unique<CholeskySolver>(ordered);
  return ordered;
}

void WidePattern::MapValues(const BlockPattern& ordered) {
  ordered_.resize(pattern_->num_values());
  for (int column = 0; column < pattern_->num_blocks(); ++column) {
    for (int k = 0; k < pattern_->num_rows(column); ++k) {
      const BlockPosition from = pattern_->Position(column, k);
      const BlockPosition to = ordered.Find(places_[pattern_->rows_begin(column)[k]], places_[column]);
      for (int j = 0; j < 3; ++j) {
        for (int i = 0; i < 3; ++i) ordered_[from.start + j * from.stride + i] = to.start + j * to.stride + i;
      }
    }
  }
}

bool WidePattern::Covers(const std::vector<std::array<int, 4>>& cliques) const {
  const auto has = [this](int i, int j) {
    const int* const rows = pattern_->rows_begin(j);
    return std::binary_search(rows, rows + pattern_->num_rows(j), i);
  };
  return std::all_of(cliques.begin(), cliques.end(), [&](const std::array<int, 4>& clique) {
    for (const int i : clique) {
      for (const int j : clique) {
        if (i >= 0 && j >= 0 && !has(i, j)) return false;
      }
    }
    return true;
  });
}

BlockMatrix WidePattern::Widened(const BlockMatrix& matrix) const {
  BlockMatrix wide(pattern_);
  const BlockPattern& narrow = matrix.pattern();
  for (int column = 0; column < narrow.num_blocks(); ++column) {
    const int* wide_row = pattern_->rows_begin(column);
    for (int k = 0, wide_k = 0; k < narrow.num_rows(column); ++k) {
      while (wide_row[wide_k] != narrow.rows_begin(column)[k]) ++wide_k;
      wide.block(pattern_->Position(column, wide_k)) = matrix.block(narrow.Position(column, k));
    }
  }
  return wide;
}

std::shared_ptr<const CholeskyFactor> WidePattern::Factor(const Eigen::VectorXd& values, ThreadTeam* team) const {
  Eigen::VectorXd ordered(values.size());
  ordered(ordered_) = values;
  return cholesky_->Factor(ordered, team);
}

Eigen::MatrixXd WidePattern::Solve(const CholeskyFactor& factor, const Eigen::MatrixXd& right, ThreadTeam* team) const {
  Eigen::MatrixXd ordered(right.rows(), right.cols()), result(right.rows(), right.cols());
  for (std::size_t i = 0; i < places_.size(); ++i) {
    ordered.middleRows<3>(3 * places_[i]) = right.middleRows<3>(3 * static_cast<Eigen::Index>(i));
  }
  factor.Solve(ordered, &ordered, team);
  for (std::size_t i = 0; i < places_.size(); ++i) {
    result.middleRows<3>(3 * static_cast<Eigen::Index>(i)) = ordered.middleRows<3>(3 * places_[i]);
  }
  return result;
}

// Both patterns and the way from one to the other have an index per value.
std::size_t WidePattern::bytes() const {
  return sizeof(int) * (3 * static_cast<std::size_t>(pattern_->num_values()) + places_.size());
}

}  // namespace clothid

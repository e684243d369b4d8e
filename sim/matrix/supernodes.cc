#include "sim/matrix/supernodes.h"

#include <algorithm>

#include "sim/matrix/blas_guard.h"
#include "sim/matrix/cholmod_analysis.h"

namespace clothid {
namespace {

constexpr double kBranchShare = 0.125;  // of the entries of L: the most that a branch has
constexpr int kTrunkColumns = 16;       // of a supernode of the trunk: those that wait for it wait for so many

// A supernode and its parent become one where both together have fewer columns than the first, or fewer than the second
// and a smaller share of zeros than the first, and so on.
constexpr std::size_t kRelaxedColumns[3] = {2, 6, 16};
constexpr double kRelaxedZeros[3] = {0.8, 0.1, 0.05};

void AskForSupernodes(cholmod_common* common) {
  common->postorder = 0;
  common->supernodal = CHOLMOD_SUPERNODAL;
  for (int i = 0; i < 3; ++i) {
    common->nrelax[i] = kRelaxedColumns[i];
    common->zrelax[i] = kRelaxedZeros[i];
  }
}

}  // namespace

Supernodes::Supernodes(const BlockPattern& pattern, double branched_entries) {
  const int n = pattern.num_blocks();
  columns = row_starts = update_starts = {0};
  value_starts = {0};
  if (n == 0) return;  // for CHOLMOD no matrix
  const BlasGuard guard;
  CholmodAnalysis analysis(CHOLMOD_NATURAL);
  AskForSupernodes(&analysis.common());
  const cholmod_factor& factor = analysis.Analyze(pattern);
  const auto* const super = static_cast<const int*>(factor.super);
  const auto* const starts = static_cast<const int*>(factor.pi);
  columns.assign(super, super + factor.nsuper + 1);
  row_starts.assign(starts, starts + factor.nsuper + 1);
  rows.assign(static_cast<const int*>(factor.s), static_cast<const int*>(factor.s) + row_starts.back());
  for (int column = 0; column < n; ++column) {
    const double count = 3.0 * static_cast<const int*>(factor.ColCount)[column];
    for (const double entries : {count, count - 1.0, count - 2.0}) {
      num_entries += entries;
      num_flops += entries * entries;
    }
  }
  if (num_entries >= branched_entries && FindBranches()) {
    SplitTrunk();
    NumberBranchRows();
  }
  for (int s = 0; s < size(); ++s) {
    const std::size_t num_values = 9 * static_cast<std::size_t>(num_rows(s)) * num_columns(s);
    value_starts.push_back(value_starts.back() + num_values + kSpareValues);
    max_rows = std::max(max_rows, num_rows(s));
  }
  ListUpdates();
}

std::vector<int> Supernodes::SupernodesOfColumns() const {
  std::vector<int> supernodes(columns.back());
  for (int s = 0; s < size(); ++s) std::fill_n(supernodes.begin() + columns[s], num_columns(s), s);
  return supernodes;
}

// In ascending order, so that whatever is below a supernode is known before it.
std::vector<Supernodes::Subtree> Supernodes::Subtrees() const {
  const std::vector<int> supernode_of = SupernodesOfColumns();
  std::vector<Subtree> subtrees;
  for (int s = 0; s < size(); ++s) subtrees.push_back({s, static_cast<double>(num_rows(s)) * num_columns(s)});
  for (int s = 0; s < size(); ++s) {
    if (num_rows(s) == num_columns(s)) continue;  // a root
    Subtree& parent = subtrees[supernode_of[rows[row_starts[s] + num_columns(s)]]];
    parent.first = std::min(parent.first, subtrees[s].first);
    parent.entries += subtrees[s].entries;
  }
  return subtrees;
}

// From the last supernode down: what has more than its share of L in its subtree belongs to the trunk, any other one
// with its subtree to a branch. False: there are none, as subtrees are no ranges here, or there is but one.
bool Supernodes::FindBranches() {
  const std::vector<Subtree> subtrees = Subtrees();
  double share = 0.0;
  for (int s = 0; s < size(); ++s) share += kBranchShare * num_rows(s) * num_columns(s);
  std::vector<Range> found;
  double entries = 0.0;  // of the last one
  std::vector<int> others;
  for (int s = size() - 1; s >= 0;) {
    const Subtree& subtree = subtrees[s];
    if (subtree.entries > share) {
      others.push_back(s--);
      continue;
    }
    const auto is_within = [&](const Subtree& t) { return t.first >= subtree.first && t.entries <= share; };
    if (!std::all_of(subtrees.begin() + subtree.first, subtrees.begin() + s, is_within)) return false;
    if (!found.empty() && found.back().first == s + 1 && entries + subtree.entries <= share) {
      found.back().first = subtree.first;
      entries += subtree.entries;
    } else {
      found.push_back({subtree.first, s + 1});
      entries = subtree.entries;
    }
    s = subtree.first - 1;
  }
  if (found.size() < 2) return false;
  branches.assign(found.rbegin(), found.rend());
  trunk.assign(others.rbegin(), others.rend());
  return true;
}

// Supernodes of the trunk become such of few columns.
void Supernodes::SplitTrunk() {
  const Supernodes whole = *this;
  columns = row_starts = {0};
  rows.clear();
  trunk.clear();
  std::vector<int> firsts;  // of what a supernode became
  auto next_of_trunk = whole.trunk.begin();
  for (int s = 0; s < whole.size(); ++s) {
    firsts.push_back(size());
    const bool is_trunk = next_of_trunk != whole.trunk.end() && *next_of_trunk == s;
    if (is_trunk) ++next_of_trunk;
    const int most = is_trunk ? kTrunkColumns : whole.num_columns(s);
    for (int first = 0; first < whole.num_columns(s); first += most) {
      if (is_trunk) trunk.push_back(size());
      columns.push_back(whole.columns[s] + std::min(first + most, whole.num_columns(s)));
      rows.insert(rows.end(), whole.rows.begin() + whole.row_starts[s] + first,
                  whole.rows.begin() + whole.row_starts[s + 1]);
      row_starts.push_back(static_cast<int>(rows.size()));
    }
  }
  firsts.push_back(size());
  for (Range& branch : branches) branch = {firsts[branch.first], firsts[branch.last]};
}

void Supernodes::NumberBranchRows() {
  std::vector<int> places(columns.back(), -1);  // among the trunk_columns
  for (const int s : trunk) {
    for (int column = columns[s]; column < columns[s + 1]; ++column) {
      places[column] = static_cast<int>(trunk_columns.size());
      trunk_columns.push_back(column);
    }
  }
  branch_rows = rows;
  int offset = columns.back();
  for (const Range& branch : branches) {
    for (int i = row_starts[branch.first]; i < row_starts[branch.last]; ++i) {
      if (places[rows[i]] >= 0) branch_rows[i] = offset + places[rows[i]];
    }
    offset += static_cast<int>(trunk_columns.size());
  }
}

void Supernodes::ListUpdates() {
  const std::vector<int> supernode_of = SupernodesOfColumns();
  std::vector<std::vector<Update>> of(size());
  for (int s = 0; s < size(); ++s) {
    const int* const own = rows.data() + row_starts[s];
    for (int first = num_columns(s), last; first < num_rows(s); first = last) {
      const int target = supernode_of[own[first]];
      for (last = first + 1; last < num_rows(s) && supernode_of[own[last]] == target;) ++last;
      of[target].push_back({s, first, last});
    }
  }
  for (const std::vector<Update>& list : of) {
    updates.insert(updates.end(), list.begin(), list.end());
    update_starts.push_back(static_cast<int>(updates.size()));
  }
}

}  // namespace clothid

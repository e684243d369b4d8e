// Where the entries of a Cholesky factor L of a symmetric block matrix lie: the symbolic half of a factorisation.
//
// Neighbouring columns of L whose entries lie in nearly the same rows make a supernode, which is stored as one dense
// matrix: the arithmetic of a factorisation is that of small dense matrices.
#ifndef CLOTHID_SIM_MATRIX_SUPERNODES_H_
#define CLOTHID_SIM_MATRIX_SUPERNODES_H_

#include <cstddef>
#include <vector>

#include "sim/matrix/block_matrix.h"

namespace clothid {

// From so many entries of L on, threads that share its columns gain more than they cost.
inline constexpr double kBranchedEntries = 1 << 19;

// Behind the values of a supernode, for vector instructions, which read beyond the end: not what another thread writes.
inline constexpr int kSpareValues = 8;

// Internal to sim/matrix. Rows and columns count blocks of three scalars, in the order of the pattern.
struct Supernodes {
  // Analysed by CHOLMOD. With `branched_entries` of L or more it has branches, see below. Throws `std::runtime_error`
  // where the analysis runs out of memory.
  explicit Supernodes(const BlockPattern& pattern, double branched_entries = kBranchedEntries);

  // Rows `first` up to `last` of the supernode `source`, as it numbers them, are columns of another supernode, from
  // which the factorisation subtracts their products with all rows from `first` on.
  struct Update {
    int source, first, last;
  };

  // Supernodes first up to last.
  struct Range {
    int first, last;
  };

  int size() const { return static_cast<int>(columns.size()) - 1; }
  int num_columns(int s) const { return columns[s + 1] - columns[s]; }
  int num_rows(int s) const { return row_starts[s + 1] - row_starts[s]; }

  // Supernode s has the columns columns[s] up to columns[s + 1] and, ascending, the rows rows[row_starts[s]] up to
  // rows[row_starts[s + 1]], of which the first are its columns. Its values are a matrix
  // [3 num_rows x 3 num_columns] by columns, which starts at value_starts[s]; kSpareValues follow.
  std::vector<int> columns, row_starts, rows;
  std::vector<std::size_t> value_starts;
  // The updates of supernode s, by ascending sources, are updates[update_starts[s]] up to updates[update_starts[s +
  // 1]].
  std::vector<int> update_starts;
  std::vector<Update> updates;
  int max_rows = 0;  // of a supernode

  // Parts that can be worked on side by side. A branch is a range of supernodes, subtrees of the elimination tree:
  // their updates come from the same branch. What is in none is the trunk, which has rows of all branches: the
  // supernodes `trunk`, ascending, of the columns `trunk_columns`. None, and neither is a trunk, where L is small or
  // the pattern comes in an order without subtrees.
  std::vector<Range> branches;
  std::vector<int> trunk, trunk_columns;
  // As `rows`, but in branch b the row trunk_columns[k] is num_blocks + b trunk_columns.size() + k, so that branches
  // need not write to the same place.
  std::vector<int> branch_rows;

  // Of a factorisation, by scalars and without the zeros that supernodes add: operations (an addition and a
  // multiplication are two) and entries of L.
  double num_flops = 0.0, num_entries = 0.0;

 private:
  // A supernode and all from which updates come to it, directly or not.
  struct Subtree {
    int first;       // of them
    double entries;  // of L, by blocks
  };
  std::vector<int> SupernodesOfColumns() const;
  std::vector<Subtree> Subtrees() const;
  bool FindBranches();
  void SplitTrunk();
  void NumberBranchRows();
  void ListUpdates();
};

}  // namespace clothid

#endif  // CLOTHID_SIM_MATRIX_SUPERNODES_H_

#include "sim/matrix/supernodal_factor.h"

#include <algorithm>
#include <atomic>
#include <memory>
#include <thread>
#include <vector>

#include "sim/base/thread_team.h"
#include "sim/matrix/supernode_kernels.h"

namespace clothid {
namespace {

// What a factorisation is about.
struct Matrices {
  const Supernodes& supernodes;
  const BlockPattern& pattern;
  const double* values;
  double* factor;
  SupernodeKernels kernels;
};

// Which supernodes are done, for threads that wait for them.
class Finished {
 public:
  explicit Finished(int num_supernodes) : done_(num_supernodes) {}

  void SetDone(int s) { done_[s].store(true, std::memory_order_release); }
  void Fail() { failed_.store(true, std::memory_order_relaxed); }
  bool failed() const { return failed_.load(std::memory_order_relaxed); }
  // False where the factorisation has failed.
  bool WaitFor(int s) const {
    while (!done_[s].load(std::memory_order_acquire)) {
      if (failed()) return false;
      std::this_thread::yield();
    }
    return true;
  }

 private:
  std::vector<std::atomic<bool>> done_;
  std::atomic<bool> failed_{false};
};

// What a thread works on, with scratch of its own.
class Worker {
 public:
  explicit Worker(const Matrices& matrices)
      : matrices_(matrices),
        supernodes_(matrices.supernodes),
        positions_(matrices.pattern.num_blocks()),
        targets_(3 * matrices.supernodes.max_rows) {}

  // Supernodes first up to last. False: not positive definite, or failed elsewhere.
  bool Factor(int first, int last, Finished* finished) {
    for (int s = first; s < last; ++s) {
      const SupernodePanel panel = PanelOf(s);
      Assemble(s, panel);
      for (int u = supernodes_.update_starts[s]; u < supernodes_.update_starts[s + 1]; ++u) {
        const Supernodes::Update& update = supernodes_.updates[u];
        if (!finished->WaitFor(update.source)) return false;
        Subtract(update, panel);
      }
      if (!matrices_.kernels.factor(panel)) return false;
      finished->SetDone(s);
    }
    return true;
  }

 private:
  SupernodePanel PanelOf(int s) const {
    return {matrices_.factor + supernodes_.value_starts[s], 3 * supernodes_.num_rows(s),
            3 * supernodes_.num_columns(s)};
  }

  // The columns of A, and where its rows are.
  void Assemble(int s, const SupernodePanel& panel) {
    const int* const rows = supernodes_.rows.data() + supernodes_.row_starts[s];
    for (int i = 0; i < supernodes_.num_rows(s); ++i) positions_[rows[i]] = i;
    std::fill_n(panel.values, static_cast<std::size_t>(panel.num_rows) * panel.num_columns, 0.0);
    double* to = panel.values;
    for (int column = supernodes_.columns[s]; column < supernodes_.columns[s + 1]; ++column) {
      const int* const a_rows = matrices_.pattern.rows_begin(column);
      const int num_rows = matrices_.pattern.num_rows(column);
      const int first = static_cast<int>(std::lower_bound(a_rows, a_rows + num_rows, column) - a_rows);
      const double* from = matrices_.values + matrices_.pattern.Position(column, 0).start;
      for (int c = 0; c < 3; ++c, to += panel.num_rows, from += 3 * static_cast<std::ptrdiff_t>(num_rows)) {
        for (int k = first; k < num_rows; ++k) std::copy_n(from + 3 * k, 3, to + 3 * positions_[a_rows[k]]);
      }
    }
  }

  void Subtract(const Supernodes::Update& update, const SupernodePanel& panel) {
    const SupernodePanel source = PanelOf(update.source);
    const int* const rows = supernodes_.rows.data() + supernodes_.row_starts[update.source];
    int* target = targets_.data();
    for (int i = update.first; i < supernodes_.num_rows(update.source); ++i, target += 3) {
      const int row = 3 * positions_[rows[i]];
      target[0] = row;
      target[1] = row + 1;
      target[2] = row + 2;
    }
    const SupernodeUpdate rows_of_source = {source.values + 3 * static_cast<std::ptrdiff_t>(update.first),
                                            source.num_rows,
                                            source.num_columns,
                                            3 * (update.last - update.first),
                                            source.num_rows - 3 * update.first,
                                            targets_.data()};
    matrices_.kernels.subtract(rows_of_source, panel, Scratch(ScratchSize(rows_of_source)));
  }

  // Of any content.
  double* Scratch(std::size_t size) {
    if (size > scratch_size_) {
      scratch_.reset(new double[size]);
      scratch_size_ = size;
    }
    return scratch_.get();
  }

  const Matrices& matrices_;
  const Supernodes& supernodes_;
  std::vector<int> positions_;  // of the rows of A in the supernode
  std::vector<int> targets_;    // of the rows of an update in the supernode, by scalars
  std::unique_ptr<double[]> scratch_;
  std::size_t scratch_size_ = 0;
};

// The branches, each a task, then the supernodes of the trunk. Threads take them in that order, so that whoever waits
// waits for a task that another thread is at.
bool FactorBranches(const Matrices& matrices, ThreadTeam* team) {
  const Supernodes& supernodes = matrices.supernodes;
  const int num_branches = static_cast<int>(supernodes.branches.size());
  const int num_tasks = num_branches + static_cast<int>(supernodes.trunk.size());
  Finished finished(supernodes.size());
  RunTasks(team, num_tasks, [&](int task) {
    if (finished.failed()) return;
    const int s = task < num_branches ? 0 : supernodes.trunk[task - num_branches];
    const auto [first, last] = task < num_branches ? supernodes.branches[task] : Supernodes::Range{s, s + 1};
    try {
      if (!Worker(matrices).Factor(first, last, &finished)) finished.Fail();
    } catch (...) {  // no memory: those that wait for it go home
      finished.Fail();
      throw;
    }
  });
  return !finished.failed();
}

}  // namespace

std::size_t NumFactorValues(const Supernodes& supernodes) { return supernodes.value_starts.back(); }

bool FactorSupernodes(const Supernodes& supernodes, const BlockPattern& pattern, const double* values, double* factor,
                      ThreadTeam* team, InstructionSet instructions) {
  const Matrices matrices{supernodes, pattern, values, factor, KernelsOf(instructions)};
  if (!supernodes.branches.empty() && team != nullptr) return FactorBranches(matrices, team);
  Finished finished(supernodes.size());
  return Worker(matrices).Factor(0, supernodes.size(), &finished);
}

}  // namespace clothid

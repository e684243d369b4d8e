#include "sim/matrix/supernodal_factor.h"

#include <algorithm>
#include <atomic>
#include <cmath>
#include <thread>
#include <vector>

#include "sim/base/thread_team.h"
#include "sim/matrix/lanes.h"

namespace clothid {
namespace {

// Columns of a tile, and its rows.
constexpr int kWidth = 6;
constexpr int kBlock = 3;
constexpr int kRows = 8;
static_assert(kRows <= kSpareValues);

// From so many products of columns with columns on, an update copies what it multiplies: far apart in a tall supernode,
// its numbers would be fetched anew for every strip of columns.
constexpr int kCopiedColumns = 2 * kWidth;
constexpr int kCopiedDepth = 24;
// How many numbers of a source are copied at a time: half of what a second cache has.
constexpr int kCopiedValues = 1 << 15;

// A supernode that is being made, or that is done: `num_rows` x `num_columns` scalars by columns.
struct Panel {
  double* values;
  int num_rows, num_columns;
};

// Rows of a supernode `source` that is done, from one that is a column of another supernode on: of `num_rows`
// the first `num_columns` are, and all are there at the rows `targets`.
struct Update {
  const double* source;
  std::ptrdiff_t stride;  // of its columns
  int depth;              // their number
  int num_columns, num_rows;
  const int* targets;
};

bool IsCopied(int num_columns, int depth) { return num_columns >= kCopiedColumns && depth >= kCopiedDepth; }

// The columns of a tile [kRows x kColumns].
template <typename Rows, int kColumns>
struct Tile {
  // Column j becomes the sum over k of a[., k] b[j, k], of two matrices by columns.
  CLOTHID_ALWAYS_INLINE void SetProducts(const double* a, std::ptrdiff_t a_stride, const double* b,
                                         std::ptrdiff_t b_stride, int depth) {
    CLOTHID_UNROLL
    for (int j = 0; j < kColumns; ++j) columns[j].SetZero();
    for (int k = 0; k < depth; ++k, a += a_stride, b += b_stride) {
      Rows rows;
      rows.Load(a);
      CLOTHID_UNROLL
      for (int j = 0; j < kColumns; ++j) columns[j].AddProduct(rows, b[j]);
    }
  }

  CLOTHID_ALWAYS_INLINE void SetDifferences(const Tile& products, const double* from, std::ptrdiff_t stride) {
    CLOTHID_UNROLL
    for (int j = 0; j < kColumns; ++j) {
      columns[j].Load(from + j * stride);
      columns[j].Subtract(products.columns[j]);
    }
  }

  // Its first `num_rows` rows.
  CLOTHID_ALWAYS_INLINE void Store(int num_rows, std::ptrdiff_t stride, double* to) const {
    if (num_rows >= kRows) {
      CLOTHID_UNROLL
      for (int j = 0; j < kColumns; ++j) columns[j].Store(to + j * stride);
      return;
    }
    double numbers[kColumns][kRows];
    CLOTHID_UNROLL
    for (int j = 0; j < kColumns; ++j) columns[j].Store(numbers[j]);
    for (int j = 0; j < kColumns; ++j) {
      for (int i = 0; i < num_rows; ++i) to[j * stride + i] = numbers[j][i];
    }
  }

  // Takes its first `num_rows` rows off the columns `to` at the rows `targets`.
  CLOTHID_ALWAYS_INLINE void SubtractFrom(const int* targets, int num_rows, double* const* to) const {
    if (num_rows >= kRows && targets[kRows - 1] - targets[0] == kRows - 1) {
      CLOTHID_UNROLL
      for (int j = 0; j < kColumns; ++j) {
        Rows rows;
        rows.Load(to[j] + targets[0]);
        rows.Subtract(columns[j]);
        rows.Store(to[j] + targets[0]);
      }
      return;
    }
    double numbers[kColumns][kRows];
    CLOTHID_UNROLL
    for (int j = 0; j < kColumns; ++j) columns[j].Store(numbers[j]);
    const int count = std::min(num_rows, kRows);
    for (int j = 0; j < kColumns; ++j) {
      for (int i = 0; i < count; ++i) to[j][targets[i]] -= numbers[j][i];
    }
  }

  // With its first row on the diagonal: becomes its Cholesky factor L, and `diagonal` L's rows by columns, with
  // reciprocals on the diagonal. False: it is not positive definite.
  CLOTHID_ALWAYS_INLINE bool Factor(double (*diagonal)[kRows]) {
    bool positive = true;
    CLOTHID_UNROLL
    for (int j = 0; j < kColumns; ++j) {
      const double pivot = columns[j][j];
      positive = positive && pivot > 0.0;
      const double reciprocal = 1.0 / std::sqrt(pivot);
      columns[j].Scale(reciprocal);
      CLOTHID_UNROLL
      for (int i = j + 1; i < kColumns; ++i) columns[i].SubtractProduct(columns[j], columns[j][i]);
      columns[j].Store(diagonal[j]);
      diagonal[j][j] = reciprocal;
    }
    return positive;
  }

  // Below the diagonal: X L^T = tile.
  CLOTHID_ALWAYS_INLINE void Solve(const double (*diagonal)[kRows]) {
    CLOTHID_UNROLL
    for (int j = 0; j < kColumns; ++j) {
      CLOTHID_UNROLL
      for (int i = 0; i < j; ++i) columns[j].SubtractProduct(columns[i], diagonal[i][j]);
      columns[j].Scale(diagonal[j][j]);
    }
  }

  Rows columns[kColumns];
};

// The dense arithmetic of a supernode.
template <typename Rows>
struct Arithmetic {
  template <int kColumns>
  CLOTHID_ALWAYS_INLINE static void SubtractStrip(const Update& update, int first, const Panel& panel) {
    double* to[kColumns];
    for (int j = 0; j < kColumns; ++j) {
      to[j] = panel.values + static_cast<std::ptrdiff_t>(update.targets[first + j]) * panel.num_rows;
    }
    for (int row = first; row < update.num_rows; row += kRows) {
      Tile<Rows, kColumns> tile;
      tile.SetProducts(update.source + row, update.stride, update.source + first, update.stride, update.depth);
      tile.SubtractFrom(update.targets + row, update.num_rows - row, to);
    }
  }

  // The same of the rows from `begin` to `end`, which are copied: by tiles in `tiles`, those of the strip in `strip`.
  // What a tile has above the diagonal goes there, where it means nothing.
  template <int kColumns>
  CLOTHID_ALWAYS_INLINE static void SubtractCopied(const Update& update, int first, int begin, int end,
                                                   const double* tiles, const double* strip, const Panel& panel) {
    double* to[kColumns];
    for (int j = 0; j < kColumns; ++j) {
      to[j] = panel.values + static_cast<std::ptrdiff_t>(update.targets[first + j]) * panel.num_rows;
    }
    const int skipped = std::max(first - begin, 0) / kRows;
    tiles += static_cast<std::ptrdiff_t>(skipped) * kRows * update.depth;
    for (int row = begin + skipped * kRows; row < end; row += kRows, tiles += kRows * update.depth) {
      Tile<Rows, kColumns> tile;
      tile.SetProducts(tiles, kRows, strip, kColumns, update.depth);
      tile.SubtractFrom(update.targets + row, update.num_rows - row, to);
    }
  }

  // Rows of the source by tiles: kRows numbers of each column in turn.
  CLOTHID_ALWAYS_INLINE static void CopyTiles(const Update& update, int begin, int end, double* to) {
    for (int k = 0; k < update.depth; ++k) {
      const double* const from = update.source + k * update.stride;
      double* tile = to + k * kRows;
      for (int row = begin; row < end; row += kRows, tile += kRows * update.depth) {
        Rows rows;
        rows.Load(from + row);
        rows.Store(tile);
      }
    }
  }

  CLOTHID_ALWAYS_INLINE static void CopyStrip(const Update& update, int first, int num_columns, double* to) {
    for (int k = 0; k < update.depth; ++k) {
      const double* const from = update.source + k * update.stride + first;
      for (int j = 0; j < num_columns; ++j) *to++ = from[j];
    }
  }

  CLOTHID_ALWAYS_INLINE static void SubtractWithCopies(const Update& update, const Panel& panel, double* scratch) {
    double* const tiles = scratch + static_cast<std::ptrdiff_t>(update.num_columns) * update.depth;
    for (int first = 0; first < update.num_columns; first += kWidth) {
      CopyStrip(update, first, std::min(kWidth, update.num_columns - first),
                scratch + static_cast<std::ptrdiff_t>(first) * update.depth);
    }
    const int num_at_once = kRows * std::max(kCopiedValues / (kRows * update.depth), 1);
    for (int begin = 0; begin < update.num_rows; begin += num_at_once) {
      const int end = std::min(begin + num_at_once, update.num_rows);
      CopyTiles(update, begin, end, tiles);
      for (int first = 0; first < std::min(update.num_columns, end); first += kWidth) {
        const double* const strip = scratch + static_cast<std::ptrdiff_t>(first) * update.depth;
        if (first + kWidth <= update.num_columns) {
          SubtractCopied<kWidth>(update, first, begin, end, tiles, strip, panel);
        } else {
          SubtractCopied<kBlock>(update, first, begin, end, tiles, strip, panel);
        }
      }
    }
  }

  CLOTHID_ALWAYS_INLINE static void Subtract(const Update& update, const Panel& panel, double* scratch) {
    if (IsCopied(update.num_columns, update.depth)) return SubtractWithCopies(update, panel, scratch);
    int first = 0;
    for (; first + kWidth <= update.num_columns; first += kWidth) SubtractStrip<kWidth>(update, first, panel);
    if (first < update.num_columns) SubtractStrip<kBlock>(update, first, panel);
  }

  template <int kColumns>
  CLOTHID_ALWAYS_INLINE static bool FactorStrip(int first, const Panel& panel) {
    const std::ptrdiff_t stride = panel.num_rows;
    double* const own = panel.values + first * stride;
    const double* const b = panel.values + first;
    Tile<Rows, kColumns> products, tile;
    products.SetProducts(b, stride, b, stride, first);
    tile.SetDifferences(products, own + first, stride);
    double diagonal[kColumns][kRows];
    if (!tile.Factor(diagonal)) return false;
    const int num_rows = std::min(panel.num_rows - first, kRows);
    for (int j = 0; j < kColumns; ++j) std::copy_n(diagonal[j], num_rows, own + first + j * stride);
    for (int row = first + kRows; row < panel.num_rows; row += kRows) {
      products.SetProducts(panel.values + row, stride, b, stride, first);
      tile.SetDifferences(products, own + row, stride);
      tile.Solve(diagonal);
      tile.Store(panel.num_rows - row, stride, own + row);
    }
    return true;
  }

  CLOTHID_ALWAYS_INLINE static bool Factor(const Panel& panel) {
    int first = 0;
    for (; first + kWidth <= panel.num_columns; first += kWidth) {
      if (!FactorStrip<kWidth>(first, panel)) return false;
    }
    return first == panel.num_columns || FactorStrip<kBlock>(first, panel);
  }
};

// What an instruction set has.
struct Kernels {
  void (*subtract)(const Update& update, const Panel& panel, double* scratch);
  bool (*factor)(const Panel& panel);  // false: not positive definite
};

using CommonArithmetic = Arithmetic<CommonLanes<double>::Eight>;
void SubtractByCommon(const Update& update, const Panel& panel, double* scratch) {
  CommonArithmetic::Subtract(update, panel, scratch);
}
bool FactorByCommon(const Panel& panel) { return CommonArithmetic::Factor(panel); }

#if CLOTHID_HAS_AVX2
using Avx2Arithmetic = Arithmetic<Avx2Lanes<double>::Eight>;
CLOTHID_AVX2 void SubtractByAvx2(const Update& update, const Panel& panel, double* scratch) {
  Avx2Arithmetic::Subtract(update, panel, scratch);
}
CLOTHID_AVX2 bool FactorByAvx2(const Panel& panel) { return Avx2Arithmetic::Factor(panel); }
#endif

Kernels KernelsOf([[maybe_unused]] InstructionSet instructions) {
#if CLOTHID_HAS_AVX2
  if (instructions == InstructionSet::kAvx2) return {SubtractByAvx2, FactorByAvx2};
#endif
  return {SubtractByCommon, FactorByCommon};
}

// What a factorisation is about.
struct Matrices {
  const Supernodes& supernodes;
  const BlockPattern& pattern;
  const double* values;
  double* factor;
  Kernels kernels;
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
      const Panel panel = PanelOf(s);
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
  Panel PanelOf(int s) const {
    return {matrices_.factor + supernodes_.value_starts[s], 3 * supernodes_.num_rows(s),
            3 * supernodes_.num_columns(s)};
  }

  // The columns of A, and where its rows are.
  void Assemble(int s, const Panel& panel) {
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

  void Subtract(const Supernodes::Update& update, const Panel& panel) {
    const Panel source = PanelOf(update.source);
    const int* const rows = supernodes_.rows.data() + supernodes_.row_starts[update.source];
    int* target = targets_.data();
    for (int i = update.first; i < supernodes_.num_rows(update.source); ++i, target += 3) {
      const int row = 3 * positions_[rows[i]];
      target[0] = row;
      target[1] = row + 1;
      target[2] = row + 2;
    }
    const int num_columns = 3 * (update.last - update.first);
    if (IsCopied(num_columns, source.num_columns)) {
      const std::size_t size = static_cast<std::size_t>(num_columns + kRows) * source.num_columns + kCopiedValues;
      if (scratch_.size() < size) scratch_.resize(size);
    }
    matrices_.kernels.subtract({source.values + 3 * static_cast<std::ptrdiff_t>(update.first), source.num_rows,
                                source.num_columns, num_columns, source.num_rows - 3 * update.first, targets_.data()},
                               panel, scratch_.data());
  }

  const Matrices& matrices_;
  const Supernodes& supernodes_;
  std::vector<int> positions_;   // of the rows of A in the supernode
  std::vector<int> targets_;     // of the rows of an update in the supernode, by scalars
  std::vector<double> scratch_;  // for copies
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

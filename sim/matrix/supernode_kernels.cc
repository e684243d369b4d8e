#include "sim/matrix/supernode_kernels.h"

#include <algorithm>
#include <cmath>

#include "sim/matrix/supernodes.h"

namespace clothid {
namespace {

// Columns of a tile, and its rows.
constexpr int kWidth = 6;
constexpr int kBlock = 3;
constexpr int kRows = 8;
static_assert(kRows <= kSpareValues);

// From a supernode whose columns are so far apart, pages that are fetched anew for every strip of columns, an update of
// so many columns and so many products each copies what it multiplies.
constexpr std::ptrdiff_t kCopiedStride = 512;
constexpr int kCopiedColumns = 2 * kWidth;
constexpr int kCopiedDepth = 24;
// How many numbers of a source are copied at a time: half of what a second cache has.
constexpr int kCopiedValues = 1 << 15;

bool IsCopied(const SupernodeUpdate& update) {
  return update.stride >= kCopiedStride && update.num_columns >= kCopiedColumns && update.depth >= kCopiedDepth;
}

// How many rows are copied at a time.
int RowsAtOnce(const SupernodeUpdate& update) {
  const int most = kRows * std::max(kCopiedValues / (kRows * update.depth), 1);
  return std::min(most, (update.num_rows + kRows - 1) / kRows * kRows);
}

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
  CLOTHID_ALWAYS_INLINE static void SubtractStrip(const SupernodeUpdate& update, int first,
                                                  const SupernodePanel& panel) {
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
  CLOTHID_ALWAYS_INLINE static void SubtractCopied(const SupernodeUpdate& update, int first, int begin, int end,
                                                   const double* tiles, const double* strip,
                                                   const SupernodePanel& panel) {
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
  CLOTHID_ALWAYS_INLINE static void CopyTiles(const SupernodeUpdate& update, int begin, int end, double* to) {
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

  CLOTHID_ALWAYS_INLINE static void CopyStrip(const SupernodeUpdate& update, int first, int num_columns, double* to) {
    for (int k = 0; k < update.depth; ++k) {
      const double* const from = update.source + k * update.stride + first;
      for (int j = 0; j < num_columns; ++j) *to++ = from[j];
    }
  }

  CLOTHID_ALWAYS_INLINE static void SubtractWithCopies(const SupernodeUpdate& update, const SupernodePanel& panel,
                                                       double* scratch) {
    double* const tiles = scratch + static_cast<std::ptrdiff_t>(update.num_columns) * update.depth;
    for (int first = 0; first < update.num_columns; first += kWidth) {
      CopyStrip(update, first, std::min(kWidth, update.num_columns - first),
                scratch + static_cast<std::ptrdiff_t>(first) * update.depth);
    }
    const int num_at_once = RowsAtOnce(update);
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

  CLOTHID_ALWAYS_INLINE static void Subtract(const SupernodeUpdate& update, const SupernodePanel& panel,
                                             double* scratch) {
    if (IsCopied(update)) return SubtractWithCopies(update, panel, scratch);
    int first = 0;
    for (; first + kWidth <= update.num_columns; first += kWidth) SubtractStrip<kWidth>(update, first, panel);
    if (first < update.num_columns) SubtractStrip<kBlock>(update, first, panel);
  }

  template <int kColumns>
  CLOTHID_ALWAYS_INLINE static bool FactorStrip(int first, const SupernodePanel& panel) {
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

  CLOTHID_ALWAYS_INLINE static bool Factor(const SupernodePanel& panel) {
    int first = 0;
    for (; first + kWidth <= panel.num_columns; first += kWidth) {
      if (!FactorStrip<kWidth>(first, panel)) return false;
    }
    return first == panel.num_columns || FactorStrip<kBlock>(first, panel);
  }
};

using CommonArithmetic = Arithmetic<CommonLanes<double>::Eight>;
void SubtractByCommon(const SupernodeUpdate& update, const SupernodePanel& panel, double* scratch) {
  CommonArithmetic::Subtract(update, panel, scratch);
}
bool FactorByCommon(const SupernodePanel& panel) { return CommonArithmetic::Factor(panel); }

#if CLOTHID_HAS_AVX2
using Avx2Arithmetic = Arithmetic<Avx2Lanes<double>::Eight>;
CLOTHID_AVX2 void SubtractByAvx2(const SupernodeUpdate& update, const SupernodePanel& panel, double* scratch) {
  Avx2Arithmetic::Subtract(update, panel, scratch);
}
CLOTHID_AVX2 bool FactorByAvx2(const SupernodePanel& panel) { return Avx2Arithmetic::Factor(panel); }
#endif

}  // namespace

std::size_t ScratchSize(const SupernodeUpdate& update) {
  if (!IsCopied(update)) return 0;
  return static_cast<std::size_t>(update.num_columns + RowsAtOnce(update)) * update.depth;
}

SupernodeKernels KernelsOf([[maybe_unused]] InstructionSet instructions) {
#if CLOTHID_HAS_AVX2
  if (instructions == InstructionSet::kAvx2) return {SubtractByAvx2, FactorByAvx2};
#endif
  return {SubtractByCommon, FactorByCommon};
}

}  // namespace clothid

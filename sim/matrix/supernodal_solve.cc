#include "sim/matrix/supernodal_solve.h"

#include <algorithm>
#include <cstddef>

#include "sim/matrix/lanes.h"

namespace clothid {
namespace {

// Columns of L that are taken at once.
constexpr int kWidth = 6;
constexpr int kBlock = 3;
constexpr int kRows = 8;

// A supernode, by scalars: `values` [num_rows x num_columns].
struct Panel {
  const double* values;
  int num_rows, num_columns;
  const int* rows_below;  // by blocks
};

// Of one right-hand side: vector instructions work on kRows rows of L at once. `work` [num_rows + kRows] holds the
// unknowns of the columns, then of the rows below them.
template <typename Rows>
struct OneSide {
  static constexpr int kSides = 1;

  template <int kColumns>
  CLOTHID_ALWAYS_INLINE static void ForwardStrip(const Panel& panel, int first, double* work) {
    const std::ptrdiff_t stride = panel.num_rows;
    const double* const l = panel.values + first * stride;
    double x[kColumns];
    CLOTHID_UNROLL
    for (int j = 0; j < kColumns; ++j) {
      double sum = work[first + j];
      CLOTHID_UNROLL
      for (int i = 0; i < j; ++i) sum -= l[i * stride + first + j] * x[i];
      x[j] = work[first + j] = sum * l[j * stride + first + j];
    }
    for (int row = first + kColumns; row < panel.num_rows; row += kRows) {
      Rows sum, entries;
      sum.Load(work + row);
      CLOTHID_UNROLL
      for (int j = 0; j < kColumns; ++j) {
        entries.Load(l + j * stride + row);
        sum.SubtractProduct(entries, x[j]);
      }
      sum.Store(work + row);
    }
  }

  template <int kColumns>
  CLOTHID_ALWAYS_INLINE static void BackwardStrip(const Panel& panel, int first, double* work) {
    const std::ptrdiff_t stride = panel.num_rows;
    const double* const l = panel.values + first * stride;
    Rows sums[kColumns];
    CLOTHID_UNROLL
    for (int j = 0; j < kColumns; ++j) sums[j].SetZero();
    for (int row = first + kColumns; row < panel.num_rows; row += kRows) {
      Rows x, entries;
      x.Load(work + row);
      CLOTHID_UNROLL
      for (int j = 0; j < kColumns; ++j) {
        entries.Load(l + j * stride + row);
        sums[j].AddProduct(entries, x);
      }
    }
    double x[kColumns];
    CLOTHID_UNROLL
    for (int j = kColumns - 1; j >= 0; --j) {
      double sum = work[first + j] - sums[j].Sum();
      CLOTHID_UNROLL
      for (int i = j + 1; i < kColumns; ++i) sum -= l[j * stride + first + i] * x[i];
      x[j] = work[first + j] = sum * l[j * stride + first + j];
    }
  }
};

// Of Sides::kSize right-hand sides, beside each other in the rows of `work`: vector instructions work on all of them.
template <typename Sides>
struct ManySides {
  static constexpr int kSides = Sides::kSize;

  template <int kColumns>
  CLOTHID_ALWAYS_INLINE static void ForwardStrip(const Panel& panel, int first, double* work) {
    const std::ptrdiff_t stride = panel.num_rows;
    const double* const l = panel.values + first * stride;
    Sides x[kColumns];
    CLOTHID_UNROLL
    for (int j = 0; j < kColumns; ++j) {
      x[j].Load(work + kSides * (first + j));
      CLOTHID_UNROLL
      for (int i = 0; i < j; ++i) x[j].SubtractProduct(x[i], l[i * stride + first + j]);
      x[j].Scale(l[j * stride + first + j]);
      x[j].Store(work + kSides * (first + j));
    }
    for (int row = first + kColumns; row < panel.num_rows; ++row) {
      Sides sum;
      sum.Load(work + kSides * row);
      CLOTHID_UNROLL
      for (int j = 0; j < kColumns; ++j) sum.SubtractProduct(x[j], l[j * stride + row]);
      sum.Store(work + kSides * row);
    }
  }

  template <int kColumns>
  CLOTHID_ALWAYS_INLINE static void BackwardStrip(const Panel& panel, int first, double* work) {
    const std::ptrdiff_t stride = panel.num_rows;
    const double* const l = panel.values + first * stride;
    Sides x[kColumns];
    CLOTHID_UNROLL
    for (int j = 0; j < kColumns; ++j) x[j].Load(work + kSides * (first + j));
    for (int row = first + kColumns; row < panel.num_rows; ++row) {
      Sides below;
      below.Load(work + kSides * row);
      CLOTHID_UNROLL
      for (int j = 0; j < kColumns; ++j) x[j].SubtractProduct(below, l[j * stride + row]);
    }
    CLOTHID_UNROLL
    for (int j = kColumns - 1; j >= 0; --j) {
      CLOTHID_UNROLL
      for (int i = j + 1; i < kColumns; ++i) x[j].SubtractProduct(x[i], l[j * stride + first + i]);
      x[j].Scale(l[j * stride + first + j]);
      x[j].Store(work + kSides * (first + j));
    }
  }
};

// Through a supernode. `x` [n x kSides] by rows, `own` of it at the supernode's columns.
template <typename Strips>
struct Sweep {
  static constexpr int kSides = Strips::kSides;

  CLOTHID_ALWAYS_INLINE static void Forward(const Panel& panel, double* x, double* own, double* work) {
    std::copy_n(own, kSides * panel.num_columns, work);
    std::fill_n(work + kSides * panel.num_columns, kSides * (panel.num_rows - panel.num_columns) + kRows, 0.0);
    int first = 0;
    for (; first + kWidth <= panel.num_columns; first += kWidth) {
      Strips::template ForwardStrip<kWidth>(panel, first, work);
    }
    if (first < panel.num_columns) Strips::template ForwardStrip<kBlock>(panel, first, work);
    std::copy_n(work, kSides * panel.num_columns, own);
    const double* from = work + kSides * panel.num_columns;
    const double* const end = work + kSides * panel.num_rows;
    for (const int* row = panel.rows_below; from != end; ++row) {
      double* const to = x + 3 * kSides * static_cast<std::ptrdiff_t>(*row);
      for (int i = 0; i < 3 * kSides; ++i) to[i] += *from++;
    }
  }

  CLOTHID_ALWAYS_INLINE static void Backward(const Panel& panel, const double* x, double* own, double* work) {
    std::copy_n(own, kSides * panel.num_columns, work);
    double* to = work + kSides * panel.num_columns;
    double* const end = work + kSides * panel.num_rows;
    for (const int* row = panel.rows_below; to != end; ++row) {
      const double* const from = x + 3 * kSides * static_cast<std::ptrdiff_t>(*row);
      for (int i = 0; i < 3 * kSides; ++i) *to++ = from[i];
    }
    std::fill_n(end, kRows, 0.0);
    int first = panel.num_columns / kWidth * kWidth;
    if (first < panel.num_columns) Strips::template BackwardStrip<kBlock>(panel, first, work);
    for (first -= kWidth; first >= 0; first -= kWidth) Strips::template BackwardStrip<kWidth>(panel, first, work);
    std::copy_n(work, kSides * panel.num_columns, own);
  }

  CLOTHID_ALWAYS_INLINE static void Solve(const Supernodes& supernodes, const double* factor, double* x, double* work) {
    const auto panel = [&](int s) {
      return Panel{factor + supernodes.value_starts[s], 3 * supernodes.num_rows(s), 3 * supernodes.num_columns(s),
                   supernodes.rows.data() + supernodes.row_starts[s] + supernodes.num_columns(s)};
    };
    const auto own = [&](int s) { return x + 3 * kSides * static_cast<std::ptrdiff_t>(supernodes.columns[s]); };
    for (int s = 0; s < supernodes.size(); ++s) Forward(panel(s), x, own(s), work);
    for (int s = supernodes.size() - 1; s >= 0; --s) Backward(panel(s), x, own(s), work);
  }
};

// Solves in place for `x` [n x sides] by rows, with `work` for a supernode.
using Kernel = void (*)(const Supernodes& supernodes, const double* factor, double* x, double* work);

// What an instruction set has: for one, four and eight right-hand sides.
struct Kernels {
  Kernel one, four, eight;
};

using CommonOne = Sweep<OneSide<Lanes<Vector2, 4>>>;
using CommonFour = Sweep<ManySides<Lanes<Vector2, 2>>>;
using CommonEight = Sweep<ManySides<Lanes<Vector2, 4>>>;
void SolveOneByCommon(const Supernodes& supernodes, const double* factor, double* x, double* work) {
  CommonOne::Solve(supernodes, factor, x, work);
}
void SolveFourByCommon(const Supernodes& supernodes, const double* factor, double* x, double* work) {
  CommonFour::Solve(supernodes, factor, x, work);
}
void SolveEightByCommon(const Supernodes& supernodes, const double* factor, double* x, double* work) {
  CommonEight::Solve(supernodes, factor, x, work);
}

#if CLOTHID_HAS_AVX2
using Avx2One = Sweep<OneSide<Lanes<Vector4, 2>>>;
using Avx2Four = Sweep<ManySides<Lanes<Vector4, 1>>>;
using Avx2Eight = Sweep<ManySides<Lanes<Vector4, 2>>>;
CLOTHID_AVX2 void SolveOneByAvx2(const Supernodes& supernodes, const double* factor, double* x, double* work) {
  Avx2One::Solve(supernodes, factor, x, work);
}
CLOTHID_AVX2 void SolveFourByAvx2(const Supernodes& supernodes, const double* factor, double* x, double* work) {
  Avx2Four::Solve(supernodes, factor, x, work);
}
CLOTHID_AVX2 void SolveEightByAvx2(const Supernodes& supernodes, const double* factor, double* x, double* work) {
  Avx2Eight::Solve(supernodes, factor, x, work);
}
#endif

Kernels KernelsOf([[maybe_unused]] InstructionSet instructions) {
#if CLOTHID_HAS_AVX2
  if (instructions == InstructionSet::kAvx2) return {SolveOneByAvx2, SolveFourByAvx2, SolveEightByAvx2};
#endif
  return {SolveOneByCommon, SolveFourByCommon, SolveEightByCommon};
}

// Of `columns` [n x s] those from `first` on, `width` of them, with a kernel for `sides`.
void SolveBeside(const Supernodes& supernodes, const double* factor, Kernel kernel, Eigen::Index sides,
                 Eigen::Index first, Eigen::Index width, Eigen::MatrixXd* columns) {
  const Eigen::Index size = columns->rows();
  Eigen::MatrixXd x = Eigen::MatrixXd::Zero(sides, size);
  x.topRows(width) = columns->middleCols(first, width).transpose();
  Eigen::VectorXd work(sides * 3 * supernodes.max_rows + kRows);
  kernel(supernodes, factor, x.data(), work.data());
  columns->middleCols(first, width) = x.topRows(width).transpose();
}

}  // namespace

void SolveSupernodes(const Supernodes& supernodes, const double* factor, const Eigen::MatrixXd& right,
                     Eigen::MatrixXd* solution, InstructionSet instructions) {
  const Kernels kernels = KernelsOf(instructions);
  *solution = right;
  if (right.cols() == 1) {
    Eigen::VectorXd work(3 * supernodes.max_rows + kRows);
    kernels.one(supernodes, factor, solution->data(), work.data());
    return;
  }
  const Eigen::Index num_sides = right.cols();
  for (Eigen::Index first = 0; first < num_sides; first += 8) {
    const Eigen::Index width = std::min<Eigen::Index>(8, num_sides - first), sides = width > 4 ? 8 : 4;
    SolveBeside(supernodes, factor, sides > 4 ? kernels.eight : kernels.four, sides, first, width, solution);
  }
}

}  // namespace clothid

#include "sim/matrix/supernodal_solve.h"

#include <algorithm>
#include <cstddef>
#include <type_traits>

#include "sim/matrix/lanes.h"

#if defined(__x86_64__)
#include <xmmintrin.h>
#endif

namespace clothid {
namespace {

// Columns of L that are taken at once.
constexpr int kWidth = 6;
constexpr int kBlock = 3;
constexpr int kRows = 8;

// A supernode, by scalars: `values` [num_rows x num_columns].
template <typename Scalar>
struct Panel {
  const Scalar* values;
  int num_rows, num_columns;
  const int* rows_below;  // by blocks
};

// Of one right-hand side: vector instructions work on kRows rows of L at once. `work` [num_rows + kRows] holds the
// unknowns of the columns, then of the rows below them.
template <typename Rows>
struct OneSide {
  using Scalar = typename Rows::Scalar;
  static constexpr int kSides = 1;

  template <int kColumns>
  CLOTHID_ALWAYS_INLINE static void ForwardStrip(const Panel<Scalar>& panel, int first, Scalar* work) {
    const std::ptrdiff_t stride = panel.num_rows;
    const Scalar* const l = panel.values + first * stride;
    Scalar x[kColumns];
    CLOTHID_UNROLL
    for (int j = 0; j < kColumns; ++j) {
      Scalar sum = work[first + j];
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
  CLOTHID_ALWAYS_INLINE static void BackwardStrip(const Panel<Scalar>& panel, int first, Scalar* work) {
    const std::ptrdiff_t stride = panel.num_rows;
    const Scalar* const l = panel.values + first * stride;
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
    Scalar x[kColumns];
    CLOTHID_UNROLL
    for (int j = kColumns - 1; j >= 0; --j) {
      Scalar sum = work[first + j] - sums[j].Sum();
      CLOTHID_UNROLL
      for (int i = j + 1; i < kColumns; ++i) sum -= l[j * stride + first + i] * x[i];
      x[j] = work[first + j] = sum * l[j * stride + first + j];
    }
  }
};

// Of Sides::kSize right-hand sides, beside each other in the rows of `work`: vector instructions work on all of them.
template <typename Sides>
struct ManySides {
  using Scalar = typename Sides::Scalar;
  static constexpr int kSides = Sides::kSize;

  template <int kColumns>
  CLOTHID_ALWAYS_INLINE static void ForwardStrip(const Panel<Scalar>& panel, int first, Scalar* work) {
    const std::ptrdiff_t stride = panel.num_rows;
    const Scalar* const l = panel.values + first * stride;
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
  CLOTHID_ALWAYS_INLINE static void BackwardStrip(const Panel<Scalar>& panel, int first, Scalar* work) {
    const std::ptrdiff_t stride = panel.num_rows;
    const Scalar* const l = panel.values + first * stride;
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
  using Scalar = typename Strips::Scalar;
  static constexpr int kSides = Strips::kSides;

  CLOTHID_ALWAYS_INLINE static void Forward(const Panel<Scalar>& panel, Scalar* x, Scalar* own, Scalar* work) {
    std::copy_n(own, kSides * panel.num_columns, work);
    std::fill_n(work + kSides * panel.num_columns, kSides * (panel.num_rows - panel.num_columns) + kRows, Scalar{0});
    int first = 0;
    for (; first + kWidth <= panel.num_columns; first += kWidth) {
      Strips::template ForwardStrip<kWidth>(panel, first, work);
    }
    if (first < panel.num_columns) Strips::template ForwardStrip<kBlock>(panel, first, work);
    std::copy_n(work, kSides * panel.num_columns, own);
    const Scalar* from = work + kSides * panel.num_columns;
    const Scalar* const end = work + kSides * panel.num_rows;
    for (const int* row = panel.rows_below; from != end; ++row) {
      Scalar* const to = x + 3 * kSides * static_cast<std::ptrdiff_t>(*row);
      for (int i = 0; i < 3 * kSides; ++i) to[i] += *from++;
    }
  }

  CLOTHID_ALWAYS_INLINE static void Backward(const Panel<Scalar>& panel, const Scalar* x, Scalar* own, Scalar* work) {
    std::copy_n(own, kSides * panel.num_columns, work);
    Scalar* to = work + kSides * panel.num_columns;
    Scalar* const end = work + kSides * panel.num_rows;
    for (const int* row = panel.rows_below; to != end; ++row) {
      const Scalar* const from = x + 3 * kSides * static_cast<std::ptrdiff_t>(*row);
      for (int i = 0; i < 3 * kSides; ++i) *to++ = from[i];
    }
    std::fill_n(end, kRows, Scalar{0});
    int first = panel.num_columns / kWidth * kWidth;
    if (first < panel.num_columns) Strips::template BackwardStrip<kBlock>(panel, first, work);
    for (first -= kWidth; first >= 0; first -= kWidth) Strips::template BackwardStrip<kWidth>(panel, first, work);
    std::copy_n(work, kSides * panel.num_columns, own);
  }

  CLOTHID_ALWAYS_INLINE static void Solve(const Supernodes& supernodes, const Scalar* factor, Scalar* x, Scalar* work) {
    const auto panel = [&](int s) {
      return Panel<Scalar>{factor + supernodes.value_starts[s], 3 * supernodes.num_rows(s),
                           3 * supernodes.num_columns(s),
                           supernodes.rows.data() + supernodes.row_starts[s] + supernodes.num_columns(s)};
    };
    const auto own = [&](int s) { return x + 3 * kSides * static_cast<std::ptrdiff_t>(supernodes.columns[s]); };
    for (int s = 0; s < supernodes.size(); ++s) Forward(panel(s), x, own(s), work);
    for (int s = supernodes.size() - 1; s >= 0; --s) Backward(panel(s), x, own(s), work);
  }
};

// Solves in place for `x` [n x sides] by rows, with `work` for a supernode.
template <typename Scalar>
using Kernel = void (*)(const Supernodes& supernodes, const Scalar* factor, Scalar* x, Scalar* work);

template <typename Strips, typename Scalar = typename Strips::Scalar>
void SolveByCommon(const Supernodes& supernodes, const Scalar* factor, Scalar* x, Scalar* work) {
  Sweep<Strips>::Solve(supernodes, factor, x, work);
}

#if CLOTHID_HAS_AVX2
template <typename Strips, typename Scalar = typename Strips::Scalar>
CLOTHID_AVX2 void SolveByAvx2(const Supernodes& supernodes, const Scalar* factor, Scalar* x, Scalar* work) {
  Sweep<Strips>::Solve(supernodes, factor, x, work);
}
#endif

// What an instruction set has: for one, four and eight right-hand sides.
template <typename Scalar>
struct Kernels {
  Kernel<Scalar> one, four, eight;
};

template <typename Scalar>
Kernels<Scalar> KernelsOf([[maybe_unused]] InstructionSet instructions) {
#if CLOTHID_HAS_AVX2
  using Best = Avx2Lanes<Scalar>;
  if (instructions == InstructionSet::kAvx2) {
    return {SolveByAvx2<OneSide<typename Best::Eight>>, SolveByAvx2<ManySides<typename Best::Four>>,
            SolveByAvx2<ManySides<typename Best::Eight>>};
  }
#endif
  using Common = CommonLanes<Scalar>;
  return {SolveByCommon<OneSide<typename Common::Eight>>, SolveByCommon<ManySides<typename Common::Four>>,
          SolveByCommon<ManySides<typename Common::Eight>>};
}

// While it lives, this thread takes numbers below the smallest normal one for zeros. Single precision meets them where
// a solution decays, and they would slow down the processor many times.
class SubnormalsAsZeros {
 public:
#if defined(__x86_64__)
  SubnormalsAsZeros() { _mm_setcsr(before_ | kFlushToZero | kDenormalsAreZeros); }
  ~SubnormalsAsZeros() { _mm_setcsr(before_); }
#else
  SubnormalsAsZeros() {}
#endif
  SubnormalsAsZeros(const SubnormalsAsZeros&) = delete;
  SubnormalsAsZeros& operator=(const SubnormalsAsZeros&) = delete;

#if defined(__x86_64__)
 private:
  static constexpr unsigned kFlushToZero = 0x8000, kDenormalsAreZeros = 0x0040;
  const unsigned before_ = _mm_getcsr();
#endif
};

void Run(const Supernodes& supernodes, const double* factor, Kernel<double> kernel, double* x, double* work) {
  kernel(supernodes, factor, x, work);
}
void Run(const Supernodes& supernodes, const float* factor, Kernel<float> kernel, float* x, float* work) {
  const SubnormalsAsZeros guard;
  kernel(supernodes, factor, x, work);
}

// By which a column is divided while it is solved for. Single precision would lose small numbers.
template <typename Scalar>
double ScaleOf(const Eigen::Ref<const Eigen::VectorXd>& column) {
  if constexpr (std::is_same_v<Scalar, double>) return 1.0;
  const double largest = column.size() == 0 ? 0.0 : column.cwiseAbs().maxCoeff();
  return largest > 0.0 ? largest : 1.0;
}

// Of `columns` [n x s] those from `first` on, `width` of them, with a kernel for `sides`.
template <typename Scalar>
void SolveBeside(const Supernodes& supernodes, const Scalar* factor, Kernel<Scalar> kernel, Eigen::Index sides,
                 Eigen::Index first, Eigen::Index width, Eigen::MatrixXd* columns) {
  using Matrix = Eigen::Matrix<Scalar, Eigen::Dynamic, Eigen::Dynamic>;
  Matrix x = Matrix::Zero(sides, columns->rows()), work(sides, 3 * supernodes.max_rows + kRows);
  Eigen::VectorXd scales(width);
  for (Eigen::Index c = 0; c < width; ++c) {
    scales[c] = ScaleOf<Scalar>(columns->col(first + c));
    x.row(c) = (columns->col(first + c).transpose() / scales[c]).template cast<Scalar>();
  }
  Run(supernodes, factor, kernel, x.data(), work.data());
  for (Eigen::Index c = 0; c < width; ++c) {
    columns->col(first + c) = x.row(c).transpose().template cast<double>() * scales[c];
  }
}

}  // namespace

template <typename Scalar>
void SolveSupernodes(const Supernodes& supernodes, const Scalar* factor, const Eigen::MatrixXd& right,
                     Eigen::MatrixXd* solution, InstructionSet instructions) {
  const Kernels<Scalar> kernels = KernelsOf<Scalar>(instructions);
  const Eigen::Index num_sides = right.cols();
  *solution = right;
  if (num_sides == 1) {
    SolveBeside<Scalar>(supernodes, factor, kernels.one, 1, 0, 1, solution);
    return;
  }
  for (Eigen::Index first = 0; first < num_sides; first += 8) {
    const Eigen::Index width = std::min<Eigen::Index>(8, num_sides - first), sides = width > 4 ? 8 : 4;
    SolveBeside<Scalar>(supernodes, factor, sides > 4 ? kernels.eight : kernels.four, sides, first, width, solution);
  }
}

template void SolveSupernodes(const Supernodes&, const double*, const Eigen::MatrixXd&, Eigen::MatrixXd*,
                              InstructionSet);
template void SolveSupernodes(const Supernodes&, const float*, const Eigen::MatrixXd&, Eigen::MatrixXd*,
                              InstructionSet);

}  // namespace clothid

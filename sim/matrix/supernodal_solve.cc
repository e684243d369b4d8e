#include "sim/matrix/supernodal_solve.h"

#include <algorithm>
#include <cstddef>
#include <type_traits>
#include <vector>

#include "sim/base/thread_team.h"
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
static_assert(kRows <= kSpareValues);

using Range = Supernodes::Range;

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

  // In the order of the supernodes, or against it. `rows`: of the supernodes, by places in `x`.
  CLOTHID_ALWAYS_INLINE static void Forward(const Supernodes& supernodes, const std::vector<int>& rows, Range range,
                                            const Scalar* factor, Scalar* x, Scalar* work) {
    for (int s = range.first; s < range.last; ++s) {
      Forward(PanelOf(supernodes, rows, s, factor), x, OwnOf(supernodes, s, x), work);
    }
  }
  CLOTHID_ALWAYS_INLINE static void Backward(const Supernodes& supernodes, const std::vector<int>& rows, Range range,
                                             const Scalar* factor, Scalar* x, Scalar* work) {
    for (int s = range.last - 1; s >= range.first; --s) {
      Backward(PanelOf(supernodes, rows, s, factor), x, OwnOf(supernodes, s, x), work);
    }
  }

 private:
  CLOTHID_ALWAYS_INLINE static Panel<Scalar> PanelOf(const Supernodes& supernodes, const std::vector<int>& rows, int s,
                                                     const Scalar* factor) {
    return {factor + supernodes.value_starts[s], 3 * supernodes.num_rows(s), 3 * supernodes.num_columns(s),
            rows.data() + supernodes.row_starts[s] + supernodes.num_columns(s)};
  }
  CLOTHID_ALWAYS_INLINE static Scalar* OwnOf(const Supernodes& supernodes, int s, Scalar* x) {
    return x + 3 * kSides * static_cast<std::ptrdiff_t>(supernodes.columns[s]);
  }
};

// Passes in place of `x` [. x sides] by rows through the supernodes of a range, with `work` for one of them.
template <typename Scalar>
using Pass = void (*)(const Supernodes& supernodes, const std::vector<int>& rows, Range range, const Scalar* factor,
                      Scalar* x, Scalar* work);

template <typename Strips, typename Scalar = typename Strips::Scalar>
void ForwardByCommon(const Supernodes& supernodes, const std::vector<int>& rows, Range range, const Scalar* factor,
                     Scalar* x, Scalar* work) {
  Sweep<Strips>::Forward(supernodes, rows, range, factor, x, work);
}
template <typename Strips, typename Scalar = typename Strips::Scalar>
void BackwardByCommon(const Supernodes& supernodes, const std::vector<int>& rows, Range range, const Scalar* factor,
                      Scalar* x, Scalar* work) {
  Sweep<Strips>::Backward(supernodes, rows, range, factor, x, work);
}

#if CLOTHID_HAS_AVX2
template <typename Strips, typename Scalar = typename Strips::Scalar>
CLOTHID_AVX2 void ForwardByAvx2(const Supernodes& supernodes, const std::vector<int>& rows, Range range,
                                const Scalar* factor, Scalar* x, Scalar* work) {
  Sweep<Strips>::Forward(supernodes, rows, range, factor, x, work);
}
template <typename Strips, typename Scalar = typename Strips::Scalar>
CLOTHID_AVX2 void BackwardByAvx2(const Supernodes& supernodes, const std::vector<int>& rows, Range range,
                                 const Scalar* factor, Scalar* x, Scalar* work) {
  Sweep<Strips>::Backward(supernodes, rows, range, factor, x, work);
}
#endif

// Both passes for so many right-hand sides.
template <typename Scalar>
struct Kernel {
  int sides;
  Pass<Scalar> forward, backward;
};

// For 1, 4 or 8.
template <typename Scalar>
Kernel<Scalar> KernelFor(int sides, [[maybe_unused]] InstructionSet instructions) {
#if CLOTHID_HAS_AVX2
  if (instructions == InstructionSet::kAvx2) {
    using One = OneSide<typename Avx2Lanes<Scalar>::Eight>;
    using Four = ManySides<typename Avx2Lanes<Scalar>::Four>;
    using Eight = ManySides<typename Avx2Lanes<Scalar>::Eight>;
    if (sides == 1) return {1, ForwardByAvx2<One>, BackwardByAvx2<One>};
    if (sides == 4) return {4, ForwardByAvx2<Four>, BackwardByAvx2<Four>};
    return {8, ForwardByAvx2<Eight>, BackwardByAvx2<Eight>};
  }
#endif
  using One = OneSide<typename CommonLanes<Scalar>::Eight>;
  using Four = ManySides<typename CommonLanes<Scalar>::Four>;
  using Eight = ManySides<typename CommonLanes<Scalar>::Eight>;
  if (sides == 1) return {1, ForwardByCommon<One>, BackwardByCommon<One>};
  if (sides == 4) return {4, ForwardByCommon<Four>, BackwardByCommon<Four>};
  return {8, ForwardByCommon<Eight>, BackwardByCommon<Eight>};
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

template <typename Scalar>
struct Solve {
  const Supernodes& supernodes;
  const Scalar* factor;
  Kernel<Scalar> kernel;
  ThreadTeam* team;

  // For `x` [sides x places] by columns: those of the unknowns, and for every branch those of the trunk.
  void Run(Scalar* x) const {
    if (supernodes.branches.empty()) {
      RunPass(kernel.forward, supernodes.rows, {0, supernodes.size()}, x);
      RunPass(kernel.backward, supernodes.rows, {0, supernodes.size()}, x);
      return;
    }
    RunBranches(kernel.forward, x);
    AddFromBranches(x);
    for (const int s : supernodes.trunk) RunPass(kernel.forward, supernodes.rows, {s, s + 1}, x);
    for (std::size_t i = supernodes.trunk.size(); i-- > 0;) {
      RunPass(kernel.backward, supernodes.rows, {supernodes.trunk[i], supernodes.trunk[i] + 1}, x);
    }
    CopyToBranches(x);
    RunBranches(kernel.backward, x);
  }

 private:
  void RunPass(Pass<Scalar> pass, const std::vector<int>& rows, Range range, Scalar* x) const {
    std::vector<Scalar> work(static_cast<std::size_t>(kernel.sides) * (3 * supernodes.max_rows + kRows));
    if constexpr (std::is_same_v<Scalar, float>) {
      const SubnormalsAsZeros guard;
      pass(supernodes, rows, range, factor, x, work.data());
    } else {
      pass(supernodes, rows, range, factor, x, work.data());
    }
  }

  void RunBranches(Pass<Scalar> pass, Scalar* x) const {
    RunTasks(team, static_cast<int>(supernodes.branches.size()), [&](int b) {
      RunPass(pass, supernodes.branch_rows, {supernodes.branches[b].first, supernodes.branches[b].last}, x);
    });
  }

  // Always in the order of the branches.
  void AddFromBranches(Scalar* x) const {
    const Scalar* from = x + Place(supernodes.columns.back());
    for (std::size_t b = 0; b < supernodes.branches.size(); ++b) {
      for (const int column : supernodes.trunk_columns) {
        Scalar* const to = x + Place(column);
        for (int i = 0; i < 3 * kernel.sides; ++i) to[i] += *from++;
      }
    }
  }

  void CopyToBranches(Scalar* x) const {
    Scalar* to = x + Place(supernodes.columns.back());
    for (std::size_t b = 0; b < supernodes.branches.size(); ++b) {
      for (const int column : supernodes.trunk_columns) to = std::copy_n(x + Place(column), 3 * kernel.sides, to);
    }
  }

  std::ptrdiff_t Place(int block) const { return 3 * static_cast<std::ptrdiff_t>(kernel.sides) * block; }
};

// For how many scalars Solve::Run needs places.
Eigen::Index NumPlaces(const Supernodes& supernodes) {
  return 3 * (static_cast<Eigen::Index>(supernodes.columns.back()) +
              static_cast<Eigen::Index>(supernodes.branches.size() * supernodes.trunk_columns.size()));
}

// By which a column is divided while it is solved for. Single precision would lose small numbers.
template <typename Scalar>
double ScaleOf(const Eigen::Ref<const Eigen::VectorXd>& column) {
  if constexpr (std::is_same_v<Scalar, double>) return 1.0;
  const double largest = column.size() == 0 ? 0.0 : column.cwiseAbs().maxCoeff();
  return largest > 0.0 ? largest : 1.0;
}

// Of `columns` [n x s] those from `first` on, `width` of them.
template <typename Scalar>
void SolveBeside(const Solve<Scalar>& solve, Eigen::Index first, Eigen::Index width, Eigen::MatrixXd* columns) {
  using Matrix = Eigen::Matrix<Scalar, Eigen::Dynamic, Eigen::Dynamic>;
  Matrix x = Matrix::Zero(solve.kernel.sides, NumPlaces(solve.supernodes));
  const Eigen::Index size = columns->rows();
  Eigen::VectorXd scales(width);
  for (Eigen::Index c = 0; c < width; ++c) {
    scales[c] = ScaleOf<Scalar>(columns->col(first + c));
    x.row(c).head(size) = (columns->col(first + c).transpose() / scales[c]).template cast<Scalar>();
  }
  solve.Run(x.data());
  for (Eigen::Index c = 0; c < width; ++c) {
    columns->col(first + c) = x.row(c).head(size).transpose().template cast<double>() * scales[c];
  }
}

}  // namespace

template <typename Scalar>
void SolveSupernodes(const Supernodes& supernodes, const Scalar* factor, const Eigen::MatrixXd& right,
                     Eigen::MatrixXd* solution, ThreadTeam* team, InstructionSet instructions) {
  const auto solve = [&](int sides, Eigen::Index first, Eigen::Index width) {
    SolveBeside<Scalar>({supernodes, factor, KernelFor<Scalar>(sides, instructions), team}, first, width, solution);
  };
  const Eigen::Index num_sides = right.cols();
  *solution = right;
  if (num_sides == 1) {
    solve(1, 0, 1);
    return;
  }
  for (Eigen::Index first = 0; first < num_sides; first += 8) {
    const Eigen::Index width = std::min<Eigen::Index>(8, num_sides - first);
    solve(width > 4 ? 8 : 4, first, width);
  }
}

template void SolveSupernodes(const Supernodes&, const double*, const Eigen::MatrixXd&, Eigen::MatrixXd*, ThreadTeam*,
                              InstructionSet);
template void SolveSupernodes(const Supernodes&, const float*, const Eigen::MatrixXd&, Eigen::MatrixXd*, ThreadTeam*,
                              InstructionSet);

}  // namespace clothid

// Several numbers at once, in whatever registers the machine has: loops over small dense matrices that round alike on
// every machine.
//
// The compiler lowers a vector that is wider than a register to code through memory. So such a loop is written once, as
// a template over Lanes, of which every instruction set has its own, and made in a function per instruction set; the
// machine chooses at run time. The template must be CLOTHID_ALWAYS_INLINE throughout and must not touch Eigen, whose
// alignment depends on the instruction set. Sources that include this are compiled without contraction of a product and
// a sum into one operation, which rounds once (-ffp-contract=off).
#ifndef CLOTHID_SIM_MATRIX_LANES_H_
#define CLOTHID_SIM_MATRIX_LANES_H_

#include <cstring>
#include <type_traits>
#include <utility>

#include "sim/base/vector_clones.h"

#if defined(__x86_64__) && defined(__GNUC__)
#define CLOTHID_HAS_AVX2 1
#define CLOTHID_AVX2 __attribute__((target("avx2")))
#else
#define CLOTHID_HAS_AVX2 0
#endif

// Before a loop of a fixed number of turns over what is to live in registers.
#define CLOTHID_UNROLL _Pragma("GCC unroll 8")

namespace clothid {

enum class InstructionSet { kCommon, kAvx2 };

inline InstructionSet BestInstructionSet() {
#if CLOTHID_HAS_AVX2
  static const bool has_avx2 = __builtin_cpu_supports("avx2");
  if (has_avx2) return InstructionSet::kAvx2;
#endif
  return InstructionSet::kCommon;
}

typedef double Double2 __attribute__((vector_size(2 * sizeof(double))));
typedef double Double4 __attribute__((vector_size(4 * sizeof(double))));
typedef float Float4 __attribute__((vector_size(4 * sizeof(float))));
typedef float Float8 __attribute__((vector_size(8 * sizeof(float))));

// kParts vectors beside each other.
template <typename Vector, int kParts>
struct Lanes {
  using Scalar = std::decay_t<decltype(std::declval<Vector>()[0])>;
  static constexpr int kPart = sizeof(Vector) / sizeof(Scalar);
  static constexpr int kSize = kParts * kPart;

  CLOTHID_ALWAYS_INLINE void SetZero() {
    CLOTHID_UNROLL
    for (int p = 0; p < kParts; ++p) parts[p] = Vector{};
  }

  // From and to any address, without alignment.
  CLOTHID_ALWAYS_INLINE void Load(const Scalar* from) {
    CLOTHID_UNROLL
    for (int p = 0; p < kParts; ++p) std::memcpy(&parts[p], from + p * kPart, sizeof(Vector));
  }
  CLOTHID_ALWAYS_INLINE void Store(Scalar* to) const {
    CLOTHID_UNROLL
    for (int p = 0; p < kParts; ++p) std::memcpy(to + p * kPart, &parts[p], sizeof(Vector));
  }

  CLOTHID_ALWAYS_INLINE void Add(const Lanes& a) {
    CLOTHID_UNROLL
    for (int p = 0; p < kParts; ++p) parts[p] += a.parts[p];
  }
  CLOTHID_ALWAYS_INLINE void Subtract(const Lanes& a) {
    CLOTHID_UNROLL
    for (int p = 0; p < kParts; ++p) parts[p] -= a.parts[p];
  }
  CLOTHID_ALWAYS_INLINE void Scale(Scalar a) {
    CLOTHID_UNROLL
    for (int p = 0; p < kParts; ++p) parts[p] *= a;
  }
  CLOTHID_ALWAYS_INLINE void AddProduct(const Lanes& a, const Lanes& b) {
    CLOTHID_UNROLL
    for (int p = 0; p < kParts; ++p) parts[p] += a.parts[p] * b.parts[p];
  }
  CLOTHID_ALWAYS_INLINE void AddProduct(const Lanes& a, Scalar b) {
    CLOTHID_UNROLL
    for (int p = 0; p < kParts; ++p) parts[p] += a.parts[p] * b;
  }
  CLOTHID_ALWAYS_INLINE void SubtractProduct(const Lanes& a, Scalar b) {
    CLOTHID_UNROLL
    for (int p = 0; p < kParts; ++p) parts[p] -= a.parts[p] * b;
  }

  // Folded in the middle again and again, so that the order of the additions does not depend on the vectors.
  CLOTHID_ALWAYS_INLINE Scalar Sum() const {
    Lanes a = *this;
    CLOTHID_UNROLL
    for (int half = kParts / 2; half > 0; half /= 2) {
      CLOTHID_UNROLL
      for (int p = 0; p < half; ++p) a.parts[p] += a.parts[p + half];
    }
    const Vector& v = a.parts[0];
    if constexpr (kPart == 2) return v[0] + v[1];
    if constexpr (kPart == 4) return (v[0] + v[2]) + (v[1] + v[3]);
    if constexpr (kPart == 8) return ((v[0] + v[4]) + (v[2] + v[6])) + ((v[1] + v[5]) + (v[3] + v[7]));
  }

  // Fixed indices alone stay in registers.
  CLOTHID_ALWAYS_INLINE Scalar operator[](int i) const { return parts[i / kPart][i % kPart]; }

  Vector parts[kParts];
};

// Four and eight numbers in the registers of an instruction set.
template <typename Scalar>
struct CommonLanes;
template <>
struct CommonLanes<double> {
  using Four = Lanes<Double2, 2>;
  using Eight = Lanes<Double2, 4>;
};
template <>
struct CommonLanes<float> {
  using Four = Lanes<Float4, 1>;
  using Eight = Lanes<Float4, 2>;
};
template <typename Scalar>
struct Avx2Lanes;
template <>
struct Avx2Lanes<double> {
  using Four = Lanes<Double4, 1>;
  using Eight = Lanes<Double4, 2>;
};
template <>
struct Avx2Lanes<float> {
  using Four = Lanes<Float4, 1>;
  using Eight = Lanes<Float8, 1>;
};

}  // namespace clothid

#endif  // CLOTHID_SIM_MATRIX_LANES_H_

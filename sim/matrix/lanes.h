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

typedef double Vector2 __attribute__((vector_size(2 * sizeof(double))));
typedef double Vector4 __attribute__((vector_size(4 * sizeof(double))));

// kParts vectors beside each other.
template <typename Vector, int kParts>
struct Lanes {
  static constexpr int kPart = sizeof(Vector) / sizeof(double);
  static constexpr int kSize = kParts * kPart;

  CLOTHID_ALWAYS_INLINE void SetZero() {
    CLOTHID_UNROLL
    for (int p = 0; p < kParts; ++p) parts[p] = Vector{};
  }

  // From and to any address, without alignment.
  CLOTHID_ALWAYS_INLINE void Load(const double* from) {
    CLOTHID_UNROLL
    for (int p = 0; p < kParts; ++p) std::memcpy(&parts[p], from + p * kPart, sizeof(Vector));
  }
  CLOTHID_ALWAYS_INLINE void Store(double* to) const {
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
  CLOTHID_ALWAYS_INLINE void Scale(double a) {
    CLOTHID_UNROLL
    for (int p = 0; p < kParts; ++p) parts[p] *= a;
  }
  CLOTHID_ALWAYS_INLINE void AddProduct(const Lanes& a, const Lanes& b) {
    CLOTHID_UNROLL
    for (int p = 0; p < kParts; ++p) parts[p] += a.parts[p] * b.parts[p];
  }
  CLOTHID_ALWAYS_INLINE void AddProduct(const Lanes& a, double b) {
    CLOTHID_UNROLL
    for (int p = 0; p < kParts; ++p) parts[p] += a.parts[p] * b;
  }
  CLOTHID_ALWAYS_INLINE void SubtractProduct(const Lanes& a, double b) {
    CLOTHID_UNROLL
    for (int p = 0; p < kParts; ++p) parts[p] -= a.parts[p] * b;
  }

  // Of eight: by halves, in an order that does not depend on the vectors.
  CLOTHID_ALWAYS_INLINE double Sum() const {
    static_assert(kSize == 8, "written out for eight");
    const Lanes& a = *this;
    return ((a[0] + a[4]) + (a[2] + a[6])) + ((a[1] + a[5]) + (a[3] + a[7]));
  }

  // Fixed indices alone stay in registers.
  CLOTHID_ALWAYS_INLINE double operator[](int i) const { return parts[i / kPart][i % kPart]; }

  Vector parts[kParts];
};

}  // namespace clothid

#endif  // CLOTHID_SIM_MATRIX_LANES_H_

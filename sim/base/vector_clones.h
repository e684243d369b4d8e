// How the loops over triangles become vector instructions without building for one machine alone.
//
// CLOTHID_VECTOR_CLONES before a function compiles it once for AVX2 and once for the common instruction set; the
// machine takes its own at the start of the program. Neither has a fused multiply-add, so both round alike: the numbers
// do not depend on the machine. The body must not touch Eigen, whose alignment depends on the instruction set, and may
// call what is CLOTHID_ALWAYS_INLINE alone, as another function would be compiled for the common set.
#ifndef CLOTHID_SIM_BASE_VECTOR_CLONES_H_
#define CLOTHID_SIM_BASE_VECTOR_CLONES_H_

// Programs choose between clones before the thread sanitizer is ready.
#if defined(__x86_64__) && defined(__gnu_linux__) && defined(__GNUC__) && !defined(__clang__) && \
    !defined(__SANITIZE_THREAD__)
#define CLOTHID_VECTOR_CLONES __attribute__((target_clones("avx2", "default")))
#else
#define CLOTHID_VECTOR_CLONES
#endif

#define CLOTHID_ALWAYS_INLINE inline __attribute__((always_inline))

#endif  // CLOTHID_SIM_BASE_VECTOR_CLONES_H_

// How a reverse sweep solves its linear systems, and what that took.
#ifndef CLOTHID_SIM_DERIVATIVE_ADJOINT_OPTIONS_H_
#define CLOTHID_SIM_DERIVATIVE_ADJOINT_OPTIONS_H_

#include <optional>

#include "sim/base/phase_seconds.h"

namespace clothid {

// How A^T z = w is solved at every step. Section 5.4 of the DiffCloth paper compares LU and kFixedPoint.
enum class AdjointMethod {
  kReduced,      // contacts eliminated, Cholesky of the symmetric rest, friction coupling by GMRES
  kLu,           // sparse LU of the whole step Jacobian (UMFPACK): the reference
  kFixedPoint,   // P z <- (dP + dR)^T z + w with the prefactored P of sim/cloth/system_matrix.h
  kSystemGmres,  // GMRES preconditioned by P, without restart
};

struct AdjointOptions {
  AdjointMethod method = AdjointMethod::kReduced;
  // Relative residual |w - A^T z|/|w| of the iterative methods; absent: `adjoint_tolerance` of the scene. It does not
  // depend on the d of the contact law, which the methods choose differently.
  std::optional<double> threshold = std::nullopt;
  bool use_kept_factors = true;  // kReduced: those of RolloutOptions::factor_memory, as preconditioners
};

// What a sweep took. A method that misses its threshold hands over to LU.
struct AdjointWork {
  int solves = 0;         // linear systems: one per step, more where substeps were taken
  int iterations = 0;     // of the slowest column, summed over the solves; a direct method has none
  int failed_solves = 0;  // in which LU stepped in
  // Wall time, s. Phases as in Table 1 of the paper: factorization and solution are its linear solve (with the steps
  // that LU took over), assembly its dP, contact its dR.
  PhaseSeconds phases;
  double total_seconds = 0.0;
  double fallback_seconds = 0.0;  // of LU where it stepped in; part of the phases

  double other_seconds() const { return total_seconds - phases.sum(); }
};

}  // namespace clothid

#endif  // CLOTHID_SIM_DERIVATIVE_ADJOINT_OPTIONS_H_

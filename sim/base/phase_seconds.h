// Where the time of a simulation goes. Seconds never enter a result.
#ifndef CLOTHID_SIM_BASE_PHASE_SECONDS_H_
#define CLOTHID_SIM_BASE_PHASE_SECONDS_H_

#include <chrono>

namespace clothid {

// Wall time of the phases of steps and of derivative sweeps, s.
struct PhaseSeconds {
  double evaluation = 0.0;     // forces, energy, gaps and the contact law
  double assembly = 0.0;       // K = P - dP
  double contact = 0.0;        // contacts taken out of K or added to it: dR
  double factorization = 0.0;  // numeric, and the analysis of a pattern that pairs have widened
  double solution = 0.0;       // of linear systems with a factor at hand, products with the matrix included

  double sum() const { return evaluation + assembly + contact + factorization + solution; }
};

inline PhaseSeconds operator-(const PhaseSeconds& a, const PhaseSeconds& b) {
  return {a.evaluation - b.evaluation, a.assembly - b.assembly, a.contact - b.contact,
          a.factorization - b.factorization, a.solution - b.solution};
}

// Of a clock that never goes back, since some moment.
inline double SteadySeconds() {
  return std::chrono::duration<double>(std::chrono::steady_clock::now().time_since_epoch()).count();
}

// Adds the time until its end to `seconds`.
class ScopedTimer {
 public:
  explicit ScopedTimer(double* seconds) : seconds_(seconds), start_(std::chrono::steady_clock::now()) {}
  ~ScopedTimer() { *seconds_ += std::chrono::duration<double>(std::chrono::steady_clock::now() - start_).count(); }
  ScopedTimer(const ScopedTimer&) = delete;
  ScopedTimer& operator=(const ScopedTimer&) = delete;

 private:
  double* seconds_;
  std::chrono::steady_clock::time_point start_;
};

}  // namespace clothid

#endif  // CLOTHID_SIM_BASE_PHASE_SECONDS_H_

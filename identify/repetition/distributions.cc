#include "identify/repetition/distributions.h"

#include <cmath>

#include "identify/repetition/monotone_root.h"

namespace clothid {
namespace {

constexpr double kPi = 3.141592653589793;

// P(|t| < sqrt(n) tan(angle)): a sum over odd or even powers of the cosine.
double StudentWithin(double angle, int n) {
  const double sine = std::sin(angle), cosine = std::cos(angle);
  const bool is_odd = n % 2 == 1;
  double term = is_odd ? cosine : 1.0, sum = 0.0;
  for (int k = is_odd ? 1 : 0; k <= n - 2; k += 2) {
    sum += term;
    term *= cosine * cosine * (k + 1.0) / (k + 2.0);
  }
  return is_odd ? 2.0 / kPi * (angle + sine * sum) : sine * sum;
}

}  // namespace

double StudentTwoSided(double value, int degrees_of_freedom) {
  return 1.0 - StudentWithin(std::atan(std::abs(value) / std::sqrt(degrees_of_freedom)), degrees_of_freedom);
}

double StudentHalfWidth95(int degrees_of_freedom) {
  const double angle = MonotoneRoot(
      [&](double candidate) { return StudentWithin(candidate, degrees_of_freedom) - 0.95; }, 0.0, 0.5 * kPi);
  return std::sqrt(degrees_of_freedom) * std::tan(angle);
}

double ChiSquareAbove(double value, int degrees_of_freedom) {
  if (!(value > 0.0)) return 1.0;
  const bool is_odd = degrees_of_freedom % 2 == 1;
  const double half = 0.5 * value;
  // Q(n + 2) = Q(n) + (x/2)^(n/2) e^(-x/2)/Gamma(n/2 + 1), the logarithm of the term against overflow.
  double above = is_odd ? std::erfc(std::sqrt(half)) : std::exp(-half);
  double log_term = (is_odd ? 0.5 * std::log(4.0 * half / kPi) : std::log(half)) - half;  // Gamma(3/2) = sqrt(pi)/2
  for (int n = is_odd ? 1 : 2; n < degrees_of_freedom; n += 2) {
    above += std::exp(log_term);
    log_term += std::log(half / (0.5 * n + 1.0));
  }
  return above;
}

}  // namespace clothid

#include "tools/benchmark/fits/rank_correlation.h"

#include <algorithm>
#include <cmath>
#include <numeric>
#include <stdexcept>

namespace clothid {
namespace {

constexpr double kPi = 3.14159265358979323846;

double Product(const std::vector<double>& x, const std::vector<double>& y) {
  return std::inner_product(x.begin(), x.end(), y.begin(), 0.0);
}

// The ranks less their mean, which is (n + 1)/2 whatever the ties.
std::vector<double> CentredRanks(const std::vector<double>& values) {
  std::vector<double> ranks = AverageRanks(values);
  const double mean = 0.5 * static_cast<double>(ranks.size() + 1);
  for (double& rank : ranks) rank -= mean;
  return ranks;
}

// The share of the orders of `y` whose product with `x` is as large as the given one.
double ExactPValue(const std::vector<double>& x, std::vector<double> y) {
  // Twice a centred rank is a whole number, so four times a product is one too, and half a unit is no tie.
  const double observed = std::abs(Product(x, y)) - 0.125;
  std::vector<std::size_t> order(y.size());
  std::iota(order.begin(), order.end(), 0);
  const std::vector<double> ranks = y;
  int num_orders = 0, num_as_large = 0;
  do {
    for (std::size_t i = 0; i < y.size(); ++i) y[i] = ranks[order[i]];
    ++num_orders;
    num_as_large += std::abs(Product(x, y)) >= observed;
  } while (std::next_permutation(order.begin(), order.end()));
  return static_cast<double>(num_as_large) / num_orders;
}

// P(|T| >= t) of Student's t with `degrees` of freedom, by its finite series in cos^2 of the angle with
// tan angle = t/sqrt(degrees) (Abramowitz and Stegun, 26.7.3 and 26.7.4).
double StudentPValue(double t, int degrees) {
  const double angle = std::atan(std::abs(t) / std::sqrt(degrees)), cosine = std::cos(angle);
  const bool is_odd = degrees % 2 == 1;
  double term = is_odd ? cosine : 1.0, sum = degrees == 1 ? 0.0 : term;
  for (int k = is_odd ? 3 : 2; k < degrees; k += 2) {
    term *= cosine * cosine * (k - 1) / k;
    sum += term;
  }
  const double inside = is_odd ? 2.0 / kPi * (angle + std::sin(angle) * sum) : std::sin(angle) * sum;
  return 1.0 - inside;
}

double ApproximatePValue(double rho, int num_pairs) {
  const double least = 2.0 / std::tgamma(num_pairs + 1.0);
  const double remainder = 1.0 - rho * rho;
  if (remainder <= 0.0) return least;
  return std::clamp(StudentPValue(rho * std::sqrt((num_pairs - 2) / remainder), num_pairs - 2), least, 1.0);
}

}  // namespace

std::vector<double> AverageRanks(const std::vector<double>& values) {
  std::vector<std::size_t> order(values.size());
  std::iota(order.begin(), order.end(), 0);
  std::sort(order.begin(), order.end(), [&](std::size_t a, std::size_t b) { return values[a] < values[b]; });
  std::vector<double> ranks(values.size());
  for (std::size_t first = 0, last; first < order.size(); first = last) {
    last = first + 1;
    while (last < order.size() && values[order[last]] == values[order[first]]) ++last;
    // The ranks first + 1 .. last.
    for (std::size_t i = first; i < last; ++i) ranks[order[i]] = 0.5 * static_cast<double>(first + 1 + last);
  }
  return ranks;
}

RankCorrelation SpearmanCorrelation(const std::vector<double>& x, const std::vector<double>& y) {
  const auto is_finite = [](double value) { return std::isfinite(value); };
  if (x.size() != y.size() || !std::all_of(x.begin(), x.end(), is_finite) ||
      !std::all_of(y.begin(), y.end(), is_finite)) {
    throw std::invalid_argument("a rank correlation takes finite pairs");
  }
  RankCorrelation correlation;
  const int num_pairs = static_cast<int>(x.size());
  const std::vector<double> rank_x = CentredRanks(x), rank_y = CentredRanks(y);
  const double square = Product(rank_x, rank_x) * Product(rank_y, rank_y);
  if (num_pairs < 3 || square == 0.0) return correlation;
  correlation.rho = std::clamp(Product(rank_x, rank_y) / std::sqrt(square), -1.0, 1.0);
  correlation.p_value =
      num_pairs <= kMaxExactPairs ? ExactPValue(rank_x, rank_y) : ApproximatePValue(correlation.rho, num_pairs);
  return correlation;
}

}  // namespace clothid

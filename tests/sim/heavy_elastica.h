// The closed form that clamped strips are held against.
#ifndef CLOTHID_TESTS_SIM_HEAVY_ELASTICA_H_
#define CLOTHID_TESTS_SIM_HEAVY_ELASTICA_H_

#include <Eigen/Core>
#include <cmath>

namespace clothid {

// The elastica of a strip under its own weight, which leaves the clamp horizontally. With s = arc length over L, t the
// angle below the horizontal and the load c = rho g L^3/D it is t'' = -c (1 - s) cos t, t(0) = 0, t'(1) = 0.
class HeavyElastica {
 public:
  HeavyElastica(double load, double length) : load_(load) {
    double low = 0.0, high = load;  // of t'(0); t'(1) rises with it
    for (int i = 0; i < 60; ++i) {
      const double middle = 0.5 * (low + high);
      (Integrate(middle)[1] > 0.0 ? high : low) = middle;
    }
    tip_ = length * Integrate(low).tail<2>();
  }

  Eigen::Vector2d tip() const { return tip_; }  // m, along and below the horizontal

 private:
  // t, t', and the way along and below the horizontal, at s = 1, by Runge-Kutta steps.
  Eigen::Vector4d Integrate(double slope) const {
    constexpr int kSteps = 1000;
    const double h = 1.0 / kSteps;
    Eigen::Vector4d y(0.0, slope, 0.0, 0.0);
    for (int i = 0; i < kSteps; ++i) {
      const double s = i * h;
      const Eigen::Vector4d k1 = Rate(s, y), k2 = Rate(s + 0.5 * h, y + 0.5 * h * k1),
                            k3 = Rate(s + 0.5 * h, y + 0.5 * h * k2), k4 = Rate(s + h, y + h * k3);
      y += h / 6.0 * (k1 + 2.0 * k2 + 2.0 * k3 + k4);
    }
    return y;
  }

  Eigen::Vector4d Rate(double s, const Eigen::Vector4d& y) const {
    return {y[1], -load_ * (1.0 - s) * std::cos(y[0]), std::cos(y[0]), std::sin(y[0])};
  }

  double load_;
  Eigen::Vector2d tip_;
};

}  // namespace clothid

#endif  // CLOTHID_TESTS_SIM_HEAVY_ELASTICA_H_

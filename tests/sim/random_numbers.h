// Random numbers that are the same on every machine: the distributions of the standard library are not.
#ifndef CLOTHID_TESTS_SIM_RANDOM_NUMBERS_H_
#define CLOTHID_TESTS_SIM_RANDOM_NUMBERS_H_

#include <Eigen/Core>
#include <Eigen/Geometry>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <numeric>
#include <random>
#include <utility>
#include <vector>

namespace clothid {

class RandomNumbers {
 public:
  explicit RandomNumbers(std::uint64_t seed) : generator_(seed) {}

  // [low, high), in 2^53 steps.
  double Uniform(double low, double high) {
    return low + (high - low) * std::ldexp(static_cast<double>(generator_() >> 11), -53);
  }
  int Integer(int low, int high) { return low + static_cast<int>(Uniform(0.0, high - low + 1.0)); }  // low .. high
  bool Chance(double probability) { return Uniform(0.0, 1.0) < probability; }
  // Every one of `octaves` doublings of `low` is equally likely.
  double OverOctaves(double low, int octaves) {
    const int octave = Integer(0, octaves - 1);
    return std::ldexp(low * Uniform(1.0, 2.0), octave);
  }

  Eigen::VectorXd InCube(Eigen::Index size) {  // [size], in (-1, 1)
    Eigen::VectorXd result(size);
    for (double& value : result) value = Uniform(-1.0, 1.0);
    return result;
  }
  Eigen::Vector3d Direction() { return OnSphere(3); }
  Eigen::Matrix3d Rotation() {
    const Eigen::Vector4d q = OnSphere(4);
    return Eigen::Quaterniond(q[0], q[1], q[2], q[3]).toRotationMatrix();
  }

  std::vector<int> Permutation(int size) {
    std::vector<int> result(static_cast<std::size_t>(size));
    std::iota(result.begin(), result.end(), 0);
    for (int i = size - 1; i > 0; --i) std::swap(result[i], result[Integer(0, i)]);
    return result;
  }

 private:
  Eigen::VectorXd OnSphere(Eigen::Index size) {
    for (;;) {
      const Eigen::VectorXd inside = InCube(size);
      const double norm = inside.norm();
      if (norm > 0.1 && norm < 1.0) return inside / norm;
    }
  }

  std::mt19937_64 generator_;
};

}  // namespace clothid

#endif  // CLOTHID_TESTS_SIM_RANDOM_NUMBERS_H_

// Random numbers of a draw that depend on nothing but seed, draw and what they are for.
#ifndef CLOTHID_IDENTIFY_PREDICTION_RANDOM_STREAMS_H_
#define CLOTHID_IDENTIFY_PREDICTION_RANDOM_STREAMS_H_

#include <Eigen/Core>
#include <cstdint>
#include <random>

namespace clothid {

enum class DrawStream : std::uint32_t { kParameters, kForces, kScale, kFiner, kNoise, kStart, kHandles };

class NormalStream {
 public:
  NormalStream(std::uint64_t seed, int draw, DrawStream stream) {
    constexpr std::uint32_t kPrediction = 0x9d1c;  // apart from the streams of datasets/synthetic
    std::seed_seq sequence{static_cast<std::uint32_t>(seed), static_cast<std::uint32_t>(seed >> 32), kPrediction,
                           static_cast<std::uint32_t>(draw), static_cast<std::uint32_t>(stream)};
    generator_.seed(sequence);
  }

  Eigen::MatrixXd Draw(Eigen::Index rows, Eigen::Index columns) {
    Eigen::MatrixXd values(rows, columns);
    for (double& value : values.reshaped()) value = normal_(generator_);
    return values;
  }

 private:
  std::mt19937_64 generator_;
  std::normal_distribution<double> normal_;
};

}  // namespace clothid

#endif  // CLOTHID_IDENTIFY_PREDICTION_RANDOM_STREAMS_H_

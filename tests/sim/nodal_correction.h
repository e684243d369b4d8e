// A correction for tests: seen nodes are drawn to where a recording has them.
#ifndef CLOTHID_TESTS_SIM_NODAL_CORRECTION_H_
#define CLOTHID_TESTS_SIM_NODAL_CORRECTION_H_

#include <Eigen/Core>
#include <cmath>
#include <memory>
#include <utility>
#include <vector>

#include "sim/rollout/correction.h"
#include "sim/rollout/rollout.h"
#include "sim/rollout/simulator.h"
#include "sim/scene/scene.h"

namespace clothid {

// A frame every `interval` steps, which lies at the share `place` of its step. It sees a point between two nodes in
// three and the one before each, P x = (1 - share) x_i + share x_{i-1},
//   A e = alpha g(e),   B e = beta/dt g(e),   g(e) = e/sqrt(1 + (e/limit)^2) per coordinate,
// so that far ones count less.
class NodalCorrection : public Correction {
 public:
  struct Gains {
    double alpha = 0.5, beta = 0.2;
    double limit = 0.01;  // m
    double place = 0.7;
    double share = 0.2;
  };

  // `measured`: x [3N] of every step, from step 0 on.
  NodalCorrection(std::vector<Eigen::VectorXd> measured, int interval, double time_step, const Gains& gains)
      : measured_(std::move(measured)), interval_(interval), frame_interval_(interval * time_step), gains_(gains) {}

  bool Corrects(int step) const override { return step % interval_ == 0; }

  void Evaluate(int step, const StepEnds& ends, Eigen::VectorXd* positions,
                Eigen::VectorXd* velocities) const override {
    const Eigen::ArrayXd e = Innovation(step, ends);
    const Eigen::VectorXd g = (e / (1.0 + (e / gains_.limit).square()).sqrt()).matrix();
    *positions = gains_.alpha * g;
    *velocities = gains_.beta / frame_interval_ * g;
  }

  void Times(int step, const StepEnds& ends, const Eigen::MatrixXd& start_changes, const Eigen::MatrixXd& end_changes,
             Eigen::MatrixXd* positions, Eigen::MatrixXd* velocities) const override {
    const Eigen::MatrixXd change =
        -(Slopes(step, ends).asDiagonal() * Seen((1.0 - gains_.place) * start_changes + gains_.place * end_changes));
    *positions = gains_.alpha * change;
    *velocities = gains_.beta / frame_interval_ * change;
  }

  void TimesTransposed(int step, const StepEnds& ends, const Eigen::MatrixXd& by_positions,
                       const Eigen::MatrixXd& by_velocities, Eigen::MatrixXd* by_start,
                       Eigen::MatrixXd* by_end) const override {
    const Eigen::MatrixXd change =
        -SeenTransposed(Slopes(step, ends).asDiagonal() *
                        (gains_.alpha * by_positions + gains_.beta / frame_interval_ * by_velocities));
    *by_start = (1.0 - gains_.place) * change;
    *by_end = gains_.place * change;
  }

 private:
  // P, zero for what is not seen, and its transpose.
  Eigen::MatrixXd Seen(const Eigen::MatrixXd& columns) const {
    Eigen::MatrixXd seen = Eigen::MatrixXd::Zero(columns.rows(), columns.cols());
    for (Eigen::Index row = 3; row < columns.rows(); row += 3) {
      if (row % 9 == 0) continue;
      seen.middleRows<3>(row) =
          (1.0 - gains_.share) * columns.middleRows<3>(row) + gains_.share * columns.middleRows<3>(row - 3);
    }
    return seen;
  }
  Eigen::MatrixXd SeenTransposed(const Eigen::MatrixXd& seen) const {
    Eigen::MatrixXd columns = Eigen::MatrixXd::Zero(seen.rows(), seen.cols());
    for (Eigen::Index row = 3; row < seen.rows(); row += 3) {
      if (row % 9 == 0) continue;
      columns.middleRows<3>(row) += (1.0 - gains_.share) * seen.middleRows<3>(row);
      columns.middleRows<3>(row - 3) += gains_.share * seen.middleRows<3>(row);
    }
    return columns;
  }

  Eigen::ArrayXd Innovation(int step, const StepEnds& ends) const {
    const double place = gains_.place;
    return Seen((1.0 - place) * (measured_[step - 1] - ends.start) + place * (measured_[step] - ends.end)).array();
  }

  Eigen::VectorXd Slopes(int step, const StepEnds& ends) const {
    return (1.0 + (Innovation(step, ends) / gains_.limit).square()).pow(-1.5).matrix();
  }

  std::vector<Eigen::VectorXd> measured_;
  int interval_;
  double frame_interval_;  // dt, s
  Gains gains_;
};

// Towards the rollout of `scene` with `true_parameters`.
inline std::shared_ptr<const NodalCorrection> CorrectionTowards(const Scene& scene, const Parameters& true_parameters,
                                                                int interval, const NodalCorrection::Gains& gains) {
  Simulator simulator(scene);
  std::vector<Eigen::VectorXd> measured;
  RolloutOptions options;
  options.visitor = [&](int, const Eigen::VectorXd& x) { measured.push_back(x); };
  Simulate(true_parameters, scene.num_steps(), &simulator, nullptr, options);
  return std::make_shared<NodalCorrection>(std::move(measured), interval, scene.time_step, gains);
}

}  // namespace clothid

#endif  // CLOTHID_TESTS_SIM_NODAL_CORRECTION_H_

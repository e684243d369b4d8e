// A force that nobody knows, on the cloth of a rollout: what the model lacks, as one draw of a random field.
//
// With white noise w over cloth and time (one axis, of unit density per area), areas a_i of the nodes, A = diag(a), and
// L the cotangent Laplacian,
//   z_n = (A + l^4 L^T A^-1 L)^-1 A^(1/2) w_n / c,   f_0 = s z_0,   f_{n+1} = r f_n + s sqrt(1 - r^2) z_{n+1},
// r = exp(-h/time), and c makes the mean variance of z over the free nodes one; handles have f = 0. So f has the
// standard deviation s, forgets itself after `time`, and is smooth over l = length sqrt(2/pi): the spectrum
// 1/(1 + (l k)^4)^2 has |f|^2/|grad f|^2 = pi/2 l^2. After every step v <- v + g h f/rho, rho the mass per area
// (sim/rollout/correction.h: what contacts leave of it). What is lacking may be the sum of several, each with a memory
// of its own.
//
// A model errs in forces that come of motion: air, strain and bending beyond those of its laws. A cloth that starts at
// rest, as it was laid or hung, begins without them. With d the root mean square of the way of its nodes from where
// they started and D `kMovedShare` of the size of the cloth
//   g = min(1, d/D),   dg = (x - x_0) . dx/(N D d) where d < D, else 0.
// One that starts in motion has g = 1 throughout.
#ifndef CLOTHID_IDENTIFY_PREDICTION_RANDOM_FORCE_H_
#define CLOTHID_IDENTIFY_PREDICTION_RANDOM_FORCE_H_

#include <Eigen/Core>
#include <Eigen/SparseCholesky>
#include <Eigen/SparseCore>
#include <cstdint>
#include <memory>
#include <vector>

#include "identify/checks/lasting_force.h"
#include "identify/prediction/random_streams.h"
#include "sim/cloth/cloth_model.h"
#include "sim/rollout/correction.h"

namespace clothid {

// z of a cloth; const functions may be called on several threads.
class SmoothField {
 public:
  // `length` > 0, m: that of `LastingForce`. Keeps no reference.
  SmoothField(const ClothModel& cloth, double length);

  // [N x c] of white noise [N x c] of variance one.
  Eigen::MatrixXd Smooth(const Eigen::MatrixXd& noise) const;

 private:
  std::vector<int> free_nodes_;
  Eigen::VectorXd roots_;                                      // a^(1/2) of the free nodes
  Eigen::SimplicialLDLT<Eigen::SparseMatrix<double>> factor_;  // over the free nodes
  double scale_ = 1.0;                                         // 1/c
};

// Changes of velocities by how far the cloth has moved.
class RandomForce : public Correction {
 public:
  static constexpr double kMovedShare = 0.05;

  // None over `num_steps` steps of the scene of `cloth`.
  RandomForce(const ClothModel& cloth, int num_steps);

  // Adds a draw, numbers of `stream`, to a cloth that has the masses of `material`.
  void Add(const LastingForce& force, const SmoothField& field, const ClothModel& cloth, const Material& material,
           NormalStream* stream);

  bool Corrects(int step) const override { return step >= 1 && step <= changes_.cols(); }
  void Evaluate(int step, const StepEnds& ends, Eigen::VectorXd* positions, Eigen::VectorXd* velocities) const override;
  void Times(int step, const StepEnds& ends, const Eigen::MatrixXd& start_changes, const Eigen::MatrixXd& end_changes,
             Eigen::MatrixXd* positions, Eigen::MatrixXd* velocities) const override;
  void TimesTransposed(int step, const StepEnds& ends, const Eigen::MatrixXd& by_positions,
                       const Eigen::MatrixXd& by_velocities, Eigen::MatrixXd* by_start,
                       Eigen::MatrixXd* by_end) const override;

 private:
  // d [m].
  double MovedBy(const Eigen::VectorXd& positions) const;
  // g, and its gradient [3N] by the positions.
  double Share(const Eigen::VectorXd& positions) const;
  Eigen::VectorXd ShareGradient(const Eigen::VectorXd& positions) const;

  Eigen::MatrixXd changes_;  // [3N x T] m/s where g = 1, zero at handles
  Eigen::VectorXd start_;    // x_0 [3N] m; empty: the cloth starts in motion
  double reach_ = 0.0;       // D, m
};

// The forces that a model lacks, on one cloth; const functions may be called on several threads.
class ForceSource {
 public:
  // Draws are the sum of one of each of `parts`. Keeps no reference.
  ForceSource(std::vector<LastingForce> parts, const ClothModel& cloth);

  // Draw `draw` of all parts times `factor`, as above. It depends on nothing else.
  std::shared_ptr<const Correction> Draw(double factor, const ClothModel& cloth, const Material& material,
                                         int num_steps, std::uint64_t seed, int draw) const;

 private:
  std::vector<LastingForce> parts_;
  std::vector<std::unique_ptr<SmoothField>> fields_;  // of every part
};

}  // namespace clothid

#endif  // CLOTHID_IDENTIFY_PREDICTION_RANDOM_FORCE_H_

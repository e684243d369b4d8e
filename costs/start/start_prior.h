// What is believed of the start of a cloth before anything is measured, as a quadratic form of its unknowns.
// Internal to costs/start; the formulas stand in costs/start/unknown_start.h.
#ifndef CLOTHID_COSTS_START_START_PRIOR_H_
#define CLOTHID_COSTS_START_START_PRIOR_H_

#include <Eigen/Core>

#include "datasets/motion/recorded_motion.h"
#include "sim/cloth/cloth_model.h"
#include "sim/scene/scene.h"

namespace clothid {

// 1/2 s^T precision s - information^T s.
struct QuadraticPrior {
  Eigen::MatrixXd precision;    // P [n x n]
  Eigen::VectorXd information;  // [n]
};

// What the handles do to the cloth about them.
struct HandleCoupling {
  Eigen::MatrixXd response;   // psi [N x H]: by how much nodes go along, 1 at a handle itself and 0 at the others
  Eigen::MatrixXd stiffness;  // A_hh + A_hf psi_f [H x H]: what offsets of handles cost once the cloth has gone along

  // The `count` <= H patterns of offsets that cost least, orthonormal [H x count]; all: one handle each.
  Eigen::MatrixXd SmoothestOffsets(Eigen::Index count) const;
};

// The cloth of a scene with bending, all of whose nodes are free: energies of shapes and of their changes.
class ShapePrior {
 public:
  explicit ShapePrior(const Scene& scene);

  const ClothModel& model() const { return model_; }

  // Of x_0 = base + D s and of v_0 = base + D s, D [3N x n]: adds to the block of `prior` that starts at `first`.
  void AddPositions(const Eigen::VectorXd& base, const Eigen::MatrixXd& directions, Eigen::Index first,
                    QuadraticPrior* prior) const;
  void AddVelocities(const Eigen::VectorXd& base_positions, const Eigen::VectorXd& base,
                     const Eigen::MatrixXd& directions, Eigen::Index first, QuadraticPrior* prior) const;

  HandleCoupling CoupleHandles(const RecordedMotion& motion) const;

 private:
  // The Hessian of both energies with these weights, at positions [3N], times columns [3N x n].
  Eigen::MatrixXd TimesHessian(double stretch, double bending, const Eigen::VectorXd& positions,
                               const Eigen::MatrixXd& columns) const;

  Scene scene_;
  ClothModel model_;
  double mean_area_ = 0.0;  // of triangles, m^2
};

// The measurements of the handles: `weights` [K x B] takes the values at B knots to the times of measurement. The
// values, ordered as in `SensitivityDirections::handle_offsets`, are `along` [3HB x n] times the unknowns from `first`
// on.
void AddHandleMeasurements(const HandleMeasurements& measured, const Eigen::MatrixXd& weights,
                           const Eigen::MatrixXd& along, Eigen::Index first, QuadraticPrior* prior);

}  // namespace clothid

#endif  // CLOTHID_COSTS_START_START_PRIOR_H_

// The objective that a starting shape minimizes (datasets/motion/start_state.h), its gradient and its Newton step.
// Internal to datasets/motion.
#ifndef CLOTHID_DATASETS_MOTION_SHAPE_PROBLEM_H_
#define CLOTHID_DATASETS_MOTION_SHAPE_PROBLEM_H_

#include <Eigen/Core>
#include <vector>

#include "datasets/motion/recorded_motion.h"
#include "sim/cloth/cloth_model.h"
#include "sim/matrix/cholesky.h"
#include "sim/obstacle/obstacle.h"
#include "sim/scene/scene.h"

namespace clothid {

// What a shape is to follow: misfits w_p |x_p - y_p|^2.
struct ShapeTargets {
  const std::vector<ObservedPoint>* points = nullptr;
  Eigen::MatrixXd values;   // [3 x P], NaN: none
  Eigen::VectorXd weights;  // [P]
  bool is_robust = false;
};

// Of the energies and of what stands inside obstacles; 0: left out.
struct ShapeWeights {
  double stretch = 0.0, bending = 0.0, penetration = 0.0;
};

// Over the free nodes; the Hessian is positive semidefinite.
class ShapeProblem {
 public:
  // `targets.points` must outlive the problem.
  ShapeProblem(const Scene& scene, ShapeTargets targets);

  const ClothModel& model() const { return model_; }
  double data_weight() const { return data_weight_; }  // per node
  // The bending weight that counts as much as the data times `share`.
  double BendingWeight(double share) const {
    return bending_diagonal_ > 0.0 ? share * data_weight_ / bending_diagonal_ : 0.0;
  }

  // The misfits of the targets, ascending.
  std::vector<double> Misfits(const Eigen::VectorXd& positions) const;
  // `positions` [3N] m; `gradient` [3N] may be null.
  double Objective(const ShapeWeights& weights, const Eigen::VectorXd& positions, Eigen::VectorXd* gradient) const;
  // -Hessian^-1 gradient over the free nodes [3 Nf]; empty where the Hessian is singular.
  Eigen::VectorXd Step(const ShapeWeights& weights, const Eigen::VectorXd& positions, const Eigen::VectorXd& gradient);
  // Signed distance to what is nearest, from its contact distance; positive infinity without obstacles.
  SurfacePoint Nearest(const Eigen::Vector3d& position) const;

 private:
  Eigen::Vector3d Misfit(std::size_t p, const Eigen::VectorXd& positions) const;
  double LossWeight(double weight, const Eigen::Vector3d& misfit) const;
  void AddPenetrationForces(double weight, const Eigen::VectorXd& positions, Eigen::VectorXd* force,
                            double* energy) const;
  void AddTargets(const Eigen::VectorXd& positions, BlockMatrix* hessian) const;
  void AddPenetrations(double weight, const Eigen::VectorXd& positions, BlockMatrix* hessian) const;

  Scene scene_;
  SurfacesAt surfaces_;  // at the start
  ShapeTargets targets_;
  ClothModel model_;
  CholeskySolver solver_;
  double data_weight_ = 0.0;
  double bending_diagonal_ = 0.0;
};

}  // namespace clothid

#endif  // CLOTHID_DATASETS_MOTION_SHAPE_PROBLEM_H_

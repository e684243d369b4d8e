// How the contacts of a cloth with itself depend on where a solve starts and on their friction
// (sim/contact/self_contact.h): with w, n and gap functions of x_n,
//   dg  = .. - sum_c dw_i r        at node i of a pair, at fixed v and r
//   dR  = (dR/dx_n) dx_n + (dR/dmu) dmu
#ifndef CLOTHID_SIM_DERIVATIVE_PAIR_DERIVATIVE_H_
#define CLOTHID_SIM_DERIVATIVE_PAIR_DERIVATIVE_H_

#include <Eigen/Core>
#include <vector>

#include "sim/cloth/cloth_model.h"
#include "sim/contact/self_contact.h"

namespace clothid {

// The rows of a pair's nodes, zero of handles, and their sum into those of the free nodes [3 Nf x s].
using PairColumns = Eigen::Matrix<double, 12, Eigen::Dynamic>;
PairColumns GatherFromPair(const PairCandidate& pair, const Eigen::MatrixXd& columns);
void ScatterToPair(const PairCandidate& pair, const PairColumns& values, Eigen::MatrixXd* columns);

class PairDerivative {
 public:
  // `contacts` of a solve from `start_positions` x_n that ends with `velocities` [3N]. The model must outlive this.
  PairDerivative(const ClothModel& model, std::vector<PairContact> contacts, const Eigen::VectorXd& start_positions,
                 const Eigen::VectorXd& velocities, double friction_coefficient);

  const std::vector<PairContact>& contacts() const { return contacts_; }
  const PairGeometryGradient& gradient(std::size_t contact) const { return gradients_[contact]; }

  // On columns [3 Nf x s]: the part of dg [3 Nf x s], and dR by x_n [3c x s].
  Eigen::MatrixXd TimesWeights(const Eigen::MatrixXd& columns) const;
  Eigen::MatrixXd TimesGeometry(const Eigen::MatrixXd& columns) const;
  // Their transposes.
  Eigen::MatrixXd TimesWeightsTransposed(const Eigen::MatrixXd& columns) const;
  Eigen::MatrixXd TimesGeometryTransposed(const Eigen::MatrixXd& rows) const;

  // dR/dmu [3c].
  Eigen::VectorXd FrictionDerivative() const;

 private:
  const ClothModel& model_;
  std::vector<PairContact> contacts_;
  std::vector<PairGeometryGradient> gradients_;
  std::vector<Eigen::Matrix<double, 3, 12>> jacobians_;  // dR/dx_n
};

}  // namespace clothid

#endif  // CLOTHID_SIM_DERIVATIVE_PAIR_DERIVATIVE_H_

// How sure a fit of fields is, and how smooth they should be, from the curvature H = J^T J + lambda P at one point
// (field_model.h).
//
// J^T J is taken over a basis V of fields that are bilinear on a coarser control grid, of at most so many nodes a side:
// posteriors are smooth, and the prior means the same on any grid. One forward sweep with a column each gives
// G = V^T J^T J V. Where the control grid is no finer V is the identity, and nothing is lost.
//   covariance     = s^2 V (G + lambda V^T P V)^-1 V^T,   s^2 = 2 L/(m - gamma), at least 1 where sigma is known
//   determined     gamma = sum over i of h_i/(h_i + lambda),   h_i the eigenvalues of G relative to V^T P V
//   weight         lambda = s^2 gamma/(theta^T P theta): where the marginal likelihood is stationary (MacKay 1992),
//   with
//                  theta and L where the linear model has its minimum for that lambda: they follow lambda, and what is
//                  left of an unfinished fit does not go into it
#ifndef CLOTHID_IDENTIFY_FIELD_FIELD_POSTERIOR_H_
#define CLOTHID_IDENTIFY_FIELD_FIELD_POSTERIOR_H_

#include <Eigen/Core>
#include <vector>

#include "identify/field/field_model.h"
#include "identify/field/field_result.h"
#include "identify/uncertainty/uncertainty.h"

namespace clothid {

class FieldCurvature {
 public:
  // At a point that the model is at, a basis of at most `most_per_side` nodes along each side of a control grid.
  FieldCurvature(int most_per_side, FieldModel* model, FieldPoint* point);

  // s^2 of a cost L of the recordings, with weight lambda.
  double SquaredScale(double data_cost, double weight) const;
  // gamma; the unknowns beside the fields and their means count as determined.
  double NumDetermined(double weight) const;
  // The next lambda of the fixed point, from `weight` > 0, at the point that the model is at: theta [n], its cost L and
  // gradient of L [p + n]. Within what the recordings can be told from.
  double NextWeight(const Eigen::VectorXd& theta, const Eigen::VectorXd& data_gradient, double data_cost,
                    double weight) const;
  // Beyond which the fields are as good as flat.
  double LargestWeight() const;

  // Fills the standard deviations of `fields`.
  void AddDeviations(double data_cost, double weight, std::vector<FittedField>* fields) const;
  // The problem in the coordinates of all blocks that are not frozen, everything else eliminated; columns of the frozen
  // ones are zero. For `EstimateUncertainty`.
  Linearization Marginal(double weight, FieldPoint* point) const;

  const Eigen::MatrixXd& basis() const { return basis_; }
  Eigen::MatrixXd Covariance(double weight) const;  // of the basis' coordinates, over s^2 [c x c]

 private:
  FieldModel* model_;
  Eigen::MatrixXd basis_;         // V [(p + n) x c]
  Eigen::MatrixXd gram_, prior_;  // G and V^T P V [c x c]
  Eigen::MatrixXd means_;         // of every field, per coordinate of the basis [K x c]
  Eigen::VectorXd eigenvalues_;   // h
};

}  // namespace clothid

#endif  // CLOTHID_IDENTIFY_FIELD_FIELD_POSTERIOR_H_

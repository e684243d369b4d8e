// How sure a fit of fields is, and how smooth they should be, from the curvature H = J^T J + lambda P at one point
// (field_model.h).
//
// J^T J is taken over a basis V: the parameters, and the smoothest modes of every field (field_prior.h), of at most so
// many half waves along either side. In the others there is what the prior says: recordings tell of the smoothest modes
// most, and the prior keeps the others small. One forward sweep with a column each gives G = V^T J^T J V. Where the
// control grid has no more modes nothing is lost.
//   covariance     = s^2 V (G + lambda V^T P V)^-1 V^T,   s^2 = 2 L/(m - gamma), at least 1 where sigma is known
//   determined     gamma = sum over i of h_i/(h_i + lambda),   h_i the eigenvalues of G relative to V^T P V
//   weight         lambda = s^2 gamma/(theta^T P theta): where the marginal likelihood is stationary (MacKay 1992),
//   with
//                  theta and L where the linear model has its minimum for that lambda: they follow lambda, and what is
//                  left of an unfinished fit does not go into it. gamma and theta^T P theta are those of the basis'
//                  modes alone: with the roughness of modes that gamma does not count lambda falls and falls.
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
  // At a point that the model is at.
  FieldCurvature(int modes_per_side, FieldModel* model, FieldPoint* point);

  // s^2 of a cost L of the recordings, with weight lambda.
  double SquaredScale(double data_cost, double weight) const;
  // gamma; the unknowns beside the fields and their means count as determined.
  double NumDetermined(double weight) const;
  // The next lambda of the fixed point, from `weight` > 0, at the point that the model is at: theta [n], its cost L and
  // gradient of L [p + n]. Within what the recordings can be told from.
  double NextWeight(const Eigen::VectorXd& theta, const Eigen::VectorXd& data_gradient, double data_cost,
                    double weight) const;
  // As far as that leads from `weight` at a step of the fit. Without one, 0, as good as flat: what a wrong level and
  // wrong parameters leave unexplained must not become a field. Then less and less smooth, a tenth at the least.
  double FollowWeight(const Eigen::VectorXd& theta, const Eigen::VectorXd& data_gradient, double data_cost,
                      double weight) const;
  // Where the linear model has its minimum over the basis, from theta and the parameters that the gradient is of, but
  // for the parameters `held` among the scalars: the step in coordinates of the basis [c].
  Eigen::VectorXd Step(const Eigen::VectorXd& theta, const Eigen::VectorXd& data_gradient, double weight,
                       const std::vector<int>& held = {}) const;
  // Beyond which the fields are as good as flat.
  double LargestWeight() const;

  // Fills the standard deviations of `fields`.
  void AddDeviations(double data_cost, double weight, std::vector<FittedField>* fields) const;
  // The problem in the coordinates of all blocks that are not frozen, everything else eliminated; columns of the frozen
  // ones are zero. For `EstimateUncertainty`.
  Linearization Marginal(double weight, FieldPoint* point) const;

  const Eigen::MatrixXd& basis() const { return basis_; }
  // Whether the basis has all modes.
  bool is_complete() const { return basis_.cols() == basis_.rows(); }
  // V^T H V [c x c].
  Eigen::MatrixXd Hessian(double weight) const { return gram_ + weight * prior_; }
  // Of the basis' coordinates, over s^2 [c x c]; zero for the scalars `held`.
  Eigen::MatrixXd Covariance(double weight, const std::vector<int>& held = {}) const;

 private:
  // Of the fields theta in the basis [c], zero for the scalars.
  Eigen::VectorXd Coordinates(const Eigen::VectorXd& theta) const;

  FieldModel* model_;
  int modes_per_side_;
  Eigen::MatrixXd basis_;         // V [(p + n) x c]
  Eigen::MatrixXd gram_, prior_;  // G and V^T P V [c x c]
  Eigen::MatrixXd means_;         // of every field, per coordinate of the basis [K x c]
  Eigen::VectorXd eigenvalues_;   // h
};

}  // namespace clothid

#endif  // CLOTHID_IDENTIFY_FIELD_FIELD_POSTERIOR_H_

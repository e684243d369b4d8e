#include "identify/field/field_posterior.h"

#include <algorithm>
#include <cmath>

#include "identify/field/field_prior.h"
#include "sim/matrix/dense.h"

namespace clothid {
namespace {

// The logarithm of a level that nothing tells has this standard deviation: a factor of 1e4 up or down.
constexpr double kLevelStd = 9.2;
// The weight is looked for between the largest of h, beyond which the field is as good as flat, and this share of it.
constexpr double kSmallestWeight = 1e-12;
constexpr int kMostWeights = 10;      // of the fixed point at once
constexpr double kWeightShare = 0.1;  // of the last lambda, the least that the next may be

}  // namespace

FieldCurvature::FieldCurvature(int modes_per_side, FieldModel* model, FieldPoint* point)
    : model_(model), modes_per_side_(modes_per_side) {
  const int num_scalars = model->num_scalars();
  std::vector<Eigen::MatrixXd> parts;
  Eigen::Index num_columns = num_scalars;
  for (const FieldRequest& request : model->requests()) {
    parts.push_back(SmoothModes(request.rows, request.columns, modes_per_side));
    num_columns += parts.back().cols();
  }
  basis_ = Eigen::MatrixXd::Zero(model->size(), num_columns);
  basis_.topLeftCorner(num_scalars, num_scalars).setIdentity();
  means_ = Eigen::MatrixXd::Zero(static_cast<Eigen::Index>(parts.size()), num_columns);
  Eigen::Index row = num_scalars, column = num_scalars;
  for (std::size_t k = 0; k < parts.size(); ++k) {
    basis_.block(row, column, parts[k].rows(), parts[k].cols()) = parts[k];
    means_.row(static_cast<Eigen::Index>(k)).segment(column, parts[k].cols()) = parts[k].colwise().mean();
    row += parts[k].rows();
    column += parts[k].cols();
  }
  gram_ = model->Gram(basis_, point);
  const Eigen::MatrixXd of_fields = basis_.bottomRows(model->num_field_unknowns());
  prior_ = of_fields.transpose() * (model->prior_matrix() * of_fields);
  // Relative to the prior, without the directions of which it says nothing: the unknowns beside, and means.
  const Spectrum prior = SymmetricSpectrum(prior_);
  const Eigen::Index num_free = num_scalars + static_cast<Eigen::Index>(parts.size());
  const Eigen::Index num_told = num_columns - num_free;
  const Eigen::MatrixXd told =
      prior.vectors.rightCols(num_told) * prior.values.tail(num_told).cwiseSqrt().cwiseInverse().asDiagonal();
  const Eigen::MatrixXd relative = told.transpose() * gram_ * told;
  eigenvalues_ = SymmetricEigenvalues(relative);
}

double FieldCurvature::NumDetermined(double weight) const {
  const double num_free = static_cast<double>(basis_.cols() - eigenvalues_.size());
  return num_free + (eigenvalues_.array().max(0.0) / (eigenvalues_.array().max(0.0) + weight)).sum();
}

double FieldCurvature::SquaredScale(double data_cost, double weight) const {
  const double degrees = std::max(1.0, model_->num_measurements() - NumDetermined(weight));
  const double fitted = 2.0 * data_cost / degrees;
  return model_->sigma_is_known() ? std::max(1.0, fitted) : fitted;
}

double FieldCurvature::LargestWeight() const {
  return eigenvalues_.size() == 0 ? 1.0 : std::max(eigenvalues_.maxCoeff(), 1e-300);
}

Eigen::VectorXd FieldCurvature::Coordinates(const Eigen::VectorXd& theta) const {
  Eigen::VectorXd coordinates = basis_.bottomRows(theta.size()).transpose() * theta;
  coordinates.head(model_->num_scalars()).setZero();
  return coordinates;
}

Eigen::VectorXd FieldCurvature::Step(const Eigen::VectorXd& theta, const Eigen::VectorXd& data_gradient, double weight,
                                     const std::vector<int>& held) const {
  const Eigen::VectorXd gradient = basis_.transpose() * data_gradient + weight * (prior_ * Coordinates(theta));
  return -(Covariance(weight, held) * gradient);
}

double FieldCurvature::NextWeight(const Eigen::VectorXd& theta, const Eigen::VectorXd& data_gradient, double data_cost,
                                  double weight) const {
  if (eigenvalues_.size() == 0) return weight;
  // Where the linear model has its minimum over the modes.
  const Eigen::VectorXd step = Step(theta, data_gradient, weight);
  const Eigen::VectorXd there = Coordinates(theta) + step;
  const double roughness = there.dot(prior_ * there);
  const double slope = (basis_.transpose() * data_gradient).dot(step);
  const double lowest = std::max(0.0, data_cost + slope + 0.5 * step.dot(gram_ * step));
  const double determined = NumDetermined(weight) - static_cast<double>(basis_.cols() - eigenvalues_.size());
  const double next = SquaredScale(lowest, weight) * determined / std::max(roughness, 1e-300);
  return std::clamp(next, kSmallestWeight * LargestWeight(), LargestWeight());
}

double FieldCurvature::FollowWeight(const Eigen::VectorXd& theta, const Eigen::VectorXd& data_gradient,
                                    double data_cost, double weight) const {
  if (!(weight > 0.0)) return LargestWeight();
  double next = weight;
  for (int i = 0; i < kMostWeights; ++i) next = NextWeight(theta, data_gradient, data_cost, next);
  return std::max(next, kWeightShare * weight);
}

Eigen::MatrixXd FieldCurvature::Covariance(double weight, const std::vector<int>& held) const {
  Eigen::MatrixXd curvature = gram_ + weight * prior_ + means_.transpose() * means_ / (kLevelStd * kLevelStd);
  for (int i = 0; i < model_->num_scalars(); ++i) {  // what nothing tells is within its bounds
    curvature(i, i) += std::pow(model_->blocks()[model_->scalars()[i]].CoordinateRange(), -2);
  }
  for (const int i : held) {
    curvature.row(i).setZero();
    curvature.col(i).setZero();
    curvature(i, i) = 1.0;
  }
  Eigen::MatrixXd covariance = SymmetricFactor(curvature).Inverse();
  for (const int i : held) covariance(i, i) = 0.0;
  return covariance;
}

void FieldCurvature::AddDeviations(double data_cost, double weight, std::vector<FittedField>* fields) const {
  const double scale = SquaredScale(data_cost, weight);
  const Eigen::MatrixXd covariance = scale * Covariance(weight);
  // Of deviations from the mean: a strong belief in the mean takes it out of the prior.
  const double strong = 1e6 * std::max(weight * prior_.diagonal().maxCoeff(), 1e-300);
  Eigen::MatrixXd belief = weight * prior_ + strong * means_.transpose() * means_;
  belief.topLeftCorner(model_->num_scalars(), model_->num_scalars()).diagonal().array() += strong;
  const Eigen::MatrixXd prior_covariance = scale * SymmetricFactor(belief).Inverse();
  Eigen::Index row = model_->num_scalars();
  for (std::size_t k = 0; k < fields->size(); ++k) {
    FittedField& field = (*fields)[k];
    const FieldRequest& request = field.request;
    const Eigen::MatrixXd values = basis_.middleRows(row, request.size());
    const Eigen::MatrixXd deviations = values.rowwise() - means_.row(static_cast<Eigen::Index>(k));
    // Of the modes beyond the basis there is the prior.
    const Eigen::VectorXd rough = scale / weight * RoughVariances(request.rows, request.columns, modes_per_side_);
    const auto deviation_of = [&](const Eigen::MatrixXd& weights, const Eigen::MatrixXd& matrix) -> Eigen::MatrixXd {
      const Eigen::VectorXd variances = (weights * matrix).cwiseProduct(weights).rowwise().sum() + rough;
      const Eigen::VectorXd roots = variances.cwiseMax(0.0).cwiseSqrt();
      return roots.reshaped(request.columns, request.rows).transpose();
    };
    field.log_std = deviation_of(values, covariance);
    field.deviation_std = deviation_of(deviations, covariance);
    field.prior_deviation_std = deviation_of(deviations, prior_covariance);
    row += request.size();
  }
}

Linearization FieldCurvature::Marginal(double weight, FieldPoint* point) const {
  std::vector<int> free_blocks;
  const Eigen::MatrixXd of_basis = model_->BlockWeights(&free_blocks) * basis_;
  const Eigen::MatrixXd with_all = Covariance(weight) * of_basis.transpose();
  // How all unknowns follow the blocks.
  const Eigen::MatrixXd follow = basis_ * (with_all * SymmetricFactor(of_basis * with_all).Inverse());
  std::vector<Eigen::MatrixXd> scores;
  Eigen::MatrixXd curvature = model_->Gram(follow, point, &scores);
  const Eigen::MatrixXd rough = model_->prior_root() * follow.bottomRows(model_->num_field_unknowns());
  curvature += weight * rough.transpose() * rough;
  const Eigen::Index num_blocks = static_cast<Eigen::Index>(model_->blocks().size());
  Linearization all;
  all.jacobian = Eigen::MatrixXd::Zero(curvature.rows(), num_blocks);
  const Eigen::MatrixXd rows = TransposedRoot(curvature);
  for (std::size_t i = 0; i < free_blocks.size(); ++i) {
    all.jacobian.col(free_blocks[i]) = rows.col(static_cast<Eigen::Index>(i));
  }
  all.gradient = Eigen::VectorXd::Zero(num_blocks);
  for (const Eigen::MatrixXd& own : scores) {
    Eigen::MatrixXd wide = Eigen::MatrixXd::Zero(num_blocks, own.cols());
    for (std::size_t i = 0; i < free_blocks.size(); ++i) {
      wide.row(free_blocks[i]) = own.row(static_cast<Eigen::Index>(i));
    }
    all.frame_scores.push_back(std::move(wide));
  }
  for (const FieldRecordingPoint& at : point->recordings) {
    all.squared_residual += at.cost.WeightedResiduals().squaredNorm();
  }
  all.num_measurements = model_->num_measurements();
  all.sigma_is_known = model_->sigma_is_known();
  return all;
}

}  // namespace clothid

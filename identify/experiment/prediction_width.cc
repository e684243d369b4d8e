#include "identify/experiment/prediction_width.h"

#include <algorithm>
#include <cmath>

#include "identify/experiment/cloth_information.h"
#include "sim/base/error.h"
#include "sim/cloth/cloth_model.h"
#include "sim/derivative/sensitivity.h"
#include "sim/matrix/dense.h"
#include "sim/rollout/simulator.h"

namespace clothid {

MotionToPredict::MotionToPredict(const Candidate& predicted) : name_(predicted.name), blocks_(predicted.blocks) {
  if (blocks_.empty()) FailOnData(predicted.path, "expected a scene that has some of the fitted parameters");
  Scene scene = predicted.scene;
  Parameters parameters = scene.nominal_parameters();
  SensitivityDirections directions;
  Eigen::VectorXd by_coordinate(static_cast<Eigen::Index>(blocks_.size()));
  for (std::size_t i = 0; i < blocks_.size(); ++i) {
    const ParameterBlock& block = blocks_[i];
    directions.parameters.push_back(ParseParameter(block.name, scene));
    SetParameter(directions.parameters.back(), block.start, &parameters);
    by_coordinate[static_cast<Eigen::Index>(i)] =
        block.frozen ? 0.0 : block.ValueDerivative(block.ToCoordinate(block.start));
  }
  scene.SetMaterials(parameters);
  Simulator simulator(scene);
  simulator.UseParameters(parameters);
  gram_.setZero(by_coordinate.size(), by_coordinate.size());
  double num_rows = 0.0;
  const auto visit = [&](int step, const Eigen::VectorXd& /*positions*/, const Eigen::MatrixXd& derivative) {
    if (step == 0) return;
    const Eigen::MatrixXd by_q = derivative * by_coordinate.asDiagonal();  // zero at handles
    gram_ += by_q.transpose() * by_q;
    num_rows += 3.0 * simulator.model().num_free();
  };
  const SensitivityResult result = PushForward(parameters, scene.num_steps(), directions, visit, &simulator);
  if (result.failure) FailOnData(predicted.path, "cannot be simulated: " + result.failure->ToString());
  gram_ /= std::max(num_rows, 1.0);
}

double MotionToPredict::BelievedWidth() const {
  double square = 0.0;
  for (Eigen::Index i = 0; i < gram_.rows(); ++i) {
    square += gram_(i, i) * std::pow(StdBefore(blocks_[static_cast<std::size_t>(i)]), 2);
  }
  return std::sqrt(square);
}

Eigen::MatrixXd MotionToPredict::Covariance(const ClothRows& cloth, const Eigen::VectorXd& step_errors) const {
  const Eigen::Index size = cloth.rows.cols();
  Eigen::MatrixXd precision = cloth.rows.transpose() * cloth.rows;
  for (Eigen::Index i = 0; i < size; ++i) {
    precision(i, i) += std::pow(StdBefore(cloth.blocks[static_cast<std::size_t>(i)]), -2);
  }
  Eigen::MatrixXd told = SymmetricFactor(precision).Inverse();
  for (Eigen::Index i = 0; i < step_errors.size(); ++i) {
    if (!std::isnan(step_errors[i])) told(i, i) += step_errors[i] * step_errors[i];
  }
  const auto num = static_cast<Eigen::Index>(blocks_.size());
  std::vector<Eigen::Index> place(blocks_.size(), -1);  // in the recording's fit
  for (Eigen::Index j = 0; j < size; ++j) {
    for (std::size_t i = 0; i < blocks_.size(); ++i) {
      if (cloth.blocks[static_cast<std::size_t>(j)].name == blocks_[i].name) place[i] = j;
    }
  }
  Eigen::MatrixXd covariance = Eigen::MatrixXd::Zero(num, num);
  for (Eigen::Index i = 0; i < num; ++i) {
    const Eigen::Index own = place[static_cast<std::size_t>(i)];
    if (own < 0) covariance(i, i) = std::pow(StdBefore(blocks_[static_cast<std::size_t>(i)]), 2);
    for (Eigen::Index j = 0; own >= 0 && j < num; ++j) {
      const Eigen::Index other = place[static_cast<std::size_t>(j)];
      if (other >= 0) covariance(i, j) = told(own, other);
    }
  }
  return covariance;
}

double MotionToPredict::Width(const std::vector<ClothRows>& cloths, const Eigen::VectorXd& step_errors) const {
  double square = 0.0;
  for (const ClothRows& cloth : cloths) square += Covariance(cloth, step_errors).cwiseProduct(gram_).sum();
  return std::sqrt(square / static_cast<double>(cloths.size()));
}

}  // namespace clothid

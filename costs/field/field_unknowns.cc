#include "costs/field/field_unknowns.h"

#include <algorithm>
#include <stdexcept>

namespace clothid {

FieldUnknowns::FieldUnknowns(const std::vector<FieldRequest>& requests, const Scene& scene, const std::string& source)
    : base_(scene.nominal_parameters().fields), areas_(TriangleAreas(scene.mesh)) {
  areas_ /= areas_.sum();
  for (const FieldRequest& request : requests) {
    const auto field = std::find_if(scene.fields.begin(), scene.fields.end(),
                                    [&](const GridField& other) { return other.kind == request.kind; });
    if (field == scene.fields.end()) throw std::logic_error("the scene has no field '" + request.name + "'");
    parts_.push_back({ControlWeights(scene.mesh, request.rows, request.columns, source), size_,
                      (field - scene.fields.begin()) * areas_.size()});
    size_ += request.size();
  }
}

std::shared_ptr<const std::vector<FieldFactors>> FieldUnknowns::FactorsAt(const Eigen::VectorXd& theta) const {
  const Eigen::MatrixXd changes = OverTriangles(theta);
  auto factors = std::make_shared<std::vector<FieldFactors>>(*base_);
  Eigen::Index row = 0;
  for (FieldFactors& field : *factors) {
    field.log_factors += changes.col(0).segment(row, areas_.size());
    row += areas_.size();
  }
  return factors;
}

Eigen::MatrixXd FieldUnknowns::OverTriangles(const Eigen::MatrixXd& theta) const {
  const Eigen::Index num_faces = areas_.size();
  Eigen::MatrixXd all = Eigen::MatrixXd::Zero(static_cast<Eigen::Index>(base_->size()) * num_faces, theta.cols());
  for (const Part& part : parts_) {
    auto own = all.middleRows(part.first_row, num_faces);
    own = part.weights * theta.middleRows(part.first_unknown, part.weights.cols());
    own.rowwise() -= (areas_.transpose() * own).eval();
  }
  return all;
}

Eigen::MatrixXd FieldUnknowns::WithoutMeans(const Eigen::MatrixXd& theta) const {
  Eigen::MatrixXd all = theta;
  for (const Part& part : parts_) {
    auto own = all.middleRows(part.first_unknown, part.weights.cols());
    own.rowwise() -= (areas_.transpose() * (part.weights * own)).eval();
  }
  return all;
}

Eigen::MatrixXd FieldUnknowns::PullBack(const Eigen::MatrixXd& by_triangle) const {
  Eigen::MatrixXd all(size_, by_triangle.cols());
  for (const Part& part : parts_) {
    Eigen::MatrixXd own = by_triangle.middleRows(part.first_row, areas_.size());
    own -= areas_ * own.colwise().sum().eval();
    all.middleRows(part.first_unknown, part.weights.cols()) = part.weights.transpose() * own;
  }
  return all;
}

}  // namespace clothid

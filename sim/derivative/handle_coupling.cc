#include "sim/derivative/handle_coupling.h"

#include <utility>

#include "sim/matrix/block_product.h"
#include "sim/step/step_problem.h"

namespace clothid {
namespace {

Scene WithoutHandles(Scene scene) {
  scene.handles = Handles();
  return scene;
}

}  // namespace

HandleCoupling::HandleCoupling(const ClothModel& model)
    : model_(model), scene_(WithoutHandles(model.scene())), whole_(scene_), hessian_(whole_.pattern()) {}

void HandleCoupling::SetStep(const StepRecord& record, const Eigen::VectorXd& start_positions,
                             const Parameters& parameters) {
  record_ = &record;
  start_positions_ = &start_positions;
  damping_ = parameters.material.damping;
  if (whole_.damping() != nullptr) whole_.damping()->SetMetrics(start_positions, &start_metrics_);
  AssembleStepHessian(whole_, parameters, record.time_step, HessianKind::kExact, start_metrics_, record.positions,
                      &hessian_);
}

Eigen::MatrixXd HandleCoupling::FromHandles(const Eigen::MatrixXd& columns) const {
  Eigen::MatrixXd all = Eigen::MatrixXd::Zero(3 * model_.num_nodes(), columns.cols());
  const std::vector<int>& nodes = model_.scene().handles.nodes;
  for (std::size_t i = 0; i < nodes.size(); ++i) {
    all.middleRows<3>(3 * nodes[i]) = columns.middleRows<3>(3 * static_cast<Eigen::Index>(i));
  }
  return all;
}

void HandleCoupling::AddHandleRows(const Eigen::MatrixXd& all, Eigen::MatrixXd* columns) const {
  const std::vector<int>& nodes = model_.scene().handles.nodes;
  for (std::size_t i = 0; i < nodes.size(); ++i) {
    columns->middleRows<3>(3 * static_cast<Eigen::Index>(i)) += all.middleRows<3>(3 * nodes[i]);
  }
}

// K = M + h C + h^2 H. Its masses stand on the diagonal: they do not reach from a handle to a free node.
Eigen::MatrixXd HandleCoupling::TimesHessian(const Eigen::MatrixXd& all) const {
  return whole_.ScatterColumns(MultiplySymmetric(hessian_, whole_.GatherColumns(all))) / record_->time_step;
}

Eigen::MatrixXd HandleCoupling::TimesMixed(const Eigen::VectorXd& positions, const Eigen::VectorXd& start_positions,
                                           const Eigen::MatrixXd& all) const {
  const double h = record_->time_step;
  Eigen::MatrixXd product = Eigen::MatrixXd::Zero(all.rows(), all.cols());
  whole_.damping()->AddMixedProduct(h * damping_, h, positions, start_positions, all, &product);
  return product;
}

Eigen::MatrixXd HandleCoupling::Times(const Eigen::MatrixXd& end, const Eigen::MatrixXd& start) const {
  Eigen::MatrixXd product = TimesHessian(FromHandles(end));
  if (whole_.damping() != nullptr) product += TimesMixed(record_->positions, *start_positions_, FromHandles(start));
  return model_.GatherColumns(product);
}

void HandleCoupling::AddTransposed(const Eigen::MatrixXd& columns, Eigen::MatrixXd* end, Eigen::MatrixXd* start) const {
  const Eigen::MatrixXd all = model_.ScatterColumns(columns);
  AddHandleRows(TimesHessian(all), end);
  if (whole_.damping() != nullptr) AddHandleRows(TimesMixed(*start_positions_, record_->positions, all), start);
}

}  // namespace clothid

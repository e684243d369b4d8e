#include "sim/derivative/handle_coupling.h"

#include <utility>

#include "sim/matrix/block_product.h"
#include "sim/step/second_start.h"
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

void HandleCoupling::SetStep(const StepRecord& record, const SolveStart& start, const Parameters& parameters) {
  record_ = &record;
  damping_ = parameters.material.damping;
  times_ = {record.time};
  origins_.clear();
  if (whole_.damping() != nullptr) {
    SetStartMetrics(whole_, start, &start_metrics_);
    if (start.first_positions == nullptr) {
      times_.push_back(record.time - record.time_step);
      origins_ = {{&start.positions, 1.0}};
    } else {
      const double step_start = record.time - record.time_step / kStageShare;
      times_.insert(times_.end(), {step_start, step_start + record.time_step});
      origins_ = {{start.step_positions, 1.0 - kSecondStageReach}, {start.first_positions, kSecondStageReach}};
    }
  }
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

Eigen::MatrixXd HandleCoupling::HandleRows(const Eigen::MatrixXd& all) const {
  const std::vector<int>& nodes = model_.scene().handles.nodes;
  Eigen::MatrixXd rows(3 * static_cast<Eigen::Index>(nodes.size()), all.cols());
  for (std::size_t i = 0; i < nodes.size(); ++i) {
    rows.middleRows<3>(3 * static_cast<Eigen::Index>(i)) = all.middleRows<3>(3 * nodes[i]);
  }
  return rows;
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

Eigen::MatrixXd HandleCoupling::Times(int place, const Eigen::MatrixXd& columns) const {
  const Eigen::MatrixXd all = FromHandles(columns);
  if (place == 0) return model_.GatherColumns(TimesHessian(all));
  const Origin& origin = origins_[place - 1];
  return origin.share * model_.GatherColumns(TimesMixed(record_->positions, *origin.positions, all));
}

Eigen::MatrixXd HandleCoupling::TimesTransposed(int place, const Eigen::MatrixXd& columns) const {
  const Eigen::MatrixXd all = model_.ScatterColumns(columns);
  if (place == 0) return HandleRows(TimesHessian(all));
  const Origin& origin = origins_[place - 1];
  return origin.share * HandleRows(TimesMixed(*origin.positions, record_->positions, all));
}

}  // namespace clothid

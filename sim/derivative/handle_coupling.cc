#include "sim/derivative/handle_coupling.h"

#include <utility>

#include "sim/matrix/block_product.h"
#include "sim/step/second_start.h"

namespace clothid {
namespace {

// Where they clamp the cloth the slope stays.
Scene WithoutHandles(Scene scene) {
  scene.handles.nodes.clear();
  scene.handles.path = HandlePath();
  return scene;
}

}  // namespace

std::vector<HandleSpeedTerm> HandleSpeedTerms(const StepRecord& record) {
  const double h = record.time_step;
  if (record.stage != Stage::kSecond) return {{record.time, 1.0 / h}, {record.time - h, -1.0 / h}};
  const double step_start = record.time - h / kStageShare;
  return {
      {record.time, 1.0 / h}, {step_start, (kSecondStageReach - 1.0) / h}, {step_start + h, -kSecondStageReach / h}};
}

HandleCoupling::HandleCoupling(const ClothModel& model)
    : model_(model),
      scene_(WithoutHandles(model.scene())),
      whole_(scene_, model.chosen_on()),
      hessian_(whole_.pattern()) {}

void HandleCoupling::SetStep(const StepRecord& record, const SolveStart& start, const Parameters& parameters,
                             const StepDerivative& step) {
  record_ = &record;
  impulses_ = &step.impulse_blocks();
  whole_.SetVariation(parameters);
  parameters_ = &parameters;
  times_ = {record.time};
  origins_.clear();
  const ForceSet& forces = whole_.forces();
  SetForceStart(forces, start, record.time_step, model_.scene().handles.nodes, record.positions, &held_.start);
  forces.Hold(parameters, record.time, &held_);
  if (forces.needs_origins() || forces.needs_velocities() || !impulses_->is_empty()) {
    if (start.first_positions == nullptr) {
      times_.push_back(record.time - record.time_step);
      origins_ = {{&start.positions, 1.0}};
    } else {
      const double step_start = record.time - record.time_step / kStageShare;
      times_.insert(times_.end(), {step_start, step_start + record.time_step});
      origins_ = {{start.step_positions, 1.0 - kSecondStageReach}, {start.first_positions, kSecondStageReach}};
    }
  }
  AssembleStepHessian(whole_, HessianKind::kExact, point(), held_, &hessian_);
}

// K = M + h C + h^2 H. Its masses, and drag that is the same in every direction, stand on the diagonal: they do not
// reach from a handle to a free node.
Eigen::MatrixXd HandleCoupling::TimesHessian(const Eigen::MatrixXd& all) const {
  return whole_.ScatterColumns(MultiplySymmetric(hessian_, whole_.GatherColumns(all))) / record_->time_step;
}

ForcePoint HandleCoupling::point() const {
  return {*parameters_, record_->time_step, record_->time, record_->positions, record_->velocities};
}

StepColumns HandleCoupling::Times(int place, const Eigen::MatrixXd& columns) const {
  const Eigen::MatrixXd all = model_.ScatterHandles(columns);
  const ForceSet& forces = whole_.forces();
  const bool has_pairs = !impulses_->is_empty();
  Eigen::MatrixXd by_speed(impulses_->friction.size(), columns.cols());
  if (has_pairs) by_speed = impulses_->speeds * all / record_->time_step;
  if (place == 0) {
    Eigen::MatrixXd product = TimesHessian(all);
    forces.AddPredictionProduct(-record_->time_step, point(), held_, all, &product);
    return {model_.GatherColumns(product), by_speed};
  }
  const Origin& origin = origins_[place - 1];
  Eigen::MatrixXd product = Eigen::MatrixXd::Zero(all.rows(), all.cols());
  if (has_pairs) {
    product += impulses_->weights * all;
    by_speed = origin.share * (impulses_->geometry * all - by_speed);
  }
  forces.AddOriginProduct(record_->time_step, point(), *origin.positions, all, &product);
  forces.AddVelocityProduct(-1.0, point(), held_, all, &product);
  return {origin.share * model_.GatherColumns(product), by_speed};
}

Eigen::MatrixXd HandleCoupling::TimesTransposed(int place, const StepColumns& columns) const {
  const Eigen::MatrixXd all = model_.ScatterColumns(columns.velocities);
  const ForceSet& forces = whole_.forces();
  const bool has_pairs = !impulses_->is_empty();
  const double h = record_->time_step;
  if (place == 0) {
    Eigen::MatrixXd product = TimesHessian(all);
    if (has_pairs) product += impulses_->speeds.transpose() * columns.impulses / h;
    forces.AddPredictionProductTransposed(-record_->time_step, point(), held_, all, &product);
    return model_.GatherHandles(product);
  }
  const Origin& origin = origins_[place - 1];
  Eigen::MatrixXd product = Eigen::MatrixXd::Zero(all.rows(), all.cols());
  if (has_pairs) {
    product += impulses_->weights.transpose() * all + impulses_->geometry.transpose() * columns.impulses;
    product -= impulses_->speeds.transpose() * columns.impulses / h;
  }
  forces.AddOriginProductTransposed(record_->time_step, point(), *origin.positions, all, &product);
  forces.AddVelocityProduct(-1.0, point(), held_, all, &product);
  return origin.share * model_.GatherHandles(product);
}

Eigen::MatrixXd HandleCoupling::ContactForceTimes(int place, const Eigen::MatrixXd& columns) const {
  if (place == 0 || impulses_->is_empty()) return Eigen::MatrixXd::Zero(columns.rows(), columns.cols());
  const double share = origins_[place - 1].share / record_->time_step;
  return -share * model_.GatherHandles(impulses_->weights * model_.ScatterHandles(columns));
}

Eigen::MatrixXd HandleCoupling::ContactForceTimesTransposed(int place, const Eigen::MatrixXd& columns) const {
  if (place == 0 || impulses_->is_empty()) return Eigen::MatrixXd::Zero(columns.rows(), columns.cols());
  const double share = origins_[place - 1].share / record_->time_step;
  return -share * model_.GatherHandles(impulses_->weights.transpose() * model_.ScatterHandles(columns));
}

}  // namespace clothid

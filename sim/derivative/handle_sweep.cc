#include "sim/derivative/handle_sweep.h"

#include <stdexcept>

namespace clothid {

HandleTangent::HandleTangent(const Eigen::MatrixXd& columns, const HandlePath* offsets, const ClothModel& model)
    : columns_(columns), offsets_(offsets), nodes_(model.scene().handles.nodes) {
  if (columns_.cols() == 0) return;
  if (offsets == nullptr || columns_.rows() != offsets->positions().size()) {
    throw std::logic_error("directions of handle offsets: expected those offsets, with as many rows");
  }
  while (first_ < columns_.cols() && columns_.col(first_).isZero(0.0)) ++first_;
  coupling_ = std::make_unique<HandleCoupling>(model);
}

void HandleTangent::Subtract(const StepRecord& record, const SolveStart& start, const Parameters& parameters,
                             const StepDerivative& step, StepColumns* right) {
  if (is_empty()) return;
  coupling_->SetStep(record, start, parameters, step);
  for (int place = 0; place < coupling_->num_places(); ++place) {
    const StepColumns change = coupling_->Times(place, At(coupling_->time(place)));
    right->velocities.rightCols(columns_.cols() - first_) -= change.velocities;
    right->impulses.rightCols(columns_.cols() - first_) -= change.impulses;
  }
}

void HandleTangent::AddContactForces(Eigen::MatrixXd* forces) const {
  if (is_empty()) return;
  for (int place = 0; place < coupling_->num_places(); ++place) {
    forces->rightCols(columns_.cols() - first_) += coupling_->ContactForceTimes(place, At(coupling_->time(place)));
  }
}

void HandleTangent::SubtractImpacts(const StepRecord& first, const SecondStartDerivative& derivative,
                                    Eigen::MatrixXd* velocities) const {
  if (is_empty() || !derivative.reaches_handles()) return;
  const Eigen::MatrixXd changes = Sum(HandleSpeedTerms(first)) - Sum(start_speed_);
  derivative.SubtractHandleImpacts(At(first.time - first.time_step), changes, velocities);
}

void HandleTangent::EndStep(const StepRecord& record) {
  if (!is_empty()) start_speed_ = HandleSpeedTerms(record);
}

void HandleTangent::SetRows(double time, Eigen::MatrixXd* all) const {
  if (is_empty()) return;
  const Eigen::MatrixXd rows = At(time);
  for (std::size_t i = 0; i < nodes_.size(); ++i) {
    all->middleRows<3>(3 * nodes_[i]).rightCols(rows.cols()) = rows.middleRows<3>(3 * static_cast<Eigen::Index>(i));
  }
}

Eigen::MatrixXd HandleTangent::At(double time) const {
  const Eigen::VectorXd weights = offsets_->KnotWeights(time);
  const Eigen::Index num_rows = offsets_->positions().rows();
  Eigen::MatrixXd sum = Eigen::MatrixXd::Zero(num_rows, columns_.cols() - first_);
  for (Eigen::Index k = 0; k < weights.size(); ++k) {
    if (weights[k] == 0.0) continue;
    sum += weights[k] * columns_.middleRows(k * num_rows, num_rows).rightCols(sum.cols());
  }
  return sum;
}

Eigen::MatrixXd HandleTangent::Sum(const std::vector<HandleSpeedTerm>& terms) const {
  Eigen::MatrixXd sum = Eigen::MatrixXd::Zero(offsets_->positions().rows(), columns_.cols() - first_);
  for (const auto& [time, weight] : terms) sum += weight * At(time);
  return sum;
}

HandleGradient::HandleGradient(const Rollout& rollout, int num_columns, const ClothModel& model)
    : offsets_(rollout.handle_offsets), model_(model), parameters_(rollout.parameters) {
  if (offsets_.num_handles() == 0) return;
  coupling_ = std::make_unique<HandleCoupling>(model);
  values_ = Eigen::MatrixXd::Zero(offsets_.positions().size(), num_columns);
}

void HandleGradient::AddSeed(double time, const Eigen::MatrixXd& seed) {
  if (coupling_ == nullptr) return;
  Add(time, model_.GatherHandles(seed));
}

void HandleGradient::AddSolve(const StepRecord& record, const SolveStart& start, const StepDerivative& step,
                              const StepColumns& y) {
  if (coupling_ == nullptr) return;
  coupling_->SetStep(record, start, parameters_, step);
  for (int place = 0; place < coupling_->num_places(); ++place) {
    Add(coupling_->time(place), -coupling_->TimesTransposed(place, y));
  }
}

void HandleGradient::AddContactForces(const Eigen::MatrixXd& by_forces) {
  if (coupling_ == nullptr) return;
  for (int place = 0; place < coupling_->num_places(); ++place) {
    Add(coupling_->time(place), coupling_->ContactForceTimesTransposed(place, by_forces));
  }
}

void HandleGradient::AddImpacts(const StepRecord& first, const SecondStartDerivative& derivative,
                                const StateColumns& second) {
  if (coupling_ == nullptr || !derivative.reaches_handles()) return;
  Eigen::MatrixXd positions = Eigen::MatrixXd::Zero(offsets_.positions().rows(), values_.cols()), changes = positions;
  derivative.AddHandleImpactsTransposed(second, &positions, &changes);
  Add(first.time - first.time_step, positions);
  AddSpeed(first, changes);
  by_start_speed_ = -changes;
}

void HandleGradient::EnterStep(const StepRecord& record) {
  if (by_start_speed_.size() == 0) return;
  AddSpeed(record, by_start_speed_);
  by_start_speed_.resize(0, 0);
}

void HandleGradient::AddSpeed(const StepRecord& record, const Eigen::MatrixXd& rows) {
  for (const auto& [time, weight] : HandleSpeedTerms(record)) Add(time, weight * rows);
}

void HandleGradient::Add(double time, const Eigen::MatrixXd& rows) {
  const Eigen::VectorXd weights = offsets_.KnotWeights(time);
  for (Eigen::Index k = 0; k < weights.size(); ++k) {
    if (weights[k] != 0.0) values_.middleRows(k * rows.rows(), rows.rows()) += weights[k] * rows;
  }
}

}  // namespace clothid

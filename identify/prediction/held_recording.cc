#include "identify/prediction/held_recording.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <utility>

#include "costs/start/unknown_start.h"
#include "datasets/motion/refined_motion.h"
#include "datasets/observation/observation.h"
#include "identify/base/parallel_for.h"
#include "identify/prediction/random_streams.h"
#include "sim/base/error.h"
#include "sim/matrix/dense.h"

namespace clothid {
namespace {

constexpr double kMostHeldNumbers = 5e6;  // of all draws of a recording: 40 MB

JudgedRows RowsOf(const RecordingModel& model, int num_draws) {
  const Observation& observation = model.observation();
  const Eigen::VectorXd times = observation.RowTimes().array() - model.scene().start_time;
  std::vector<int> points, forces;
  for (int row = 0; row < observation.num_residuals(); ++row) {
    if (!(times[row] > 0.5 * model.scene().time_step)) continue;  // the start itself
    (observation.KindOf(row) == PredictedKind::kForces ? forces : points).push_back(row);
  }
  const std::vector<int>& all = points.empty() ? forces : points;
  auto stride = static_cast<std::size_t>(std::ceil(static_cast<double>(all.size()) * num_draws / kMostHeldNumbers));
  if (stride > 1 && stride % 3 == 0) ++stride;  // every axis
  JudgedRows judged;
  judged.are_forces = points.empty() && !forces.empty();
  for (std::size_t i = 0; i < all.size(); i += std::max<std::size_t>(stride, 1)) judged.rows.push_back(all[i]);
  judged.leads = times(judged.rows);
  judged.sigma.resize(judged.leads.size());
  for (Eigen::Index i = 0; i < judged.sigma.size(); ++i) {
    judged.sigma[i] = observation.SigmaOf(judged.rows[static_cast<std::size_t>(i)]);
  }
  return judged;
}

}  // namespace

HeldRecording::HeldRecording(const RecordedMotion& motion, int number, int recording, const HeldOutStart& start,
                             const std::vector<ParameterBlock>& blocks, const Eigen::VectorXd& values,
                             const FitPosterior& posterior, const HeldBandOptions& options)
    : motion_(motion),
      number_(number),
      recording_(recording),
      start_(start),
      blocks_(blocks),
      values_(values),
      posterior_(posterior),
      options_(options),
      drawn_(DrawParameters(posterior, options.num_draws, options.seed)) {
  for (const ParameterBlock& block : blocks) num_fitted_ = std::max(num_fitted_, block.recording + 1);
  const HeldOutBlocks own = BlocksFor(motion_, recording_, blocks_, values_);
  RecordingModel model(motion_, own.blocks, {}, start_.start);
  if (start_.start == nullptr) start_.start = model.shared_start();
  judged_ = RowsOf(model, options.num_draws);
  sigma_is_known_ = model.observation().sigma_is_known();
  if (posterior.start && start_.start != nullptr && start_.unknowns.size() == 0) {
    spread_.emplace(motion.scene, posterior.start->position, posterior.start->velocity);
  }
  if (!posterior.forces.empty() && model.cloth().num_free() > 0) {
    force_ = std::make_unique<ForceSource>(posterior.forces, model.cloth());
  }
}

Eigen::VectorXd HeldRecording::Roll(int draw, double force_factor) const {
  Eigen::VectorXd values = values_;
  for (std::size_t i = 0; i < posterior_.parameters.size(); ++i) {
    values[IndexOfBlock(posterior_.parameters[i].name)] = drawn_(static_cast<Eigen::Index>(i), draw);
  }
  const std::optional<int> like = num_fitted_ > 0 ? std::optional<int>(draw % num_fitted_) : std::nullopt;
  const HeldOutBlocks own = BlocksFor(motion_, recording_, blocks_, values, like);
  RecordingModel model(motion_, own.blocks, {}, start_.start);
  const int stream = StreamOf(draw);
  if (force_ && force_factor > 0.0) {
    model.Correct(force_->Draw(force_factor, model.cloth(), model.ParametersAt(own.coordinates).material,
                               model.num_steps(), options_.seed, stream));
  }
  Eigen::VectorXd residuals = ResidualsOf(own, {start_.start, StartOf(stream)}, &model);
  if (residuals.size() > 0 && sigma_is_known_) {
    residuals += NormalStream(options_.seed, stream, DrawStream::kNoise).Draw(residuals.size(), 1);
  }
  return residuals;
}

Eigen::VectorXd HeldRecording::RollEstimate(const ForceSource* force, int draw, Precision precision) const {
  return RollWithout(motion_, start_, force, draw, precision);
}

Eigen::VectorXd HeldRecording::RollStill() const {
  const HeldOutBlocks own = BlocksFor(motion_, recording_, blocks_, values_);
  RecordingModel model(motion_, own.blocks, {}, start_.start);
  return ResidualsOf(own, start_, &model, /*is_still=*/true);
}

Eigen::MatrixXd HeldRecording::RollFiner() const {
  Eigen::MatrixXd changes = Eigen::MatrixXd::Zero(static_cast<Eigen::Index>(judged_.rows.size()), 2);
  Eigen::VectorXd own;
  std::array<Eigen::VectorXd, 2> finer;
  const auto roll = [&](int task) {
    if (task == 2) own = RollWithout(motion_, start_);
    if (task == 0 && options_.with_step) {
      RecordedMotion halved = motion_;
      halved.scene.time_step *= 0.5;
      finer[0] = RollWithout(halved, start_);
    }
    // The modes of an unknown start are those of its mesh.
    if (task == 1 && options_.with_mesh && start_.unknowns.size() == 0) finer[1] = RollRefined();
  };
  ParallelFor(3, options_.num_threads, roll);
  for (Eigen::Index i = 0; i < 2; ++i) {
    const Eigen::VectorXd& changed = finer[static_cast<std::size_t>(i)];
    if (own.size() > 0 && changed.size() == own.size()) changes.col(i) = changed - own;
  }
  return changes;
}

ForceSource HeldRecording::Lacking(const std::vector<LastingForce>& parts) const {
  const HeldOutBlocks own = BlocksFor(motion_, recording_, blocks_, values_);
  return ForceSource(parts, RecordingModel(motion_, own.blocks, {}, start_.start).cloth());
}

Eigen::Index HeldRecording::IndexOfBlock(const std::string& name) const {
  const auto found =
      std::find_if(blocks_.begin(), blocks_.end(), [&](const ParameterBlock& block) { return block.name == name; });
  return found - blocks_.begin();
}

Eigen::VectorXd HeldRecording::StartOf(int stream) const {
  if (!spread_) return start_.unknowns;
  const UnknownStart& start = *start_.start;
  NormalStream numbers(options_.seed, stream, DrawStream::kStart);
  const Eigen::MatrixXd &positions = spread_->position_root(), &velocities = spread_->velocity_root();
  Eigen::VectorXd unknowns = Eigen::VectorXd::Zero(start.size());
  unknowns.head(positions.cols()) = positions * numbers.Draw(positions.cols(), 1);
  const Eigen::Index first_velocity = start.num_position_unknowns() + start.num_handle_unknowns();
  const Eigen::Index num_velocities = start.size() - first_velocity;
  unknowns.tail(num_velocities) = velocities.topRows(num_velocities) * numbers.Draw(velocities.cols(), 1);
  if (start.num_handle_unknowns() > 0) {
    const Eigen::MatrixXd& root = start.handle_jacobian();
    unknowns.segment(start.num_position_unknowns(), start.num_handle_unknowns()) =
        LeastSquaresSolution(root, numbers.Draw(root.rows(), 1));
  }
  return unknowns;
}

Eigen::VectorXd HeldRecording::ResidualsOf(const HeldOutBlocks& own, const HeldOutStart& start, RecordingModel* model,
                                           bool is_still, Precision precision) const {
  Eigen::MatrixXd predicted;
  ForceTrack forces;
  const PassOptions pass = {precision, options_.cancel};
  const Rollout rollout =
      model->Simulate(WithStart(own.coordinates, start), pass, {}, &predicted, /*velocities=*/nullptr, &forces);
  if (!rollout.ok()) return {};
  if (is_still) predicted = predicted.col(0).replicate(1, predicted.cols()).eval();
  return model->observation().Residuals(predicted, forces.predicted)(judged_.rows);
}

Eigen::VectorXd HeldRecording::RollWithout(const RecordedMotion& motion, const HeldOutStart& start,
                                           const ForceSource* force, int draw, Precision precision) const {
  const HeldOutBlocks own = BlocksFor(motion, recording_, blocks_, values_);
  RecordingModel model(motion, own.blocks, {}, start.start);
  if (force != nullptr) {
    model.Correct(force->Draw(1.0, model.cloth(), model.ParametersAt(own.coordinates).material, model.num_steps(),
                              options_.seed, StreamOf(draw)));
  }
  return ResidualsOf(own, start, &model, /*is_still=*/false, precision);
}

Eigen::VectorXd HeldRecording::RollRefined() const {
  try {
    return RollWithout(RefineMotion(motion_), {});
  } catch (const Error&) {  // a mesh that cannot be refined
    return {};
  }
}

}  // namespace clothid

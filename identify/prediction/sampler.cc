#include "identify/prediction/sampler.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include "costs/prediction/handle_correction.h"
#include "datasets/synthetic/synthetic.h"
#include "identify/base/parallel_for.h"
#include "sim/base/error.h"
#include "sim/rollout/handle_forces.h"
#include "sim/rollout/rollout.h"
#include "sim/rollout/simulator.h"
#include "sim/scene/refinement.h"

namespace clothid {
namespace {

// Of the steps of a rollout only frames are kept; the others are dropped so many at a time.
constexpr int kDroppedSteps = 16;

// Columns at times in steps [T], linear between those after every step [R x (steps + 1)].
Eigen::MatrixXd AtFrames(const Eigen::MatrixXd& after_steps, const Eigen::VectorXd& frame_steps) {
  Eigen::MatrixXd frames(after_steps.rows(), frame_steps.size());
  for (Eigen::Index i = 0; i < frames.cols(); ++i) {
    const auto below = std::min(static_cast<Eigen::Index>(frame_steps[i]), after_steps.cols() - 2);
    const double fraction = frame_steps[i] - static_cast<double>(below);
    frames.col(i) = (1.0 - fraction) * after_steps.col(below) + fraction * after_steps.col(below + 1);
  }
  return frames;
}

bool SlipsInMostContacts(const StepRecord& record) {
  const auto num_slips =
      std::count_if(record.contacts.nodes.begin(), record.contacts.nodes.end(),
                    [](const ContactRecord& contact) { return contact.branch == ContactBranch::kSlip; });
  const auto num_touching =
      std::count_if(record.contacts.nodes.begin(), record.contacts.nodes.end(),
                    [](const ContactRecord& contact) { return contact.branch != ContactBranch::kTakeOff; });
  return 2 * num_slips > num_touching;
}

}  // namespace

Sampler::Sampler(const Scene& scene, const FitPosterior& posterior, const PredictionOptions& options)
    : scene_(scene),
      posterior_(posterior),
      options_(options),
      values_(DrawParameters(posterior, options.num_draws, options.seed)),
      frame_steps_(FrameSteps(options.frame_rate, scene.time_step, scene.num_steps())) {
  if (posterior.start) start_.emplace(scene, *posterior.start, options.with_start, options.with_handles);
  if (!options.with_force || posterior.forces.empty()) return;
  const Simulator simulator(scene);
  force_ = std::make_unique<ForceSource>(posterior.forces, simulator.model());
}

Sampler::DrawnScene Sampler::SetDraw(const Scene& scene, const Eigen::VectorXd& values) const {
  std::map<std::string, double> named = posterior_.held;
  for (std::size_t i = 0; i < posterior_.parameters.size(); ++i) {
    named[posterior_.parameters[i].name] = values[static_cast<Eigen::Index>(i)];
  }
  DrawnScene drawn = {scene, scene.nominal_parameters()};
  for (const auto& [name, value] : named) SetParameter(ParseParameter(name, scene), value, &drawn.parameters);
  drawn.scene.SetMaterials(drawn.parameters);
  return drawn;
}

bool Sampler::Asks(DerivedKind kind) const {
  return std::any_of(options_.derived.begin(), options_.derived.end(),
                     [kind](const DerivedRequest& request) { return request.kind == kind; });
}

Draw Sampler::RollOut(const DrawnScene& drawn, const Eigen::VectorXd& frame_steps, const ForceOf& force_of,
                      const HandlePath* handle_offsets) const {
  Draw result;
  result.failure = Indefinite(drawn.parameters, drawn.scene);
  if (!result.failure.empty()) return result;
  Simulator simulator(drawn.scene);
  simulator.UseParameters(drawn.parameters);
  RolloutOptions options;
  options.checkpoint_interval = kDroppedSteps;
  if (force_of) options.correction = force_of(simulator.model());
  options.handle_offsets = handle_offsets;
  const int num_steps = drawn.scene.num_steps();
  std::optional<HandleForces> forces;
  Eigen::MatrixXd near_handles;
  if (Asks(DerivedKind::kForce)) {
    forces.emplace(simulator.model(), drawn.parameters, num_steps, GripperNodes(drawn.scene));
    near_handles.resize(3 * static_cast<Eigen::Index>(forces->nodes().size()), num_steps + 1);
  }
  result.positions.setZero(drawn.scene.initial_positions.size(), frame_steps.size());
  Eigen::Index next = 0;
  Eigen::VectorXd before;
  options.visitor = [&](int step, const Eigen::VectorXd& positions) {
    for (; next < frame_steps.size() && frame_steps[next] <= step; ++next) {
      const double fraction = frame_steps[next] - (step - 1);
      result.positions.col(next) =
          step == 0 || fraction == 1.0 ? positions : (1.0 - fraction) * before + fraction * positions;
    }
    before = positions;
    if (forces) near_handles.col(step) = forces->Gather(positions);
  };
  if (Asks(DerivedKind::kSlip)) {
    options.end_visitor = [&](int step, const StepRecord& end) {
      if (std::isinf(result.slip) && SlipsInMostContacts(end)) result.slip = step * drawn.scene.time_step;
    };
  }
  const Rollout rollout = Simulate(drawn.parameters, num_steps, &simulator, options_.cancel, options);
  if (!rollout.ok()) result.failure = rollout.failure->ToString();
  if (forces && rollout.ok()) result.forces = AtFrames(forces->Over(near_handles), frame_steps);
  return result;
}

Draw Sampler::Roll(int draw) const {
  DrawnScene drawn = SetDraw(scene_, values_.col(draw));
  ForceOf force_of;
  if (force_) {
    force_of = [&](const ClothModel& cloth) {
      return force_->Draw(1.0, cloth, drawn.parameters.material, scene_.num_steps(), options_.seed, draw);
    };
  }
  return RollMoved(draw, has_start(), has_handles(), force_of, &drawn);
}

Draw Sampler::RollMoved(int draw, bool moves_start, bool moves_handles, const ForceOf& force_of,
                        DrawnScene* drawn) const {
  if (moves_start) start_->MoveStart(options_.seed, draw, &drawn->scene);
  if (!moves_handles) return RollOut(*drawn, frame_steps_, force_of);
  drawn->scene = WithHandlePath(std::move(drawn->scene));
  const HandlePath offsets = start_->HandleOffsets(options_.seed, draw);
  return RollOut(*drawn, frame_steps_, force_of, &offsets);
}

Eigen::VectorXd Sampler::VarianceAlone(bool of_start, const std::vector<int>& free) const {
  std::vector<Draw> draws(kDrawsAlone);
  const auto roll = [&](int draw) {
    DrawnScene drawn = SetDraw(scene_, Estimates());
    draws[static_cast<std::size_t>(draw)] = RollMoved(draw, of_start, !of_start, {}, &drawn);
  };
  ParallelFor(kDrawsAlone, options_.num_threads, roll);
  draws.erase(std::remove_if(draws.begin(), draws.end(), [](const Draw& draw) { return !draw.failure.empty(); }),
              draws.end());
  Eigen::VectorXd variance = Eigen::VectorXd::Zero(frame_steps_.size());
  const auto num = static_cast<double>(draws.size());
  for (Eigen::Index frame = 0; draws.size() > 1 && frame < variance.size(); ++frame) {
    Eigen::VectorXd mean = Eigen::VectorXd::Zero(static_cast<Eigen::Index>(free.size()));
    for (const Draw& draw : draws) mean += draw.positions.col(frame)(free) / num;
    for (const Draw& draw : draws) variance[frame] += (draw.positions.col(frame)(free) - mean).squaredNorm();
  }
  return variance / std::max((num - 1.0) * static_cast<double>(free.size()), 1.0);
}

FinerChanges Sampler::RollFiner(std::string* no_step, std::string* no_mesh) const {
  Draw own, step, mesh;
  const auto roll = [&](int task) {
    if (task == 0 && options_.with_step) step = RollHalfStep();
    if (task == 1 && options_.with_mesh) mesh = RollFineMesh();
    if (task == 2 && (options_.with_step || options_.with_mesh))
      own = RollOut(SetDraw(scene_, Estimates()), frame_steps_);
  };
  ParallelFor(3, options_.num_threads, roll);
  const auto change = [&](const Draw& finer, std::string* why_not) -> Draw {
    *why_not = own.failure.empty() ? finer.failure : own.failure;
    if (!why_not->empty() || finer.positions.size() == 0 || own.positions.size() == 0) return {};
    const double slip = std::isfinite(finer.slip) && std::isfinite(own.slip) ? finer.slip - own.slip : 0.0;
    return {finer.positions.topRows(own.positions.rows()) - own.positions, finer.forces - own.forces, slip, ""};
  };
  FinerChanges changes = {change(step, no_step), change(mesh, no_mesh)};
  if (!options_.with_step) no_step->clear();
  if (!options_.with_mesh) no_mesh->clear();
  return changes;
}

Eigen::VectorXd Sampler::Estimates() const {
  Eigen::VectorXd values(static_cast<Eigen::Index>(posterior_.parameters.size()));
  for (Eigen::Index i = 0; i < values.size(); ++i) values[i] = posterior_.parameters[static_cast<std::size_t>(i)].value;
  return values;
}

Draw Sampler::RollHalfStep() const {
  DrawnScene drawn = SetDraw(scene_, Estimates());
  drawn.scene.time_step *= 0.5;
  return RollOut(drawn, 2.0 * frame_steps_);
}

Draw Sampler::RollFineMesh() const {
  try {
    ExpectRefinable(scene_, "the mesh");
  } catch (const Error& error) {
    Draw none;
    none.failure = error.what();
    return none;
  }
  const Scene fine = RefineScene(scene_, RefineMesh(scene_.mesh));
  return RollOut(SetDraw(fine, Estimates()), frame_steps_);
}

}  // namespace clothid

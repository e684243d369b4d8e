#include "identify/prediction/prediction.h"

#include <Eigen/QR>
#include <algorithm>
#include <cmath>
#include <memory>

#include "datasets/formats/track_checks.h"
#include "datasets/synthetic/synthetic.h"
#include "identify/base/parallel_for.h"
#include "identify/prediction/random_force.h"
#include "identify/prediction/random_streams.h"
#include "sim/base/error.h"
#include "sim/rollout/rollout.h"
#include "sim/rollout/simulator.h"
#include "sim/scene/refinement.h"

namespace clothid {
namespace {

// Of the steps of a rollout only frames are kept; the others are dropped so many at a time.
constexpr int kDroppedSteps = 16;

// The positions [3N x T] of a rollout in frames, or why there are none.
struct Draw {
  Eigen::MatrixXd positions;
  std::string failure;
};

// The scene with true parameters, so that it has their terms, and they as a rollout takes them.
struct DrawnScene {
  Scene scene;
  Parameters parameters;
};

DrawnScene SetDraw(const Scene& scene, const Posterior& posterior, const Eigen::VectorXd& values) {
  std::map<std::string, double> named = posterior.held;
  for (std::size_t i = 0; i < posterior.parameters.size(); ++i) {
    named[posterior.parameters[i].name] = values[static_cast<Eigen::Index>(i)];
  }
  DrawnScene drawn = {scene, scene.nominal_parameters()};
  for (const auto& [name, value] : named) SetParameter(ParseParameter(name, scene), value, &drawn.parameters);
  drawn.scene.SetMaterials(drawn.parameters);
  return drawn;
}

// `frame_steps` [T]: times of frames in steps. `force_of` may be empty.
using ForceOf = std::function<std::shared_ptr<const Correction>(const ClothModel&)>;
Draw RollOut(const DrawnScene& drawn, const Eigen::VectorXd& frame_steps, const std::atomic<bool>* cancel,
             const ForceOf& force_of = {}) {
  const std::string why = Indefinite(drawn.parameters, drawn.scene);
  if (!why.empty()) return {{}, why};
  Simulator simulator(drawn.scene);
  simulator.UseParameters(drawn.parameters);
  RolloutOptions options;
  options.checkpoint_interval = kDroppedSteps;
  if (force_of) options.correction = force_of(simulator.model());
  Draw result;
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
  };
  const Rollout rollout = Simulate(drawn.parameters, drawn.scene.num_steps(), &simulator, cancel, options);
  if (!rollout.ok()) return {{}, rollout.failure->ToString()};
  return result;
}

// What step and mesh of the scene do to it [3N x T]; empty: not known.
struct FinerChanges {
  Eigen::MatrixXd step, mesh;
};

// Rollouts of one scene, each on the thread that asks for it.
class Sampler {
 public:
  Sampler(const Scene& scene, const Posterior& posterior, const PredictionOptions& options)
      : scene_(scene),
        posterior_(posterior),
        options_(options),
        values_(DrawParameters(posterior, options.num_draws, options.seed)),
        frame_steps_(FrameSteps(options.frame_rate, scene.time_step, scene.num_steps())) {
    if (!options.with_force || !posterior.force) return;
    const Simulator simulator(scene);
    field_ = std::make_unique<SmoothField>(simulator.model(), posterior.force->length);
  }

  const Eigen::MatrixXd& values() const { return values_; }  // [p x D]
  const Eigen::VectorXd& frame_steps() const { return frame_steps_; }
  bool has_force() const { return field_ != nullptr; }

  Draw Roll(int draw) const {
    const DrawnScene drawn = SetDraw(scene_, posterior_, values_.col(draw));
    if (!field_) return RollOut(drawn, frame_steps_, options_.cancel);
    return RollOut(drawn, frame_steps_, options_.cancel, [&](const ClothModel& cloth) {
      return std::make_shared<RandomForce>(*posterior_.force, *field_, cloth, drawn.parameters.material,
                                           scene_.num_steps(), options_.seed, draw);
    });
  }

  // Three rollouts side by side. `no_step`, `no_mesh`: why there is none.
  FinerChanges RollFiner(std::string* no_step, std::string* no_mesh) const {
    Draw own, step, mesh;
    const auto roll = [&](int task) {
      if (task == 0) step = options_.with_step ? RollHalfStep() : Draw();
      if (task == 1) mesh = options_.with_mesh ? RollFineMesh() : Draw();
      if (task == 2 && (options_.with_step || options_.with_mesh)) {
        own = RollOut(SetDraw(scene_, posterior_, Estimates()), frame_steps_, options_.cancel);
      }
    };
    ParallelFor(3, options_.num_threads, roll);
    const auto change = [&](const Draw& finer, std::string* why_not) -> Eigen::MatrixXd {
      *why_not = own.failure.empty() ? finer.failure : own.failure;
      if (!why_not->empty() || finer.positions.size() == 0 || own.positions.size() == 0) return {};
      return finer.positions.topRows(own.positions.rows()) - own.positions;
    };
    FinerChanges changes = {change(step, no_step), change(mesh, no_mesh)};
    if (!options_.with_step) no_step->clear();
    if (!options_.with_mesh) no_mesh->clear();
    return changes;
  }

 private:
  Eigen::VectorXd Estimates() const {
    Eigen::VectorXd values(static_cast<Eigen::Index>(posterior_.parameters.size()));
    for (Eigen::Index i = 0; i < values.size(); ++i) {
      values[i] = posterior_.parameters[static_cast<std::size_t>(i)].value;
    }
    return values;
  }

  Draw RollHalfStep() const {
    DrawnScene drawn = SetDraw(scene_, posterior_, Estimates());
    drawn.scene.time_step *= 0.5;
    return RollOut(drawn, 2.0 * frame_steps_, options_.cancel);
  }

  Draw RollFineMesh() const {
    try {
      ExpectRefinable(scene_, "the mesh");
    } catch (const Error& error) {
      return {{}, error.what()};
    }
    const Scene fine = RefineScene(scene_, RefineMesh(scene_.mesh));
    return RollOut(SetDraw(fine, posterior_, Estimates()), frame_steps_, options_.cancel);
  }

  const Scene& scene_;
  const Posterior& posterior_;
  const PredictionOptions& options_;
  Eigen::MatrixXd values_;
  Eigen::VectorXd frame_steps_;
  std::unique_ptr<SmoothField> field_;  // null: no force
};

// What every draw takes of d_s and d_m [D x 2].
Eigen::MatrixXd FinerFactors(const PredictionOptions& options) {
  Eigen::MatrixXd factors(options.num_draws, 2);
  for (int draw = 0; draw < options.num_draws; ++draw) {
    factors.row(draw) = NormalStream(options.seed, draw, DrawStream::kFiner).Draw(1, 2);
  }
  return factors;
}

std::vector<Draw> RollAll(const Sampler& sampler, const PredictionOptions& options) {
  std::vector<Draw> draws(static_cast<std::size_t>(options.num_draws));
  const auto roll = [&](int draw) {
    const bool is_cancelled = options.cancel != nullptr && *options.cancel;
    if (!is_cancelled) draws[static_cast<std::size_t>(draw)] = sampler.Roll(draw);
  };
  const auto tell = [&](int /*draw*/, int num_done) {
    if (options.on_rollout) options.on_rollout(num_done);
  };
  ParallelFor(options.num_draws, options.num_threads, roll, tell);
  return draws;
}

void ExpectOptions(const Scene& scene, const PredictionOptions& options) {
  ExpectUsage(options.num_draws >= kLeastDraws && options.num_draws <= kMostDraws,
              "--draws: expected a number from " + std::to_string(kLeastDraws) + " to " + std::to_string(kMostDraws));
  const Eigen::Index num_frames = FrameSteps(options.frame_rate, scene.time_step, scene.num_steps()).size();
  const double bytes = sizeof(double) * static_cast<double>(scene.initial_positions.size()) *
                       static_cast<double>(num_frames) * (options.num_draws + static_cast<int>(kBandQuantiles.size()));
  ExpectUsage(bytes <= static_cast<double>(kMaxTrackBytes),
              "--draws: " + std::to_string(options.num_draws) + " draws of " + std::to_string(num_frames) +
                  " frames take " + std::to_string(static_cast<long long>(bytes) >> 20) + " MB; expected at most " +
                  std::to_string(kMaxTrackBytes >> 20) + " MB: fewer draws, or a lower --frame_rate");
}

// Orthonormal bases of centred columns: the coordinates of the parameters [D x p], each of them by itself, and they
// with what is taken of step and mesh [D x (p + 2)].
struct Regressors {
  Eigen::MatrixXd parameters, each, all;
};

Eigen::MatrixXd BasisOf(Eigen::MatrixXd columns) {
  columns.rowwise() -= columns.colwise().mean().eval();
  const Eigen::ColPivHouseholderQR<Eigen::MatrixXd> qr(columns);
  return qr.householderQ() * Eigen::MatrixXd::Identity(columns.rows(), qr.rank());
}

Regressors RegressorsOf(const Posterior& posterior, const Eigen::MatrixXd& values,
                        const Eigen::MatrixXd& finer_factors) {
  Eigen::MatrixXd coordinates = values.transpose();
  for (Eigen::Index i = 0; i < coordinates.cols(); ++i) {
    const PosteriorParameter& parameter = posterior.parameters[static_cast<std::size_t>(i)];
    for (double& value : coordinates.col(i)) value = parameter.ToCoordinate(value);
  }
  Regressors regressors;
  regressors.parameters = BasisOf(coordinates);
  coordinates.rowwise() -= coordinates.colwise().mean().eval();
  regressors.each = coordinates;
  for (auto column : regressors.each.colwise()) column.normalize();
  Eigen::MatrixXd all(coordinates.rows(), coordinates.cols() + finer_factors.cols());
  all << regressors.each, finer_factors;
  regressors.all = BasisOf(all);
  return regressors;
}

// `explained` of `total`, less what so many regressors of D draws explain of anything.
double ExplainedShare(double explained, double total, Eigen::Index num_regressors, Eigen::Index num_draws) {
  if (!(total > 0.0)) return std::numeric_limits<double>::quiet_NaN();
  const double chance = static_cast<double>(num_regressors) / static_cast<double>(num_draws - 1);
  return std::clamp((explained / total - chance) / (1.0 - chance), 0.0, 1.0);
}

// Adds frame `frame`, with the draws of its free coordinates [R x D].
void AddShares(const Regressors& regressors, const Eigen::MatrixXd& draws, Eigen::Index frame, Prediction* prediction) {
  const Eigen::Index num_draws = draws.cols();
  const Eigen::MatrixXd centred = draws.colwise() - draws.rowwise().mean();
  const double total = centred.squaredNorm();
  prediction->spread[frame] = std::sqrt(total / static_cast<double>(draws.rows() * (num_draws - 1)));
  SpreadShares* shares = &prediction->shares;
  const auto share = [&](const Eigen::MatrixXd& basis) {
    return ExplainedShare((centred * basis).squaredNorm(), total, basis.cols(), num_draws);
  };
  shares->parameters[frame] = share(regressors.parameters);
  const double by_all = share(regressors.all);
  shares->finer[frame] = std::max(by_all - shares->parameters[frame], 0.0);
  shares->rest[frame] = 1.0 - std::max(by_all, shares->parameters[frame]);
  for (Eigen::Index i = 0; i < regressors.each.cols(); ++i) {
    shares->each(frame, i) = share(regressors.each.col(i));
  }
}

std::vector<int> FreeCoordinates(const Scene& scene) {
  std::vector<char> is_handle(static_cast<std::size_t>(scene.mesh.num_nodes()), 0);
  for (const int node : scene.handles.nodes) is_handle[static_cast<std::size_t>(node)] = 1;
  std::vector<int> free;
  for (int node = 0; node < scene.mesh.num_nodes(); ++node) {
    if (is_handle[static_cast<std::size_t>(node)]) continue;
    for (int axis = 0; axis < 3; ++axis) free.push_back(3 * node + axis);
  }
  return free;
}

}  // namespace

Eigen::MatrixXd BandsOf(const Eigen::MatrixXd& draws) {
  const Eigen::Index num_draws = draws.cols();
  Eigen::MatrixXd bands(draws.rows(), static_cast<Eigen::Index>(kBandQuantiles.size()));
  std::vector<double> sorted(static_cast<std::size_t>(num_draws));
  for (Eigen::Index row = 0; row < draws.rows(); ++row) {
    for (Eigen::Index d = 0; d < num_draws; ++d) sorted[static_cast<std::size_t>(d)] = draws(row, d);
    std::sort(sorted.begin(), sorted.end());
    for (std::size_t q = 0; q < kBandQuantiles.size(); ++q) {
      const double rank = std::clamp(kBandQuantiles[q] * static_cast<double>(num_draws + 1) - 1.0, 0.0,
                                     static_cast<double>(num_draws - 1));
      const auto below = static_cast<std::size_t>(rank);
      const double above = sorted[std::min(below + 1, sorted.size() - 1)];
      bands(row, static_cast<Eigen::Index>(q)) =
          sorted[below] + (rank - static_cast<double>(below)) * (above - sorted[below]);
    }
  }
  return bands;
}

double Prediction::WorthUntil() const {
  double missed = 0.0, missed_at_rest = 0.0;
  for (Eigen::Index frame = 1; frame < times.size(); ++frame) {
    missed += spread[frame] * spread[frame];
    missed_at_rest += moved[frame] * moved[frame];
    if (missed > 0.0 && missed >= missed_at_rest) return times[frame];
  }
  return std::numeric_limits<double>::infinity();
}

Prediction Predict(const Scene& scene, const Posterior& posterior, const PredictionOptions& options) {
  ExpectOptions(scene, options);
  const Sampler sampler(scene, posterior, options);
  std::vector<Draw> draws = RollAll(sampler, options);
  Prediction prediction;
  prediction.has_force = sampler.has_force();
  const FinerChanges finer = sampler.RollFiner(&prediction.no_step, &prediction.no_mesh);
  std::vector<Eigen::Index> kept;
  for (std::size_t d = 0; d < draws.size(); ++d) {
    if (draws[d].failure.empty()) {
      kept.push_back(static_cast<Eigen::Index>(d));
    } else if (++prediction.num_failed == 1) {
      prediction.failure = draws[d].failure;
    }
  }
  if (options.cancel != nullptr && *options.cancel) return prediction;
  prediction.num_draws = static_cast<int>(kept.size());
  if (prediction.num_draws < kLeastDraws) {
    FailOnData(posterior.path, std::to_string(prediction.num_failed) + " of " + std::to_string(options.num_draws) +
                                   " rollouts failed, expected at least " + std::to_string(kLeastDraws) +
                                   " that do not: " + prediction.failure);
  }
  Eigen::MatrixXd factors = FinerFactors(options)(kept, Eigen::all);
  if (finer.step.size() == 0) factors.col(0).setZero();
  if (finer.mesh.size() == 0) factors.col(1).setZero();
  const Regressors regressors = RegressorsOf(posterior, sampler.values()(Eigen::all, kept), factors);
  const Eigen::Index num_frames = sampler.frame_steps().size(), num_rows = scene.initial_positions.size();
  prediction.times = scene.start_time + (scene.time_step * sampler.frame_steps().array());
  for (Eigen::MatrixXd& quantile : prediction.quantiles) quantile.resize(num_rows, num_frames);
  prediction.spread.setZero(num_frames);
  prediction.moved.setZero(num_frames);
  prediction.shares.parameters.setZero(num_frames);
  prediction.shares.finer.setZero(num_frames);
  prediction.shares.rest.setZero(num_frames);
  prediction.shares.each.setZero(num_frames, regressors.each.cols());
  const std::vector<int> free = FreeCoordinates(scene);
  Eigen::MatrixXd in_frame(num_rows, prediction.num_draws);
  for (Eigen::Index frame = 0; frame < num_frames; ++frame) {
    for (Eigen::Index d = 0; d < in_frame.cols(); ++d) {
      in_frame.col(d) = draws[static_cast<std::size_t>(kept[static_cast<std::size_t>(d)])].positions.col(frame);
    }
    if (finer.step.size() > 0) in_frame += finer.step.col(frame) * factors.col(0).transpose();
    if (finer.mesh.size() > 0) in_frame += finer.mesh.col(frame) * factors.col(1).transpose();
    if (!free.empty()) AddShares(regressors, in_frame(free, Eigen::all), frame, &prediction);
    const Eigen::MatrixXd bands = BandsOf(in_frame);
    for (std::size_t q = 0; q < kBandQuantiles.size(); ++q) {
      prediction.quantiles[q].col(frame) = bands.col(static_cast<Eigen::Index>(q));
    }
    const Eigen::VectorXd change = (prediction.median().col(frame) - prediction.median().col(0))(free);
    if (!free.empty()) prediction.moved[frame] = change.norm() / std::sqrt(static_cast<double>(change.size()));
  }
  return prediction;
}

}  // namespace clothid

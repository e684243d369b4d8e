// The rollouts of which bands are made. Internal to identify/prediction.
#ifndef CLOTHID_IDENTIFY_PREDICTION_SAMPLER_H_
#define CLOTHID_IDENTIFY_PREDICTION_SAMPLER_H_

#include <Eigen/Core>
#include <functional>
#include <limits>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "identify/prediction/posterior.h"
#include "identify/prediction/prediction_options.h"
#include "identify/prediction/random_force.h"
#include "identify/prediction/random_start.h"
#include "sim/scene/scene.h"

namespace clothid {

// What a rollout has come to in frames, or why there is nothing.
struct Draw {
  Eigen::MatrixXd positions;  // [3N x T] m
  Eigen::MatrixXd forces;     // [3G x T] N of the grippers (identify/prediction/derived.h); empty: nobody asked for it
  double slip = std::numeric_limits<double>::infinity();  // s, likewise
  std::string failure;
};

// What step and mesh of the scene do to a rollout of the estimates: differences of draws; no positions: not known.
struct FinerChanges {
  Draw step, mesh;
};

// Rollouts of one scene, each on the thread that asks for it.
class Sampler {
 public:
  // Keeps references.
  Sampler(const Scene& scene, const FitPosterior& posterior, const PredictionOptions& options);

  const Eigen::MatrixXd& values() const { return values_; }            // [p x D]
  const Eigen::VectorXd& frame_steps() const { return frame_steps_; }  // [T] times of frames in steps
  bool has_force() const { return force_ != nullptr; }
  bool has_start() const { return start_ && start_->moves_start(); }
  bool has_handles() const { return start_ && start_->moves_handles(); }

  Draw Roll(int draw) const;
  // The variance of coordinates `free` in every frame [T] where start or path of handles alone are drawn; zero where
  // too few rollouts work.
  Eigen::VectorXd VarianceAlone(bool of_start, const std::vector<int>& free) const;
  // Three rollouts side by side. `no_step`, `no_mesh`: why there is none.
  FinerChanges RollFiner(std::string* no_step, std::string* no_mesh) const;

 private:
  // The scene with true parameters, so that it has their terms, and they as a rollout takes them.
  struct DrawnScene {
    Scene scene;
    Parameters parameters;
  };
  using ForceOf = std::function<std::shared_ptr<const Correction>(const ClothModel&)>;

  DrawnScene SetDraw(const Scene& scene, const Eigen::VectorXd& values) const;
  // `force_of` may be empty, `handle_offsets` null.
  Draw RollOut(const DrawnScene& drawn, const Eigen::VectorXd& frame_steps, const ForceOf& force_of = {},
               const HandlePath* handle_offsets = nullptr) const;
  Draw RollMoved(int draw, bool moves_start, bool moves_handles, const ForceOf& force_of, DrawnScene* drawn) const;
  bool Asks(DerivedKind kind) const;
  Eigen::VectorXd Estimates() const;
  Draw RollHalfStep() const;
  Draw RollFineMesh() const;

  const Scene& scene_;
  const FitPosterior& posterior_;
  const PredictionOptions& options_;
  Eigen::MatrixXd values_;
  Eigen::VectorXd frame_steps_;
  std::unique_ptr<ForceSource> force_;  // null: none
  std::optional<RandomStart> start_;    // none: the fit took starts for known
};

}  // namespace clothid

#endif  // CLOTHID_IDENTIFY_PREDICTION_SAMPLER_H_

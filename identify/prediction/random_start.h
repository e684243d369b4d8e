// A start and a path of handles that nobody knows exactly, as draws about those of a scene.
//
// The free nodes are displaced by costs/start/start_spread.h; a node that this would put into an obstacle, or deeper
// into one, stays where it is. Handles that are joined by edges, as those of one gripper, are off together, by numbers
// of the deviation that is told at knots so far apart as it changes, and by nothing at the start, which is displaced
// without them. Where that never changes, it sets in within `kSetIn`.
#ifndef CLOTHID_IDENTIFY_PREDICTION_RANDOM_START_H_
#define CLOTHID_IDENTIFY_PREDICTION_RANDOM_START_H_

#include <cstdint>
#include <optional>
#include <vector>

#include "costs/start/start_spread.h"
#include "identify/prediction/posterior.h"
#include "sim/path/handle_path.h"
#include "sim/scene/scene.h"

namespace clothid {

// Const functions may be called on several threads.
class RandomStart {
 public:
  static constexpr double kSetIn = 0.1;  // s

  // `with_start`, `with_handles`: what of it is drawn. Keeps no reference.
  RandomStart(const Scene& scene, const LearntStart& start, bool with_start, bool with_handles);

  bool moves_start() const { return spread_.has_value(); }
  bool moves_handles() const { return handles_ > 0.0; }

  // Changes positions and velocities of `scene`, the one of the constructor but for its materials.
  void MoveStart(std::uint64_t seed, int draw, Scene* scene) const;
  // To be added to its path (`RolloutOptions::handle_offsets`).
  HandlePath HandleOffsets(std::uint64_t seed, int draw) const;

 private:
  std::optional<StartSpread> spread_;
  double handles_ = 0.0;      // m
  std::vector<int> gripper_;  // [H] of every handle
  Eigen::VectorXd knots_;     // s
};

}  // namespace clothid

#endif  // CLOTHID_IDENTIFY_PREDICTION_RANDOM_START_H_

// The truth of a recording that no model reproduces exactly: simulated on a grid of twice the density at a quarter of
// the scene's time step, seen at the nodes of the scene's own grid. The scene's model, given the true parameters, then
// misses it by its discretization error, as a model misses a cloth.
#ifndef CLOTHID_DATASETS_SYNTHETIC_FINE_TRUTH_H_
#define CLOTHID_DATASETS_SYNTHETIC_FINE_TRUTH_H_

#include <Eigen/Core>
#include <array>
#include <map>
#include <string>
#include <vector>

#include "datasets/motion/recorded_motion.h"
#include "datasets/synthetic/regrid.h"
#include "sim/rollout/rollout.h"

namespace clothid {

inline constexpr int kTrueStepDivisor = 4;  // the truth's time step is the scene's over this

struct FineTruth {
  std::array<int, 2> nodes = {};      // of its grid: 2n - 1 x 2m - 1 for n x m
  Scene scene;                        // on that grid
  std::vector<ObservedPoint> points;  // the nodes of the scene's own grid on it [P]
  Rollout rollout;

  double start_time() const { return scene.start_time; }
  double end_time() const { return scene.start_time + rollout.num_steps() * scene.time_step; }
  // [3P] m at a time (s) between them, linear between steps.
  Eigen::VectorXd PointsAt(double time) const;
};

// As long as the scene has steps. Throws `Error` for what `Regrid` and `SetTrueParameters` reject and where a step does
// not converge.
FineTruth SimulateFineTruth(const GridScene& grid_scene, const std::map<std::string, double>& truth,
                            const RolloutOptions& options = {});

}  // namespace clothid

#endif  // CLOTHID_DATASETS_SYNTHETIC_FINE_TRUTH_H_

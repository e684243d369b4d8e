// Forces that were measured at the handles of a cloth: by a robot's wrist sensor, or by the gauge of a tensile test.
#ifndef CLOTHID_DATASETS_MOTION_FORCE_READINGS_H_
#define CLOTHID_DATASETS_MOTION_FORCE_READINGS_H_

#include <Eigen/Core>
#include <vector>

namespace clothid {

// Of G groups of handles, each held by one sensor, at F times, on the clock of the scene and along its axes. A reading
// is the force with which what holds a group acts on the cloth: at rest its share of the weight, upwards.
struct ForceReadings {
  Eigen::VectorXd times;                 // [F] s, strictly increasing; they need not be those of the frames
  Eigen::MatrixXd values;                // [3G x F] N; NaN: not measured
  std::vector<std::vector<int>> groups;  // [G] nodes; empty: G = 1, all handles
  Eigen::VectorXd sigma;                 // [G] N, standard deviation of a component
  Eigen::MatrixXd moments = {};          // [3G x F] N m about the middle of a group; empty: not told. No fit takes them

  bool is_empty() const { return times.size() == 0; }
  int num_groups() const { return groups.empty() ? 1 : static_cast<int>(groups.size()); }
  int num_readings() const { return static_cast<int>(times.size()); }
};

}  // namespace clothid

#endif  // CLOTHID_DATASETS_MOTION_FORCE_READINGS_H_

// Synthetic recordings: a rollout with known parameters, seen through an imperfect sensor.
//
// The recording holds what a sensor and its operator would know: measured positions and the scene with its nominal
// values. The parameters of the rollout, the truth, are written nowhere in it.
#ifndef CLOTHID_DATASETS_SYNTHETIC_SYNTHETIC_H_
#define CLOTHID_DATASETS_SYNTHETIC_SYNTHETIC_H_

#include <Eigen/Core>
#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "datasets/formats/point_tracks.h"
#include "datasets/motion/motion_file.h"
#include "datasets/synthetic/force_sensor.h"
#include "sim/rollout/rollout.h"
#include "sim/scene/scene.h"

namespace clothid {

inline constexpr int kMaxCloudPointsPerFrame = 1000000;

struct SyntheticOptions {
  double noise_sigma = 0.0;    // m, standard deviation of Gaussian noise on every coordinate
  double frame_rate = 0.0;     // Hz; 0: one frame per step
  double drop_fraction = 0.0;  // in [0, 1): the chance of a point to be missing in a frame
  int num_markers = 0;         // free nodes seen, chosen by `seed`; 0: every node, or none where there are clouds
  int num_cloud_points = 0;    // per frame, unordered, anywhere on the surface; 0: no clouds
  std::optional<ForceSensor> force_sensor;  // at the handles; absent: no forces
  std::uint64_t seed = 1;                   // markers, noise, drops, clouds and forces have streams of their own
  bool single_precision =
      false;  // store positions as F32, which limits how well a truth can be recovered (about 1e-7 m)
};

// The times of the frames, relative to the start, in units of the time step: multiples of 1/(frame_rate h), rounded to
// a whole number of steps where that is meant. The last one is at most `num_steps`. Throws `Error` (kUsage) for less
// than two frames or more than kMaxFrames.
Eigen::VectorXd FrameSteps(double frame_rate, double time_step, int num_steps);

// The nodes [P] that are seen of so many markers, ascending: of the free ones, chosen by `seed`. 0: empty, every node.
std::vector<int> ChooseMarkers(const Scene& scene, int num_markers, std::uint64_t seed);

// Throws `Error` (kUsage) where `RecordRollout` would for a rollout of all of `scene`: for options out of range, a
// start that they spoil, and a recording of more than 4 GB of positions and clouds. To be asked before a long
// simulation.
void CheckSyntheticOptions(const SyntheticOptions& options, const Scene& scene, const std::string& scene_text);

// What the sensor saw of `rollout`, which must be ok() and come from `scene`; positions between steps are interpolated
// linearly. Same arguments, same result. `scene_text` is the JSON that `scene` was read from. The recording is
// self-contained: what the text takes from files is in its tensors or, the surfaces of obstacles, in the text in it,
// which no longer mentions the files. Paths of moving handles are sampled at the frames, without noise. Throws `Error`:
// kUsage for options out of range, where a start read from a file, of which the recording has its first frame alone,
// comes with markers, clouds or drops, and before the memory of a recording that is too large is asked for; kBadData
// where the surfaces are too large for a scene's text.
MotionTensors RecordRollout(const Rollout& rollout, const Scene& scene, const std::string& scene_text,
                            const SyntheticOptions& options);

// The same of all nodes, without a sensor: positions [3N x T] at `times` [T] s of `scene`.
MotionTensors RecordFrames(const Eigen::MatrixXd& positions, const Eigen::VectorXd& times, const Scene& scene,
                           const std::string& scene_text, const std::string& provenance);

}  // namespace clothid

#endif  // CLOTHID_DATASETS_SYNTHETIC_SYNTHETIC_H_

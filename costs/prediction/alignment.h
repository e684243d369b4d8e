// The parameters of a recording itself: how its clock and its frame of reference lie to those of the scene, a velocity
// that the cloth had at its start, and how far its handles are off. They are fitted beside those of the simulation, so
// that an error of the set-up does not end in friction or stiffness.
//
//   predicted_p(t_i) = R(turn) (x_p(t_i + time_offset) - c) + c + shift
//
// x: the rollout of the scene, started with v0 added to the velocity of every free node; its handles, obstacles and
// wind stay on the scene's clock and in the scene's frame, and so does its start, also where that is the first frame as
// it was recorded. R(turn): the rotation about the direction of `turn` by |turn|. c: the centroid of the measured
// points. So `shift` and `turn` are what must be added to the prediction to meet the recording, `time_offset` what must
// be added to the times of the recording to meet the scene: positive where its clock is behind.
//
// The path of the handles is often that of another instrument, such as a robot whose tool frame nobody measured:
//   handle i is at  c_h(t) + R(handle_turn)(path_i(t) - c_h(t)) + handle_shift + handle_shift of its group
// from the start on; the free nodes of the start stay where they were seen. c_h(t) is the mean of the path of all
// handles at that time: a tool whose axes were measured with an error holds its fingers elsewhere about its own place,
// wherever that goes. handle_turn [rad], along the axes of the scene, and the shifts [m] are the same at all times. Two
// grippers, each with an error of its own, are two groups of handles (`HandleGroups`). Beside an unknown start, which
// moves handles by what their sensor scatters (costs/start/unknown_start.h), all this is added to that, and the two are
// told apart by their priors alone; likewise the shift of all handles and those of all groups.
//
// Forces at handles (datasets/observation/force_observation.h) belong to the handles: none of these corrects them. A
// gauge that is off at zero does:
//   predicted force of a group = R + force_bias,   one vector for each group, N
#ifndef CLOTHID_COSTS_PREDICTION_ALIGNMENT_H_
#define CLOTHID_COSTS_PREDICTION_ALIGNMENT_H_

#include <Eigen/Core>
#include <string>
#include <vector>

#include "datasets/motion/recorded_motion.h"
#include "sim/scene/parameters.h"

namespace clothid {

struct Alignment {
  double time_offset = 0.0;                                  // s
  Eigen::Vector3d shift = Eigen::Vector3d::Zero();           // m
  Eigen::Vector3d turn = Eigen::Vector3d::Zero();            // rad, rotation vector
  Eigen::Vector3d start_velocity = Eigen::Vector3d::Zero();  // v0, m/s
  std::vector<Eigen::Vector3d> handle_shifts;                // m, of all handles and of the first groups
  Eigen::Vector3d handle_turn = Eigen::Vector3d::Zero();     // rad, rotation vector
  std::vector<Eigen::Vector3d> force_bias;                   // N, of the first groups; zero of the others

  // [3G] N.
  Eigen::VectorXd ForceBias(int num_groups) const;

  // `id`: of a recording.
  void Set(ParameterId id, double value);
};

// `names` with shift, turn, v0, handle_shift, handle_turn and force_bias, also of one group of handles, replaced by the
// three of each, and align by those of shift and turn; all others as they are.
std::vector<std::string> ExpandAlignmentNames(const std::vector<std::string>& names);

// Every name of what belongs to a recording, those that `ExpandAlignmentNames` replaces among them, for messages.
std::string KnownAlignmentNames();

// How far a parameter of a recording may be from zero unless bounds are given, in its own unit: the range of its row,
// which counts frame intervals (their median) of its clock, sizes of the cloth of shifts, also of handles, and the
// largest force that was measured along its axis of a force bias.
double DefaultAlignmentRange(ParameterId id, const RecordedMotion& motion);

// The groups of the handles that may be off by themselves, in the order of their first nodes: those that the
// recording's forces have, where it says which; else handles that edges of the mesh connect belong together.
std::vector<std::vector<int>> HandleGroups(const RecordedMotion& motion);

// The farthest that a bound may be from zero: of the time offset the duration of the recording, because the simulation
// has to cover it; of a turn pi, beyond which the same rotations come again; else infinite.
double LargestAlignmentBound(ParameterId id, const RecordedMotion& motion);

// Throws `Error` (kUsage), naming parameter and recording, where the recording has not what `id` is a correction of: a
// force bias wants forces that were measured along its axis, a shift of handles wants handles, or that group of them, a
// turn of handles wants two.
void ExpectMeasured(ParameterId id, const std::string& name, const RecordedMotion& motion);

// c: RecordedMotion::centroid, where it is given, else the mean of the measured points of all frames.
Eigen::Vector3d TurnCenter(const RecordedMotion& motion);

}  // namespace clothid

#endif  // CLOTHID_COSTS_PREDICTION_ALIGNMENT_H_

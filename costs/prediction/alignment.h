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
//   handle i is at  path_i(t) + handle_shift,   one vector for all handles and times, m
// from the start on; the free nodes of the start stay where they were seen. Beside an unknown start, which moves
// handles by what their sensor scatters (costs/start/unknown_start.h), it is added to that, and the two are told apart
// by their priors alone.
//
// Forces at handles (datasets/observation/force_observation.h) belong to the handles: none of these corrects them. A
// gauge that is off at zero does:
//   predicted force of a group = R + force_bias,   one vector for each group, N
#ifndef CLOTHID_COSTS_PREDICTION_ALIGNMENT_H_
#define CLOTHID_COSTS_PREDICTION_ALIGNMENT_H_

#include <Eigen/Core>
#include <optional>
#include <string>
#include <vector>

#include "datasets/motion/recorded_motion.h"

namespace clothid {

enum class AlignmentKind { kTimeOffset, kShift, kTurn, kStartVelocity, kHandleShift, kForceBias };

// One scalar of `Alignment`.
struct AlignmentId {
  AlignmentKind kind = AlignmentKind::kTimeOffset;
  int axis = 0;   // 0, 1, 2: x, y, z; of the time offset 0
  int group = 0;  // of handles, of a force bias

  bool operator==(const AlignmentId& other) const {
    return kind == other.kind && axis == other.axis && group == other.group;
  }
};

struct Alignment {
  double time_offset = 0.0;                                  // s
  Eigen::Vector3d shift = Eigen::Vector3d::Zero();           // m
  Eigen::Vector3d turn = Eigen::Vector3d::Zero();            // rad, rotation vector
  Eigen::Vector3d start_velocity = Eigen::Vector3d::Zero();  // v0, m/s
  Eigen::Vector3d handle_shift = Eigen::Vector3d::Zero();    // m
  std::vector<Eigen::Vector3d> force_bias;                   // N, of the first groups; zero of the others

  // [3G] N.
  Eigen::VectorXd ForceBias(int num_groups) const;

  void Set(AlignmentId id, double value);
};

// "time_offset", "shift.x" .. "shift.z", "turn.x" .., "v0.x" .., "handle_shift.x" .., "force_bias.x" .. of the first
// group of handles, "force_bias2.x" .. of the second, ..; nothing for any other name.
std::optional<AlignmentId> ParseAlignmentId(const std::string& name);

// `names` with shift, turn, v0, handle_shift and force_bias replaced by the three of each, and align by those of shift
// and turn; all others as they are.
std::vector<std::string> ExpandAlignmentNames(const std::vector<std::string>& names);

// "shift" of "shift.x"; a name without axes as it is.
std::string AlignmentGroup(const std::string& name);

// Every name that `ExpandAlignmentNames` and `ParseAlignmentId` know, for messages.
std::string KnownAlignmentNames();

// How far a parameter may be from zero unless bounds are given, in its own unit: two frame intervals (their median), a
// quarter of the cloth's size, 0.2 rad, 2 m/s, a tenth of the cloth's size, the largest force that was measured along
// that axis.
double DefaultAlignmentRange(AlignmentId id, const RecordedMotion& motion);

// The farthest that a bound may be from zero: of the time offset the duration of the recording, because the simulation
// has to cover it; of a turn pi, beyond which the same rotations come again; else infinite.
double LargestAlignmentBound(AlignmentId id, const RecordedMotion& motion);

// Throws `Error` (kUsage), naming parameter and recording, where the recording has not what `id` is a correction of: a
// force bias wants forces that were measured along its axis, a shift of handles wants handles.
void ExpectMeasured(AlignmentId id, const std::string& name, const RecordedMotion& motion);

// c: RecordedMotion::centroid, where it is given, else the mean of the measured points of all frames.
Eigen::Vector3d TurnCenter(const RecordedMotion& motion);

}  // namespace clothid

#endif  // CLOTHID_COSTS_PREDICTION_ALIGNMENT_H_

// Forces at handles for a recording, from a file of a sensor at another rate and clock.
#ifndef CLOTHID_DATASETS_IMPORTING_FORCE_FILE_H_
#define CLOTHID_DATASETS_IMPORTING_FORCE_FILE_H_

#include <Eigen/Core>
#include <Eigen/Geometry>
#include <optional>
#include <string>
#include <vector>

#include "datasets/motion/force_readings.h"

namespace clothid {

// A name that ends in .npy: an array of shape [F], one component, [F, 3] or [F, G, 3]. Any other: a table
// (sim/base/table.h) of `time` and the components that were measured, `x`, `y`, `z` of one group, `x0`, `y0`, .., `z1`
// of several; an empty cell or nan was not measured.
struct ForceFile {
  std::string path;
  std::string
      times_path;  // .npy alone: [F] s, as `ReadTimes` reads them; empty: those of the frames, if there are as many
  std::vector<std::vector<int>> groups;  // empty: all handles are one
  std::optional<int> axis;               // 0, 1, 2: of an array of shape [F]
  double scale = 1.0;        // to N, and to the force on the cloth: negative where it is that on the gripper
  double sigma = 0.0;        // N, of a component
  double time_offset = 0.0;  // s: its clock minus that of the recording; taken off the times of the frames, too
};

// On the clock of the recording, which has frames at `times` [T] s and was shifted by `time_shift` s. Readings before
// the first and after the last frame are left out. Throws `Error`: kUsage for a sigma that is none, or an axis that is
// missing or not wanted, kIo and kBadData for files, naming file and line, kBadData where no reading is left.
ForceReadings ReadForces(const ForceFile& file, const Eigen::VectorXd& times, double time_shift);

// The text of such a CSV file, whose numbers read back exactly.
std::string ForceCsv(const ForceReadings& forces);

// Leaves the readings between the first and the last of `times`.
void KeepReadingsWithin(const Eigen::VectorXd& times, ForceReadings* forces);

// Turns the axes of the readings. Throws `Error` (kBadData), led by `source`, where a component is not known.
void TurnForces(const Eigen::Matrix3d& rotation, const std::string& source, ForceReadings* forces);

// "0,1:4,5": groups of nodes, in this order. Empty text: none. Throws `Error` (kUsage), naming `flag`.
std::vector<std::vector<int>> ParseForceGroups(const std::string& text, const std::string& flag);

}  // namespace clothid

#endif  // CLOTHID_DATASETS_IMPORTING_FORCE_FILE_H_

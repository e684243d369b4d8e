// A cantilever test: a strip of cloth that overhangs an edge and sags. Tables (datasets/curves/lab_table.h) of
//   overhang and angle     of a specimen a row: the angle of the line from the edge to the tip below the level
//   overhang               at 41.5 degrees, the plane of the usual bench (ISO 9073-7, ASTM D1388)
//   x and z (or y)         points of the profile of one strip at rest, from the edge of the clamp on: forwards and up
// become the recording of a strip that is clamped at one end, starts level and has come to rest at its last frame. What
// was measured is seen there alone: the tip, or the profile and the edge of the clamp as a cloud.
//
// Such a test tells the rigidity over the weight. The strip has 5 x 49 nodes, the first row in a clamp, and a stretch
// stiffness of 1000 N/m: its weight stretches it by less than 0.1 %. 40 steps of 0.2 s of backward Euler bring it to
// rest, which the steps do not change. Against the elastica of a strip that does not stretch its rigidity is then off
// by less than 0.3 %.
#ifndef CLOTHID_DATASETS_CURVES_CANTILEVER_H_
#define CLOTHID_DATASETS_CURVES_CANTILEVER_H_

#include <Eigen/Core>
#include <string>

#include "datasets/curves/tensile_recording.h"
#include "datasets/motion/motion_tensors.h"

namespace clothid {

inline constexpr double kBenchAngle = 0.72431164;  // rad, 41.5 degrees

struct CantileverTable {
  std::string name;             // for messages: the file
  Eigen::VectorXd overhangs;    // [R] m; or, of a profile, one: the length of the line through its points
  Eigen::VectorXd angles;       // [R] rad; of a profile that of its last point, at most 75 degrees
  Eigen::Matrix2Xd profile;     // [2 x P] m, x and z; or empty
  bool is_bench_angle = false;  // the table has no angles
  bool is_turned = false;       // z was given downwards
  std::string columns;          // what was read

  bool is_profile() const { return profile.cols() > 0; }
  // m, of each row by the heavy elastica.
  Eigen::VectorXd BendingLengths() const;
};

// Throws `Error` as `ReadLabTable`, and kBadData, naming file and line, for an overhang that is none of a strip, an
// angle outside of 1 to 75 degrees, and points of a profile that are too few, do not go forwards or do not sag.
CantileverTable ReadCantileverTable(const std::string& path);

struct CantileverStrip {
  double width = 0.025;                            // m
  double overhang = 0.0;                           // m
  double density = 0.0;                            // kg/m^2
  double sigma = 0.0;                              // m, of a coordinate of what is seen
  double nominal = 0.0;                            // N m, where a fit starts
  bool has_warp = false;                           // with bend_warp, bend_weft and bend_twist in place of k_bend
  PullDirection direction = PullDirection::kWarp;  // along which the strip was cut, with these
};

// "k_bend", or "bend_warp".
std::string ParameterOfCantilever(const CantileverStrip& strip);

// A recording of the tip at a place, m from the edge, or of a profile; `ReadMotion` has been tried on it. Throws
// `Error` (kUsage) where a number of the strip is not above 0.
MotionTensors RecordCantilever(const Eigen::Vector2d& tip, const CantileverStrip& strip, const std::string& provenance);
MotionTensors RecordProfile(const Eigen::Matrix2Xd& profile, const CantileverStrip& strip,
                            const std::string& provenance);

}  // namespace clothid

#endif  // CLOTHID_DATASETS_CURVES_CANTILEVER_H_

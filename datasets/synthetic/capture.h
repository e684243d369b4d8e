// A recording as a laboratory brings it: points of a camera and a path of a gripper, each with its own clock, of a
// motion that no model reproduces exactly, with the faults of datasets/synthetic/sensor.h.
#ifndef CLOTHID_DATASETS_SYNTHETIC_CAPTURE_H_
#define CLOTHID_DATASETS_SYNTHETIC_CAPTURE_H_

#include <cstdint>

#include "datasets/formats/point_tracks.h"
#include "datasets/synthetic/fine_truth.h"
#include "datasets/synthetic/regrid.h"
#include "datasets/synthetic/sensor.h"

namespace clothid {

struct Capture {
  PointTracks points;    // the nodes of the scene's grid, as the camera sees them
  PointTracks handles;   // the scene's handles, as the gripper tells them; no points where the scene moves none
  ForceReadings forces;  // on all handles, on the clock of their sensor; empty where there is none
};

// Same arguments, same result. Throws `Error` where `SeePoints` and `ReadForceSensor` do.
Capture TakeCapture(const GridScene& grid_scene, const FineTruth& truth, const Sensor& sensor, std::uint64_t seed);

}  // namespace clothid

#endif  // CLOTHID_DATASETS_SYNTHETIC_CAPTURE_H_

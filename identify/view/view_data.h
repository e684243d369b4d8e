// What the page of a recording holds.
#ifndef CLOTHID_IDENTIFY_VIEW_VIEW_DATA_H_
#define CLOTHID_IDENTIFY_VIEW_VIEW_DATA_H_

#include <cstddef>
#include <nlohmann/json.hpp>

#include "datasets/motion/recorded_motion.h"

namespace clothid {

// The data of view.html, in at most `max_bytes`: "name", "simulated", "sha256", "provenance"; "verdict" and "findings"
// as `FindingsJson` has them, but for "runs", the first and the last frame of those that follow each other, in place of
// frames and points, and "num_frames"; "scene", its constants, obstacles and handles; "points", "frames", "times", the
// first and the last, s; "replay" as `ReplayJson` has it. Per frame of the replay, where there is one: "unseen",
// tracked points that were not seen, "cloud_points", and "wind" {"x", "y", "z"} in the middle of the cloth, m/s. "far":
// points of all frames that are so far from the others that the replay leaves them out. "cloud_stride": of so many
// points of a cloud one is shown. "forces" as `ForcesJson` has them. What a recording does not have is absent.
nlohmann::ordered_json ViewData(const RecordedMotion& motion, bool is_simulated, std::size_t max_bytes);

}  // namespace clothid

#endif  // CLOTHID_IDENTIFY_VIEW_VIEW_DATA_H_

// A fine truth seen by a camera and a gripper (datasets/synthetic/sensor.h), brought to a recording as a user brings
// it: imported, checked, and without the frames that the check calls reordered. For `benchmark coverage --sensor`.
#ifndef CLOTHID_TOOLS_BENCHMARK_FITS_SENSOR_CASE_H_
#define CLOTHID_TOOLS_BENCHMARK_FITS_SENSOR_CASE_H_

#include <cstdint>
#include <string>
#include <vector>

#include "costs/prediction/robust_loss.h"
#include "datasets/motion/recorded_motion.h"
#include "datasets/synthetic/fine_truth.h"
#include "datasets/synthetic/regrid.h"
#include "datasets/synthetic/sensor.h"

namespace clothid {

// clean: the sensor's noise without its faults: frames at its mean interval and no gap, every point in every frame and
// in its place, a gripper without noise. faults: the sensor as it is. huber, outliers: as faults, with 5 % of the
// points far off, with and without a robust loss. markers: as faults, but every twentieth node alone is seen, drawn
// anew by each seed, and is never taken for another one.
inline const std::vector<std::string> kSensorSettings = {"clean", "faults", "huber", "outliers", "markers"};

// What is left of the difference of the clocks of camera and gripper when the user has read it off, s.
inline constexpr double kClockError = 0.01;

struct SensorCase {
  GridScene grid_scene;
  FineTruth truth;
  Sensor sensor;
};

// Throws `Error` for files that cannot be used and where the truth fails.
SensorCase ReadSensorCase(const std::string& scene_path, const std::string& sensor_path,
                          const std::vector<TrueParameter>& truth);

// What the fit of a setting is given. Its sigma is estimated, and its times differ from those of the handles by
// `kClockError`. Same arguments, same recording; may be called side by side. Throws `Error` as `ImportMotion` does.
RecordedMotion RecordSensorCase(const SensorCase& sensor_case, const std::string& setting, std::uint64_t seed);

// huber:2 in the setting of this name, else none.
RobustLoss LossOfSetting(const std::string& setting);

}  // namespace clothid

#endif  // CLOTHID_TOOLS_BENCHMARK_FITS_SENSOR_CASE_H_

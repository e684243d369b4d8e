// sensor.json.
#include <cmath>

#include "datasets/synthetic/sensor.h"
#include "tests/fuzz/fuzz_target.h"

int clothid::FuzzSensor(const std::uint8_t* data, std::size_t size) {
  Sensor sensor;
  if (!Accepts([&] { sensor = ParseSensor(std::string(AsText(data, size)), "sensor.json"); }, "sensor.json")) return 0;
  Check(sensor.interval[0] > 0.0 && sensor.interval[0] <= sensor.interval[1], "intervals > 0");
  Check(sensor.noise.minCoeff() >= 0.0 && sensor.gripper_rate > 0.0, "noise and rate that can be");
  Check(std::abs(sensor.pose.linear().determinant() - 1.0) < 1e-9, "a rotation");
  return 0;
}

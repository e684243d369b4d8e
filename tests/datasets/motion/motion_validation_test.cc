// Recordings that a program makes by hand: what is wrong with them is told, with its field and its place.
#include "datasets/motion/motion_validation.h"

#include <gtest/gtest.h>

#include <cmath>
#include <functional>
#include <limits>

#include "costs/rollout_cost.h"
#include "tests/costs/synthetic_clouds.h"
#include "tests/costs/synthetic_motion.h"
#include "tests/expect_error.h"

namespace clothid::motion_validation_test {
namespace {

constexpr double kNaN = std::numeric_limits<double>::quiet_NaN();
constexpr double kInfinity = std::numeric_limits<double>::infinity();

RecordedMotion GoodMotion() {
  MotionOptions options;
  options.sigma = 1e-3;
  RecordedMotion motion = MakeMotion(SphereScene(), options);
  AddClouds(3, 0.0, /*keep_points=*/true, &motion);
  motion.points[2].num_nodes = 3;
  for (int k = 0; k < 3; ++k) {
    motion.points[2].nodes[k] = motion.scene.mesh.faces(k, 0);
    motion.points[2].weights[k] = k == 1 ? 0.5 : 0.25;
  }
  motion.positions(3, 1) = kNaN;
  return motion;
}

struct Fault {
  std::function<void(RecordedMotion*)> make;
  const char* place;
  const char* problem;
};

std::vector<Fault> FaultsOfPoints() {
  return {
      {[](RecordedMotion* m) { m->points[4].num_nodes = 2; }, "points[4]", "expected 1 or 3"},
      {[](RecordedMotion* m) { m->points[4].nodes[0] = 25; }, "points[4].nodes[0]", "expected 0 to 24"},
      {[](RecordedMotion* m) { m->points[2].nodes[2] = -1; }, "points[2].nodes[2]", "expected 0 to 24"},
      {[](RecordedMotion* m) { m->points[2].weights[1] += 1e-3; }, "points[2]", "expected 1"},
      {[](RecordedMotion* m) { m->points[3].weights[0] = kNaN; }, "points[3]", "expected 1"},
      {[](RecordedMotion* m) { m->points.pop_back(); }, "positions", "expected [72 x 21]"},
      {[](RecordedMotion* m) { m->positions.conservativeResize(75, 20); }, "positions", "[75 x 20]"},
      {[](RecordedMotion* m) { m->positions(7, 5) = kInfinity; }, "positions", "frame 5"},
      {[](RecordedMotion* m) { m->sigma[6] = 0.0; }, "sigma[6]", "> 0"},
      {[](RecordedMotion* m) { m->sigma[6] = kNaN; }, "sigma[6]", "> 0"},
      {[](RecordedMotion* m) { m->sigma.conservativeResize(3); }, "sigma", "expected 25"},
  };
}

std::vector<Fault> FaultsOfTimes() {
  return {
      {[](RecordedMotion* m) { std::swap(m->times[3], m->times[4]); }, "times[4]", "not above"},
      {[](RecordedMotion* m) { m->times[3] = m->times[2]; }, "times[3]", "not above"},
      {[](RecordedMotion* m) { m->times[7] = kNaN; }, "times[7]", "not finite"},
      {[](RecordedMotion* m) { m->times[0] = -0.004; }, "times[0]", "before the start"},
      {[](RecordedMotion* m) { m->times[20] = 1e8; }, "times[20]", "1e+10 steps"},
      {[](RecordedMotion* m) { m->times.resize(0); }, "times", "at least one"},
      {[](RecordedMotion* m) { m->scene.time_step = 0.0; }, "scene.time_step", "> 0"},
      {[](RecordedMotion* m) { m->scene.start_time = kNaN; }, "times[0]", "before the start"},
  };
}

std::vector<Fault> FaultsOfCloudsAndScene() {
  return {
      {[](RecordedMotion* m) { m->clouds.pop_back(); }, "clouds", "each of the 21 times"},
      {[](RecordedMotion* m) { m->clouds[3](1, 2) = kNaN; }, "clouds", "frame 3"},
      {[](RecordedMotion* m) { m->cloud_sigma = -1.0; }, "cloud_sigma", "> 0"},
      {[](RecordedMotion* m) { m->scene.initial_positions.resize(0); }, "scene.initial_positions", "expected 75"},
      {[](RecordedMotion* m) { m->scene.initial_velocities.resize(3); }, "scene.initial_velocities", "found 3"},
      {[](RecordedMotion* m) { m->scene.handles.nodes[1] = 25; }, "scene.handles.nodes[1]", "expected 0 to 24"},
      {[](RecordedMotion* m) { m->scene.mesh.faces(0, 0) = 25; }, "triangle 0", "expected 0 to 24"},
  };
}

void ExpectRefused(const std::vector<Fault>& faults) {
  for (const Fault& fault : faults) {
    RecordedMotion motion = GoodMotion();
    const std::vector<ParameterBlock> blocks = MakeBlocks(motion.scene, {"k_stretch"});
    fault.make(&motion);
    SCOPED_TRACE(fault.place);
    ExpectError([&] { ValidateMotion(motion); }, ErrorKind::kBadData, {"synthetic: ", fault.place, fault.problem});
    ExpectError([&] { Observation{motion}; }, ErrorKind::kBadData, {"synthetic: ", fault.place, fault.problem});
    ExpectError([&] { RolloutCost(motion, blocks, {}); }, ErrorKind::kBadData,
                {"synthetic: ", fault.place, fault.problem});
  }
}

TEST(MotionValidationTest, AcceptsWhatCanBePredicted) {
  ValidateMotion(GoodMotion());
  RecordedMotion motion = GoodMotion();
  motion.times[0] = -1e-13;  // rounding
  motion.sigma.resize(0);
  motion.clouds.clear();
  ValidateMotion(motion);
}

TEST(MotionValidationTest, RefusesPointsThatAreNone) { ExpectRefused(FaultsOfPoints()); }

TEST(MotionValidationTest, RefusesTimesThatCannotBeSimulated) { ExpectRefused(FaultsOfTimes()); }

TEST(MotionValidationTest, RefusesCloudsAndScenesOfOtherSizes) { ExpectRefused(FaultsOfCloudsAndScene()); }

TEST(MotionValidationTest, ParametersOfARecordingNeedAValidOne) {
  RecordedMotion motion = GoodMotion();
  motion.times.resize(0);
  ExpectError([&] { MakeParameterBlock("time_offset", motion, {}); }, ErrorKind::kBadData, {"times", "at least one"});
}

}  // namespace
}  // namespace clothid::motion_validation_test

// Nothing is warned of in recordings that are right. Real ones: captures_test.cc.
#include <gtest/gtest.h>

#include <nlohmann/json.hpp>
#include <string>
#include <utility>
#include <vector>

#include "datasets/checking/motion_check.h"
#include "tests/datasets/importing/made_up_capture.h"
#include "tests/identify/simulated_recordings.h"

namespace clothid::right_inputs_test {
namespace {

void ExpectNoWarning(const RecordedMotion& motion) {
  for (const Finding& finding : CheckMotion(motion)) {
    EXPECT_LT(finding.severity, Severity::kWarning) << motion.name << ": " << finding.what << ": " << finding.value;
  }
}

TEST(RightInputs, ShippedOnesAreNotWarnedOf) {
  for (const std::string name : {"bounce", "capture", "drape", "slope", "wind"}) {
    ExpectNoWarning(ReadMotion(kDatasets + name + ".motion.bin"));
    ReadMotionOptions options;
    options.start = StartSource::kSmoothed;
    options.sigma_source = SigmaSource::kEstimated;
    if (name == "capture") ExpectNoWarning(ReadMotion(kDatasets + name + ".motion.bin", options));
  }
}

TEST(RightInputs, SimulatedOnesAreNotWarnedOf) {
  ExpectNoWarning(AsFitted(Clouds()));
  ExpectNoWarning(AsFitted(MadeUpCapture()));
  for (const std::string name : {"bounce", "drape", "pair", "slope", "wind"}) {
    for (const double noise : {0.001, 0.003}) {
      for (const double frame_rate : {20.0, 60.0}) {
        SyntheticOptions options;
        options.noise_sigma = noise;
        options.frame_rate = frame_rate;
        options.drop_fraction = 0.03;
        SCOPED_TRACE(name + ", noise " + std::to_string(noise) + ", " + std::to_string(frame_rate) + " Hz");
        ExpectNoWarning(AsFitted(Simulated(name, options)));
      }
    }
  }
}

// A square of 10 x 10 nodes, 0.3 m wide, flat at z = 0, for half a second, unless `rest` says otherwise.
std::string Square(const std::string& rest) {
  nlohmann::json scene = nlohmann::json::parse(
      R"({"clothid_scene": 1, "time_step": 0.005, "duration": 0.5, "initial": {"positions": "rest"},
          "mesh": {"grid": {"nodes": [10, 10], "size": [0.3, 0.3]}}})");
  scene.update(nlohmann::json::parse("{" + rest + "}"));
  return scene.dump();
}

// Motions in which gravity, contact or handles look unusual.
TEST(RightInputs, UnusualOnesAreNotWarnedOf) {
  const std::string floor = R"("obstacles": [{"type": "plane", "point": [0, 0, -0.15], "normal": [0, 0, 1]}])";
  const std::vector<std::pair<std::string, std::string>> scenes = {
      {"a fall that the air slows down", R"("materials": {"density": 0.05, "drag": 0.3}, )" + floor},
      {"a throw", R"("initial": {"positions": "rest", "velocity": [1, 0, 2]}, )" + floor},
      {"a stiff strip, clamped",
       R"("handles": [0, 1, 10, 11, 20, 21, 30, 31, 40, 41, 50, 51, 60, 61, 70, 71, 80, 81, 90, 91],
          "materials": {"density": 0.4, "k_stretch": 300, "k_bend": 0.05})"},
      {"a stiff strip, held by its edge",
       R"("handles": [0, 10, 20, 30, 40, 50, 60, 70, 80, 90], "materials": {"k_stretch": 300, "k_bend": 0.01})"},
      {"held by four corners", R"("handles": [0, 9, 90, 99])"},
      {"held by one corner", R"("handles": [0])"},
      {"let go from the flat, for a moment", R"("handles": [0, 1, 2, 3, 4, 5, 6, 7, 8, 9], "duration": 0.1)"},
      {"held in the middle, over a floor", R"("handles": [44, 45, 54, 55], )" + floor},
      {"over a ball, without handles",
       R"("obstacles": [{"type": "sphere", "center": [0.15, 0.15, -0.11], "radius": 0.1}])"},
      {"lifted by a ball below its corners",
       R"("handles": [0, 9, 90, 99],
          "obstacles": [{"type": "sphere", "center": [0.15, 0.15, -0.101], "radius": 0.1}])"},
      {"along a wall", R"("handles": [0, 9], "obstacles": [{"type": "plane", "point": [0, -0.001, 0],
                                                             "normal": [0, 1, 0]}])"},
  };
  for (const auto& [name, rest] : scenes) {
    for (const double noise : {0.0, 0.002}) {
      SyntheticOptions options;
      options.noise_sigma = noise;
      options.frame_rate = noise > 0.0 ? 60.0 : 0.0;
      SCOPED_TRACE(name + ", noise " + std::to_string(noise));
      ExpectNoWarning(AsFitted(SimulatedText(Square(rest), options)));
    }
  }
}

}  // namespace
}  // namespace clothid::right_inputs_test

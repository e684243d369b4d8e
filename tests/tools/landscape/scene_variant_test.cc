#include "tools/landscape/scene_variant.h"

#include <gtest/gtest.h>

#include <nlohmann/json.hpp>

#include "datasets/motion/motion_file.h"
#include "datasets/synthetic/synthetic.h"
#include "sim/obstacle/obstacle.h"
#include "sim/rollout/simulator.h"
#include "sim/scene/scene_json.h"
#include "tests/expect_error.h"
#include "tests/temporary_folder.h"

namespace clothid::scene_variant_test {
namespace {

constexpr char kScene[] = R"({
  "clothid_scene": 1, "time_step": 0.01, "duration": 0.03,
  "wind": {"mean": [1, 2, 3]},
  "mesh": {"grid": {"nodes": [3, 3], "size": [0.2, 0.2]}}, "handles": [0],
  "obstacles": [{"type": "plane", "point": [0, 0, -1], "normal": [0, 0, 1]},
                {"name": "ball", "type": "sphere", "center": [0.1, 0.2, -0.5], "radius": 0.1, "mu": 0.3}],
  "materials": {"density": 0.2, "k_stretch": 50, "drag": 0.1},
  "parameters": {"mu.ball": {"nominal": 0.2}}
})";

SceneVariant Variant(const std::string& text) { return ParseSweep(text).front(); }

RecordedMotion ReadVariant(const std::string& path, const ReadMotionOptions& options, const SceneVariant& variant) {
  return ReadMotionVariant([&](const ReadMotionOptions& how) { return ReadMotion(path, how); }, options, variant);
}

std::string Change(const std::string& text) { return ChangeScene(kScene, {"plane", "ball"}, Variant(text)); }

TEST(SceneVariant, EveryCombinationTheLastKeyFastest) {
  const std::vector<SceneVariant> variants = ParseSweep("ball.center.x=-0.1,0;touch=1e-5,1e-3,0.5");
  ASSERT_EQ(variants.size(), 6u);
  EXPECT_EQ(VariantName(variants[0]), "ball.center.x=-0.1;touch=1e-05");
  EXPECT_EQ(VariantName(variants[1]), "ball.center.x=-0.1;touch=0.001");
  EXPECT_EQ(VariantName(variants[5]), "ball.center.x=0;touch=0.5");
  ASSERT_EQ(ParseSweep("").size(), 1u);
  EXPECT_EQ(VariantName(ParseSweep("").front()), "");
  const SceneVariant odd = {{"touch", 0.1 + 0.2}};
  EXPECT_EQ(Variant(VariantName(odd))[0].value, 0.1 + 0.2);
}

TEST(SceneVariant, RefusesWhatIsNoSweep) {
  for (const char* text : {"touch", "=1", "touch=", "touch=a", "touch=1,", "touch=1;", ";touch=1", "touch=nan"}) {
    ExpectError([&] { ParseSweep(text); }, ErrorKind::kUsage, {"--sweep", "KEY=NUMBER"});
  }
  ExpectError([] { ParseSweep("touch=1;touch=2"); }, ErrorKind::kUsage, {"--sweep", "'touch'", "twice"});
  ExpectError([] { ParseSweep("touch=1,1.0"); }, ErrorKind::kUsage, {"--sweep", "1.0 twice"});
  std::string many = "a=0";
  for (int i = 1; i < 200; ++i) many += "," + std::to_string(i);
  ExpectError([&] { ParseSweep(many + ";b" + many.substr(1)); }, ErrorKind::kUsage, {"--sweep", "10000"});
  std::string keys = "a=0";
  for (int i = 1; i <= 16; ++i) keys += ";a" + std::to_string(i) + "=0";
  ExpectError([&] { ParseSweep(keys); }, ErrorKind::kUsage, {"--sweep", "more than 16 keys"});
}

TEST(SceneVariant, ChangesTheNumberThatIsMeant) {
  const auto expect_changed = [](const std::string& text, const char* pointer, double value) {
    nlohmann::ordered_json expected = nlohmann::ordered_json::parse(kScene);
    expected[nlohmann::ordered_json::json_pointer(pointer)] = value;
    EXPECT_EQ(nlohmann::ordered_json::parse(Change(text)), expected) << text;
  };
  expect_changed("ball.center.x=-0.05", "/obstacles/1/center/0", -0.05);
  expect_changed("ball.center.2=0.25", "/obstacles/1/center/2", 0.25);
  expect_changed("ball.mu=0.5", "/obstacles/1/mu", 0.5);
  expect_changed("ball.contact_distance=0.5", "/obstacles/1/contact_distance", 0.5);
  expect_changed("plane.point.z=-2.5", "/obstacles/0/point/2", -2.5);
  expect_changed("obstacles.0.mu=0.5", "/obstacles/0/mu", 0.5);
  expect_changed("wind.mean.y=7", "/wind/mean/1", 7);
  expect_changed("time_step=0.005", "/time_step", 0.005);
  expect_changed("touch=1e-3", "/touch", 1e-3);
  expect_changed("solver.step_tolerance=1e-6", "/solver/step_tolerance", 1e-6);
  expect_changed("parameters.mu.ball.nominal=0.4", "/parameters/mu.ball/nominal", 0.4);
  expect_changed("materials.density=0.3", "/materials/density", 0.3);
  EXPECT_EQ(ChangeScene(kScene, {"plane", "ball"}, {}), kScene);
  const Scene scene = ParseScene(Change("ball.center.x=-0.05;solver.max_newton_iterations=30"), "scene", "");
  EXPECT_EQ(scene.solver.max_newton_iterations, 30);
  EXPECT_LT(scene.obstacles[1].shape->Closest({-0.05, 0.2, -0.45}).gap, 0.0);
}

TEST(SceneVariant, RefusesKeysThatLeadNowhere) {
  const auto expect_refused = [](const std::string& text, const char* expected) {
    ExpectError([&] { Change(text); }, ErrorKind::kUsage, {"--sweep", expected});
  };
  expect_refused("ball.center.w=1", "'w': expected x, y, z or an index below 3");
  expect_refused("ball.center.3=1", "'3'");
  expect_refused("ball.center.-1=1", "'-1'");
  expect_refused("ball.center=1", "the key of a number");
  expect_refused("ball.type=1", "the key of a number");
  expect_refused("mesh=1", "the key of a number");
  expect_refused("time_step.x=1", "nothing below 'time_step'");
  expect_refused("obstacles.2.mu=1", "'2'");
  expect_refused("a.b.c.d.e.f.g.h.i.j.k.l.m.n.o.p.q=1", "more than 16 parts");
  EXPECT_EQ(Change("\xff=1"), Change("\xEF\xBF\xBD=1")) << "text, whatever the key";
}

class VariantOfARecordingTest : public testing::Test {
 protected:
  VariantOfARecordingTest() : path_(folder_.File("cloth.motion.bin")) {
    const Scene scene = ParseScene(kScene, "scene", "");
    Simulator simulator(scene);
    const Rollout rollout = Simulate(scene.nominal_parameters(), scene.num_steps(), &simulator);
    WriteMotion(RecordRollout(rollout, scene, kScene, {}), path_);
  }

  static ReadMotionOptions WithScene(const std::string& path) {
    ReadMotionOptions options;
    options.scene_path = path;
    return options;
  }

  TemporaryFolder folder_;
  std::string path_;
};

TEST_F(VariantOfARecordingTest, HasTheRecordingsMeshAndTheChangedScene) {
  const RecordedMotion plain = ReadVariant(path_, {}, {});
  const RecordedMotion changed = ReadVariant(path_, {}, Variant("ball.radius=0.25;time_step=0.005;touch=1e-3"));
  EXPECT_EQ(plain.scene_text, ReadMotion(path_).scene_text);
  EXPECT_EQ(changed.scene.touch, 1e-3);
  EXPECT_EQ(changed.scene.time_step, 0.005);
  EXPECT_EQ(changed.scene.num_steps(), 6);
  EXPECT_NEAR(changed.scene.obstacles[1].shape->Closest({0.1, 0.2, 0.0}).gap, 0.25, 1e-12);
  EXPECT_EQ(changed.positions, plain.positions);
  EXPECT_EQ(changed.sha256, plain.sha256);
  EXPECT_NE(changed.scene_text, plain.scene_text);

  const std::string scene = folder_.Write("other.json", R"({"clothid_scene": 1, "time_step": 0.01, "touch": 0.5})");
  EXPECT_EQ(ReadVariant(path_, WithScene(scene), Variant("touch=0.25;time_step=0.02")).scene.time_step, 0.02);
}

TEST_F(VariantOfARecordingTest, NamesTheFlagAndTheVariant) {
  const auto expect_refused = [&](const std::string& text, const char* expected) {
    ExpectError([&] { ReadVariant(path_, {}, Variant(text)); }, ErrorKind::kUsage, {"--sweep", text.c_str(), expected});
  };
  expect_refused("bal.center.x=1", "key 'bal'");
  expect_refused("ball.centre.x=1", "centre");
  expect_refused("touch=-1", "key 'touch'");
  expect_refused("gravity.x=1", "key 'gravity'");
  expect_refused("gravity.x=1", "the scene has to have the array");
  expect_refused("contact=1", "key 'contact'");
  expect_refused("solver.max_newton_iterations=2.5", "integer");
  ExpectError([&] { ReadVariant(path_, {}, Variant("duration=1")); }, ErrorKind::kUsage,
              {"--sweep: 'duration': has no effect"});
  ExpectError([&] { ReadVariant(path_, {}, Variant("parameters.mu.nominal=1")); }, ErrorKind::kUsage,
              {"--sweep: 'parameters.mu.nominal': has no effect"});
  ExpectError([&] { ReadVariant(path_, {}, Variant("ball.center.w=1")); }, ErrorKind::kUsage,
              {"--sweep: 'ball.center.w': 'w'"});
  ExpectError([&] { ReadVariant(path_ + "x", {}, Variant("touch=1")); }, ErrorKind::kIo, {path_.c_str()});
  ExpectError([&] { ReadVariant(path_, WithScene(folder_.Write("bad.json", "{")), Variant("touch=1")); },
              ErrorKind::kBadData, {"bad.json"});
}

}  // namespace
}  // namespace clothid::scene_variant_test

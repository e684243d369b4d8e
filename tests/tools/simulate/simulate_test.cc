// `simulate` as a program: what it writes, and what it refuses.
#include <gtest/gtest.h>

#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "datasets/motion/motion_file.h"
#include "tests/tools/tool_test.h"

namespace clothid::simulate_test {
namespace {

using Json = nlohmann::ordered_json;

class SimulateTest : public ToolTest {
 protected:
  // Simulates `scene` with `flags` and returns the bytes of the recording.
  std::string Record(const Json& scene, const std::string& flags) const {
    ExpectSuccess("simulate --scene " + WriteScene(scene) + " --output out.bin " + flags);
    return ReadBytes(folder() / "out.bin");
  }

  void ExpectSceneRefused(const Json& scene, int exit_code, const std::string& culprit) const {
    ExpectRefused("simulate --scene " + WriteScene(scene) + " --output out.bin", exit_code, culprit);
  }
};

TEST_F(SimulateTest, SameSeedSameBytes) {
  const std::string flags = "--noise 0.001 --drop 0.1 --markers 6 --seed ";
  const std::string first = Record(SphereJson(), flags + "7");
  EXPECT_EQ(Record(SphereJson(), flags + "7"), first);
  EXPECT_NE(Record(SphereJson(), flags + "8"), first);
}

TEST_F(SimulateTest, TheTruthMovesTheClothAndIsWrittenNowhere) {
  const std::string nominal = Record(SphereJson(), "");
  const MotionTensors before = ReadMotionTensors((folder() / "out.bin").string());
  const std::string bytes = Record(SphereJson(), "--set mu=0.234567,k_stretch=456.789");
  const MotionTensors after = ReadMotionTensors((folder() / "out.bin").string());
  EXPECT_GT((after.positions - before.positions).norm(), 1e-6);
  EXPECT_EQ(after.scene_text, before.scene_text);
  EXPECT_EQ(after.provenance, before.provenance);
  EXPECT_EQ(bytes.find("0.234567"), std::string::npos);
  EXPECT_EQ(bytes.find("456.789"), std::string::npos);
}

// A term that only the truth has takes part in the rollout all the same.
TEST_F(SimulateTest, TheTruthMayBendWhereTheSceneDoesNot) {
  Record(BareScene(), "");
  const MotionTensors limp = ReadMotionTensors((folder() / "out.bin").string());
  Record(BareScene(), "--set k_bend=0.01,drag=0.5");
  const MotionTensors stiff = ReadMotionTensors((folder() / "out.bin").string());
  EXPECT_GT((stiff.positions - limp.positions).norm(), 1e-4);
}

TEST_F(SimulateTest, PrintsASummary) {
  const ToolResult result = Run("simulate --scene " + WriteScene(SphereJson()) + " --output out.bin");
  EXPECT_EQ(result.exit_code, 0) << result.err;
  for (const char* part : {"out.bin: 6 frames of 16 points", "5 steps of 0.01 s", "Newton iterations", "fallbacks",
                           "substeps", "stick", "slip", "joined", "left", "branch switches", "obstacle switches"}) {
    EXPECT_NE(result.out.find(part), std::string::npos) << part << "\n" << result.out;
  }
}

// The 33 ms step of SDIRK2 makes energy of a cloth that stiff.
TEST_F(SimulateTest, WarnsOfEnergyFromNowhere) {
  Json json = Json::parse(ReadBytes(std::string(CLOTHID_SOURCE_DIR) + "/datasets/wind.scene.json"));
  json["mesh"]["grid"]["nodes"] = {8, 8};
  json["handles"] = {0, 7};
  json["time_step"] = 1.0 / 30.0;
  json["duration"] = 0.3;
  const std::string command = "simulate --scene " + WriteScene(json) + " --output out.bin --set k_stretch=";
  const ToolResult stiff = Run(command + "1e8");
  EXPECT_EQ(stiff.exit_code, 0) << stiff.err;
  EXPECT_NE(stiff.err.find("warning: the motion gains energy that no work pays for"), std::string::npos) << stiff.err;
  EXPECT_EQ(Run(command + "300").err.find("warning"), std::string::npos);
}

TEST_F(SimulateTest, RefusesWrongFlags) {
  const std::string scene = WriteScene(SphereJson());
  const std::string command = "simulate --scene " + scene + " --output out.bin ";
  ExpectRefused("simulate --output out.bin", 1, "--scene");
  ExpectRefused("simulate --scene " + scene, 1, "--output");
  ExpectRefused(command + "--bogus=1", 1, "bogus");
  ExpectRefused(command + "extra", 1, "'extra'");
  ExpectRefused(command + "--noise=abc", 1, "noise");
  ExpectRefused(command + "--noise=-1", 1, "noise");
  ExpectRefused(command + "--noise=nan", 1, "noise");
  ExpectRefused(command + "--drop=1", 1, "drop");
  ExpectRefused(command + "--markers=17", 1, "markers");
  ExpectRefused(command + "--markers=-1", 1, "markers");
  ExpectRefused(command + "--frame_rate=-5", 1, "frame_rate");
  ExpectRefused(command + "--frame_rate=1", 1, "frame_rate");
  ExpectRefused(command + "--seed=-1", 1, "seed");
  ExpectRefused(command + "--threads=0", 1, "threads");
  ExpectRefused(command + "--force_rate 5", 1, "--force_rate: expected with --forces");
  ExpectRefused(command + "--noforces --force_rate 5", 1, "--force_rate: expected with --forces");
  ExpectRefused(command + "--forces_output f.csv", 1, "--forces_output: expected with --sensor");
  ExpectRefused(command + "--sensor s.json --noise 0", 1, "--noise: expected without --sensor");
  ExpectRefused(command + "--sensor s.json --threads 2", 1, "--threads: expected without --sensor");
}

TEST_F(SimulateTest, RefusesToReplaceItsInputs) {
  Json json = SphereJson();
  json["mesh"]["grid"]["nodes"] = {4, 4};
  json["handles"] = {{"nodes", {0}}, {"path", "path.csv"}};
  WriteBytes(folder() / "path.csv", "time,x0,y0,z0\n0,0,0,0\n");
  WriteBytes(folder() / "sensor.json", R"({"clothid_sensor": 1, "interval": [0.01, 0.01]})");
  const std::string scene = WriteScene(json, "scene.bin");
  ExpectRefused("simulate --scene scene.bin --output scene.bin", 1, "scene.bin: would replace an input");
  ExpectRefused("simulate --scene scene.bin --output ../$(basename $PWD)/scene.bin", 1, "the input scene.bin");
  const std::string sensor = "simulate --scene scene.bin --sensor sensor.json --output ";
  ExpectRefused(sensor + "path.csv --handles_output new.csv", 1, "path.csv: would replace an input");
  ExpectRefused(sensor + "new.csv --handles_output path.csv", 1, "path.csv: would replace an input");
  ExpectRefused(sensor + "new.csv --handles_output sensor.json", 1, "sensor.json: would replace an input");
  ExpectRefused(sensor + "new.csv --handles_output ./new.csv", 1, "--handles_output: ./new.csv: expected another file");
  ExpectRefused(sensor + "new.npy --handles_output new.times.npy", 1, "expected another file than --output");
}

TEST_F(SimulateTest, ReadsAPipeOnce) {
  const std::string bytes = Record(SphereJson(), "");
  ExpectSuccess("bash -c 'simulate --scene <(cat scene.json) --output piped.bin'");
  EXPECT_EQ(ReadBytes(folder() / "piped.bin"), bytes);
}

TEST_F(SimulateTest, RefusesNamesOfOtherFormats) {
  const std::string command = "simulate --scene " + WriteScene(SphereJson()) + " --output ";
  for (const char* name : {"out.csv", "out.npy", "out"}) {
    ExpectRefused(command + name, 1, std::string(name) + ": expected a name that ends in .bin");
  }
  ExpectSuccess(command + "/dev/null");
  WriteBytes(folder() / "sensor.json", R"({"clothid_sensor": 1})");
  ExpectRefused(command + "out.bin --sensor sensor.json", 1, "out.bin: unknown format");
}

TEST_F(SimulateTest, AFormatThatCannotHoldTheMotionLeavesNothing) {
  Json scene = SphereJson();
  scene["handles"] = {{"nodes", {0}}, {"path", "path.csv"}};
  WriteBytes(folder() / "path.csv", "time,x0,y0,z0\n0,0,0,0\n");
  WriteBytes(folder() / "sensor.json", R"({"clothid_sensor": 1, "interval": [0.01, 0.01], "drop_fraction": 0.5})");
  ExpectRefused(
      "simulate --scene " + WriteScene(scene) + " --sensor sensor.json --output a_#.obj --handles_output h.csv", 1,
      "OBJ has no word for that");
  ExpectRefused("simulate --scene scene.json --sensor sensor.json --output a.npy --handles_output absent/h.csv", 1,
                "absent/h.csv: cannot be written");
}

// Neither after a long simulation nor by a lack of memory.
TEST_F(SimulateTest, RefusesRecordingsThatAreTooLarge) {
  Json scene = SphereJson();
  scene["mesh"]["grid"]["nodes"] = {60, 60};
  scene["handles"] = {0};
  const std::string command = "simulate --scene " + WriteScene(scene) + " --output out.bin ";
  ExpectRefused(command + "--frame_rate 1e7", 1,
                "500001 frames of 3600 points take 41199 MB; expected at most 4096 MB");
  ExpectRefused(command + "--frame_rate 1e6 --cloud 1000000", 1, "frames of 1e+06 points take");
}

TEST_F(SimulateTest, RefusesRolloutsThatNoMachineHolds) {
  Json scene = BareScene();
  scene["mesh"]["grid"]["nodes"] = {300, 300};
  scene["handles"] = {0};
  scene["time_step"] = 1e-4;
  scene["duration"] = 1000.0;
  ExpectRefused("simulate --scene " + WriteScene(scene) + " --output out.bin --frame_rate 0.01", 1,
                "scene.json: 1e+07 steps of 90000 nodes take at least 4");
}

TEST_F(SimulateTest, RefusesWrongParameters) {
  const std::string command = "simulate --scene " + WriteScene(SphereJson()) + " --output out.bin --set ";
  ExpectRefused(command + "mu=nan", 1, "mu=nan");
  ExpectRefused(command + "mu=inf", 1, "mu=inf");
  ExpectRefused(command + "mu=-0.1", 1, "mu");
  ExpectRefused(command + "k_stretch=-1", 1, "k_stretch");
  ExpectRefused(command + "k_stretch=0", 1, "k_stretch");
  ExpectRefused(command + "density=-0.2", 1, "density");
  ExpectRefused(command + "k_bend=-1e-4", 1, "k_bend");
  ExpectRefused(command + "drag=-1", 1, "drag");
  ExpectRefused(command + "mu", 1, "'mu'");
  ExpectRefused(command + "mu=0.3x", 1, "mu=0.3x");
  ExpectRefused(command + "mu=0.3,mu=0.4", 1, "mu");
  ExpectRefused(command + "weight=1", 1, "weight");
  ExpectRefused(command + "mu.ghost=0.1", 1, "mu.ghost");
  ExpectRefused("simulate --scene " + WriteScene(BareScene(), "bare.json") + " --output out.bin --set mu=0.1", 1,
                "'mu'");
}

TEST_F(SimulateTest, RefusesUnusableScenes) {
  Json scene = SphereJson();
  scene["time_stepp"] = 0.01;
  ExpectSceneRefused(scene, 2, "time_stepp");
  scene = SphereJson();
  scene["obstacles"][0]["friction"] = 0.3;
  ExpectSceneRefused(scene, 2, "obstacles[0].friction");
  scene = SphereJson();
  scene["obstacles"][0]["mu"] = -0.3;
  ExpectSceneRefused(scene, 2, "obstacles[0].mu");
  scene = SphereJson();
  scene["obstacles"][0]["type"] = "knot";
  ExpectSceneRefused(scene, 2, "knot");
  scene = SphereJson();
  scene["materials"]["k_stretch"] = -1.0;
  ExpectSceneRefused(scene, 2, "materials.k_stretch");
  scene = SphereJson();
  scene["materials"]["density"] = "light";
  ExpectSceneRefused(scene, 2, "materials.density");
  scene = SphereJson();
  scene["handles"] = {0, 16};
  ExpectSceneRefused(scene, 2, "handles");
  scene = SphereJson();
  scene["time_step"] = 0.0;
  ExpectSceneRefused(scene, 2, "time_step");
  scene = SphereJson();
  scene.erase("mesh");
  ExpectSceneRefused(scene, 2, "mesh");
}

TEST_F(SimulateTest, NamesTheLineOfAnUnknownKey) {
  WriteBytes(folder() / "scene.json", "{\n\"clothid_scene\": 1,\n\"gravitee\": [0, 0, 0]\n}\n");
  ExpectRefused("simulate --scene scene.json --output out.bin", 2, "scene.json:3");
}

TEST_F(SimulateTest, RefusesBrokenText) {
  const std::string text = SphereJson().dump(2);
  WriteBytes(folder() / "scene.json", text.substr(0, text.size() / 2));
  ExpectRefused("simulate --scene scene.json --output out.bin", 2, "scene.json");
  WriteBytes(folder() / "scene.json", "");
  ExpectRefused("simulate --scene scene.json --output out.bin", 2, "scene.json");
  WriteBytes(folder() / "scene.json", "{\"clothid_scene\": 1, \"time_step\": NaN}");
  ExpectRefused("simulate --scene scene.json --output out.bin", 2, "scene.json");
}

TEST_F(SimulateTest, RefusesFilesThatCannotBeOpenedOrWritten) {
  const std::string scene = WriteScene(SphereJson());
  ExpectRefused("simulate --scene absent.json --output out.bin", 1, "absent.json");
  ExpectRefused("simulate --scene " + scene + " --output absent/out.bin", 1, "absent/out.bin");
  ExpectRefused("simulate --scene " + scene + " --output " + scene + "/out.bin", 1, scene + "/out.bin");
  ExpectRefused("simulate --scene " + scene + " --output /proc/out.bin", 1, "/proc/out.bin");
  Json no_mesh = SphereJson();
  no_mesh["mesh"] = {{"obj", "absent.obj"}};
  ExpectSceneRefused(no_mesh, 1, "absent.obj");
}

// A start so fast that its squares overflow: no step can end.
TEST_F(SimulateTest, AStepThatDoesNotConvergeWritesNothing) {
  Json scene = SphereJson();
  scene["initial"] = {{"velocity", {0.0, 0.0, -1e160}}};
  ExpectSceneRefused(scene, 3, "step 1 did not converge");
}

class ObjTest : public SimulateTest {
 protected:
  // A scene whose cloth is `obj`, free of handles.
  Json ObjScene(const std::string& obj) const {
    WriteBytes(folder() / "cloth.obj", obj);
    Json scene = BareScene();
    scene["mesh"] = {{"obj", "cloth.obj"}};
    scene.erase("handles");
    return scene;
  }
};

constexpr char kTwoTriangles[] = "v 0 0 0\nv 1 0 0\nv 0 1 0\nv 1 1 0\nf 1 2 3\nf 2 4 3\n";

TEST_F(ObjTest, ARecordingDoesNotNeedTheFilesOfItsScene) {
  Record(ObjScene(kTwoTriangles), "");
  std::filesystem::remove(folder() / "cloth.obj");
  ExpectSuccess("motion check out.bin");
}

TEST_F(ObjTest, RefusesUnusableMeshes) {
  ExpectSceneRefused(ObjScene("v 0 0 0\nv 1 0 0\nv 0 1 0\nv 1 1 0\nf 1 2 3\nf 2 3 4\n"), 2, "cloth.obj");
  ExpectSceneRefused(ObjScene("v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 4\n"), 2, "cloth.obj");
  ExpectSceneRefused(ObjScene("v 0 0 0\nv 1 0 0\nv 2 0 0\nf 1 2 3\n"), 2, "cloth.obj");
  ExpectSceneRefused(ObjScene("v 0 0 nan\nv 1 0 0\nv 0 1 0\nf 1 2 3\n"), 2, "cloth.obj");
  ExpectSceneRefused(ObjScene(""), 2, "cloth.obj");
}

}  // namespace
}  // namespace clothid::simulate_test

// `motion convert` and the findings of `motion check` as a user meets them.
#include <gtest/gtest.h>

#include <filesystem>
#include <nlohmann/json.hpp>
#include <string>

#include "datasets/motion/motion_file.h"
#include "tests/tools/tool_test.h"

namespace clothid::convert_test {
namespace {

// Three frames of 2 x 2 points in mm, 0.1 s apart, that rise by 10 mm each; the second point is missing once.
constexpr char kGrid[] =
    "%time,field.header.stamp,field.size,field.x0,field.x1,field.x2,field.x3,field.y0,field.y1,field.y2,field.y3,"
    "field.z0,field.z1,field.z2,field.z3\n"
    "5,1600000000000000000,2,0,100,0,100,0,0,200,200,0,0,0,0\n"
    "6,1600000000100000000,2,0,nan,0,100,0,0,200,200,10,10,10,10\n"
    "7,1600000000200000000,2,0,100,0,100,0,0,200,200,20,20,20,20\n";

constexpr char kScene[] = R"({"clothid_scene": 1, "handles": [0]})";

class ConvertTest : public ToolTest {
 protected:
  ConvertTest() {
    WriteBytes(folder() / "grid.csv", kGrid);
    WriteBytes(folder() / "scene.json", kScene);
  }

  MotionTensors Read(const std::string& name) const { return ReadMotionTensors((folder() / name).string()); }
};

constexpr char kConvert[] =
    "motion convert grid.csv cloth.bin --scene scene.json --grid 2x2:0.1x0.2 --scale 0.001 --start_at 0 "
    "--handle_nodes 0";

TEST_F(ConvertTest, MakesARecording) {
  ExpectSuccess(kConvert);
  const MotionTensors motion = Read("cloth.bin");
  EXPECT_NEAR(motion.times[2], 0.2, 1e-6);
  EXPECT_NEAR(motion.positions(11, 2), 0.02, 1e-15);
  EXPECT_EQ(motion.positions.array().isNaN().count(), 3);
  EXPECT_EQ(motion.handle_index, std::vector<int>{0});
  EXPECT_EQ(
      motion.provenance,
      "converted from grid.csv --grid 2x2:0.1x0.2 --scale 0.001 --start_at 0 --scene scene.json --handle_nodes 0");
  EXPECT_NE(Run("motion check cloth.bin").out.find("missing points        warning  1 ("), std::string::npos);
}

TEST_F(ConvertTest, ConvertsRecordings) {
  ExpectSuccess(kConvert);
  WriteBytes(folder() / "up.json", R"({"translation": [0, 0, 1]})");
  ExpectSuccess("motion convert cloth.bin higher.bin --transform up.json --frames 1:3 --sigma 0.002");
  const MotionTensors motion = Read("higher.bin");
  EXPECT_EQ(motion.times.size(), 2);
  EXPECT_NEAR(motion.positions(2, 0), 1.01, 1e-15);
  EXPECT_NEAR(motion.handle_positions(2, 0), 1.01, 1e-15);
  EXPECT_EQ(motion.sigma[3], 0.002);
  ExpectSuccess("motion convert higher.bin back.bin --transform up.json --invert_transform");
  EXPECT_NEAR(Read("back.bin").positions(2, 0), 0.01, 1e-15);
}

// The numbers are those of the file, of a TRC in mm as well.
TEST_F(ConvertTest, MakesGapsOfNumbersThatStandForThem) {
  ExpectSuccess(std::string(kConvert) + " --missing 0,200,10");
  EXPECT_EQ(Read("cloth.bin").positions.array().isNaN().count(), 6);
  ExpectSuccess("motion convert cloth.bin gap.bin --missing 0.1,0.2,0.02");
  EXPECT_EQ(Read("gap.bin").positions.array().isNaN().count(), 9);
  WriteBytes(folder() / "t.trc",
             "PathFileType\t4\t(X/Y/Z)\tt.trc\n"
             "DataRate\tCameraRate\tNumFrames\tNumMarkers\tUnits\tOrigDataRate\tOrigDataStartFrame\tOrigNumFrames\n"
             "10\t10\t2\t1\tmm\t10\t1\t2\nFrame#\tTime\ta\n\t\tX1\tY1\tZ1\n\n"
             "1\t0\t-9999.7\t-9999.7\t-9999.7\n2\t0.1\t1\t2\t3\n");
  ExpectSuccess("motion convert t.trc t.csv --missing -9999.7");
  EXPECT_EQ(ReadBytes(folder() / "t.csv"), "t,id,x,y,z\n0,a,,,\n0.1,a,0.001,0.002,0.003\n");
  ExpectRefused(std::string(kConvert) + " --missing 0,0", 1, "--missing: expected a position as in 0,0,0");
}

TEST_F(ConvertTest, TheSameInputsGiveTheSameBytes) {
  ExpectSuccess(kConvert);
  const std::string bytes = ReadBytes(folder() / "cloth.bin");
  ExpectSuccess(kConvert);
  EXPECT_EQ(ReadBytes(folder() / "cloth.bin"), bytes);
}

TEST_F(ConvertTest, SaysWhatItWrote) {
  ExpectSuccess(kConvert);
  EXPECT_EQ(Run("motion convert cloth.bin a.npy").out, "a.npy: 3 frames, 4 points, 2 faces\n");
  EXPECT_EQ(Run("motion convert cloth.bin a.csv").out, "a.csv: 3 frames, 4 points\n");
  EXPECT_EQ(Run("motion convert cloth.bin a.vtp").out, "a.pvd: 3 frames, 4 points, 2 faces\n");
  const ToolResult late = Run("motion convert cloth.bin late.bin --start_at 1.7e9");
  EXPECT_NE(late.out.find("from 1700000000 s to 1700000000.2 s"), std::string::npos) << late.out;
  EXPECT_NE(Run("motion check late.bin").out.find("from 1700000000 s to 1700000000.2 s"), std::string::npos);
}

TEST_F(ConvertTest, SaysWhatATableIsInstead) {
  WriteBytes(folder() / "packed.csv", "\x1f\x8b\x08\x08 bytes");
  ExpectRefused("motion convert packed.csv out.npy", 1,
                "packed.csv: is packed with gzip; expected a header with t, id");
  ExpectRefused("motion convert grid.csv out.npy --scale nan", 1, "nan");
  ExpectRefused("motion convert '' out.npy", 1, "convert: expected a file to read and one to write");
}

// A fault of a table has one exit code, whatever the table is of, and names the line of its origin.
TEST_F(ConvertTest, ErrorsNameTheTableTheyAreOf) {
  WriteBytes(folder() / "head.csv", "when,x0\n0,0\n");
  WriteBytes(folder() / "twice.txt", "0\n0.1\n0.1\n");
  WriteBytes(folder() / "short.txt", "0\n0.1\n");
  WriteBytes(folder() / "stamps.txt", "0\n100000000\n200000000\n");
  WriteBytes(folder() / "forces.csv", "time,z\n0,1\n0,1\n0.1,1\n");
  const std::string command = kConvert;
  for (const char* flag : {"--handles", "--map", "--times", "--force_sigma 1 --forces", "--obstacle ball="}) {
    const std::string separator = std::string(flag).back() == '=' ? "" : " ";
    WriteBytes(folder() / "scene.json", R"({"clothid_scene": 2, "handles": [0], "obstacles": [
        {"name": "ball", "type": "sphere", "center": [0, 0, -1], "radius": 0.1}]})");
    ExpectRefused(command + " " + flag + separator + "head.csv", 2, "head.csv:1: ");
  }
  ExpectRefused("motion convert head.csv out.npy", 2, "head.csv:1: ");
  ExpectRefused(command + " --times twice.txt", 2, "twice.txt:3: ");
  ExpectRefused(command + " --times short.txt", 2, "short.txt: expected 3 times, one per frame of grid.csv, found 2");
  ExpectRefused(command + " --times stamps.txt", 2, "stamps.txt: times look like nanoseconds");
  ExpectSuccess(command + " --times stamps.txt --time_scale 1e-9");
  ExpectRefused(command + " --forces forces.csv --force_sigma 1", 2, "forces.csv:3: ");
}

TEST_F(ConvertTest, TellsWhatItMadeOfTablesAndRates) {
  WriteBytes(folder() / "times.txt", "frame;time\n0;0,0\n1;0,1\n2;0,2\n");
  const ToolResult told = Run(std::string(kConvert) + " --times times.txt");
  EXPECT_EQ(told.exit_code, 0);
  EXPECT_EQ(told.err,
            "motion: times.txt: note: cells stand between ';', commas in numbers are taken for decimal marks\n");
  EXPECT_EQ(Run(kConvert).err, "");
  ExpectSuccess("motion convert grid.csv points.pc2");
  std::string cache = ReadBytes(folder() / "points.pc2");
  EXPECT_EQ(Run("motion convert points.pc2 out.csv --frame_rate 25").err, "");
  cache.replace(24, 4, std::string("\x00\x00\xf0\x41", 4));  // 30
  WriteBytes(folder() / "points.pc2", cache);
  EXPECT_NE(Run("motion convert points.pc2 out.csv --frame_rate 25")
                .err.find("points.pc2: note: its header has a sample rate of 30"),
            std::string::npos);
  EXPECT_EQ(Run("motion convert points.pc2 out.csv --frame_rate 30").err, "");
}

TEST_F(ConvertTest, RefusesToReplaceItsInputs) {
  ExpectSuccess(kConvert);
  std::filesystem::create_symlink("cloth.bin", folder() / "link.bin");
  std::filesystem::create_hard_link(folder() / "cloth.bin", folder() / "hard.bin");
  for (const char* output : {"cloth.bin", "./cloth.bin", "link.bin", "hard.bin"}) {
    ExpectRefused(std::string("motion convert cloth.bin ") + output, 1, std::string(output) + ": would replace ");
  }
  ExpectSuccess("motion convert grid.csv b_#.ply");
  ExpectRefused("motion convert 'b_#.ply' 'b_##.ply' --frame_rate 10", 1, "b_0.ply: would replace an input");
  ExpectRefused("motion convert b_1.ply 'b_#.ply' --frame_rate 10", 1, "b_1.ply: would replace an input");
  WriteBytes(folder() / "b.times.npy", "times");
  ExpectRefused("motion convert grid.csv b.npy --times b.times.npy", 1, "b.times.npy: would replace an input");
  ExpectRefused("motion convert cloth.bin grid.csv --faces grid.csv", 1, "grid.csv: would replace an input");
  WriteBytes(folder() / "scene.json", R"({"clothid_scene": 1, "handles": {"nodes": [0], "path": "path.bin"}})");
  WriteBytes(folder() / "path.bin", "a path");
  ExpectRefused("motion convert grid.csv path.bin --scene scene.json", 1, "path.bin: would replace an input");
}

TEST_F(ConvertTest, RefusesWrongFlags) {
  ExpectRefused("motion convert", 1, "convert: expected a file to read and one to write");
  ExpectRefused("motion convert grid.csv", 1, "convert");
  ExpectRefused("motion convert absent.csv cloth.bin --scene scene.json", 1, "absent.csv");
  ExpectRefused("motion convert grid.csv cloth.bin", 1, "scene");
  ExpectRefused("motion convert grid.csv cloth.bin --scene absent.json", 1, "absent.json");
  ExpectRefused("motion convert grid.csv cloth.bin --scene scene.json", 1, "'mesh'");
  ExpectRefused("motion convert grid.csv absent/cloth.bin --scene scene.json", 1, "absent/cloth.bin");
  const std::string command = kConvert;
  ExpectRefused(command + " --grid 2x2", 1, "--grid");
  ExpectRefused(command + " --grid 1x2:1x1", 1, "--grid");
  ExpectRefused(command + " --grid 4000000x4000000:1x1", 1, "--grid");
  ExpectRefused(command + " --faces cloth.obj", 1, "--grid: expected without --faces");
  ExpectRefused(command + " --scale 0", 1, "scale");
  ExpectRefused(command + " --scale nan", 1, "scale");
  ExpectRefused(command + " --frames 2:1", 1, "--frames");
  ExpectRefused(command + " --frames 0:1:2", 1, "--frames");
  ExpectRefused(command + " --frames 3:4", 1, "3 frames");
  ExpectRefused(command + " --start_at soon", 1, "--start_at");
  ExpectRefused(command + " --invert_transform", 1, "--invert_transform");
  ExpectRefused(command + " --handle_nodes 0,x", 1, "--handle_nodes");
  ExpectRefused(command + " --handle_time_offset 1", 1, "--handle_time_offset");
  ExpectRefused(command + " --map absent.csv", 1, "absent.csv");
  for (const char* map : {"", " --map nodes", " --map map.csv"}) {
    ExpectRefused(command + " --map_distance 0.1" + map, 1, "--map_distance: expected with --map nearest or markers");
  }
  ExpectRefused("motion convert grid.csv cloth.bin --scene scene.json --transpose", 1, "--transpose");
  ExpectRefused("motion convert grid.csv points.csv --sigma 1", 1, "--sigma");
  ExpectRefused("motion info grid.csv --sigma 1", 1, "--sigma: is a flag of convert");
  ExpectRefused("motion check grid.csv --grid 2x2:1x1", 1, "--grid: is a flag of convert");
}

TEST_F(ConvertTest, BringsThePathOfAnObstacle) {
  WriteBytes(folder() / "scene.json",
             R"({"clothid_scene": 2, "obstacles": [{"type": "sphere", "center": [0, 0, -1], "radius": 0.1}]})");
  WriteBytes(folder() / "ball.csv", "time,x,y,z,qx,qy,qz,qw\n0,0,0,0,0,0,0,1\n0.2,0.1,0,0,0,0,0,1\n");
  const std::string command = kConvert;
  ExpectRefused(command + " --obstacle ball.csv", 1, "--obstacle: expected NAME=FILE");
  ExpectRefused(command + " --obstacle bar=ball.csv", 1, "ball.csv: a path of the obstacle 'bar'");
  ExpectRefused(command + " --obstacle_time_offset 1", 1, "--obstacle_time_offset: expected with --obstacle");
  ExpectRefused("motion convert grid.csv ball.bin --scene scene.json --grid 2x2:0.1x0.2 --obstacle sphere=ball.bin", 1,
                "ball.bin: would replace an input");
  ExpectRefused(command + " --obstacle sphere=ball.csv", 2, "another time offset");
  ExpectSuccess(command + " --obstacle_time_offset -1600000000 --obstacle sphere=" + (folder() / "ball.csv").string());
  const MotionTensors motion = Read("cloth.bin");
  EXPECT_EQ(nlohmann::json::parse(motion.scene_text)["obstacles"][0]["path"].size(), 2U);
  EXPECT_NE(motion.provenance.find(" --obstacle sphere=ball.csv"), std::string::npos) << motion.provenance;
}

TEST_F(ConvertTest, RefusesBadFiles) {
  const std::string command = kConvert;
  WriteBytes(folder() / "bad.json", "{\n\"matrix\": 3}");
  ExpectRefused(command + " --transform bad.json", 2, "bad.json:2");
  WriteBytes(folder() / "scene.json", "{\"clothid_scene\": 1, \"gravitation\": 0}");
  ExpectRefused(command, 2, "gravitation");
  WriteBytes(folder() / "scene.json", kScene);
  WriteBytes(folder() / "grid.csv", std::string(kGrid) + "8,1600000000300000000,2,0\n");
  ExpectRefused(command, 2, "grid.csv:5");
  WriteBytes(folder() / "fake.bin", "no motion");
  ExpectRefused("motion convert fake.bin cloth.bin", 2, "fake.bin");
}

TEST_F(ConvertTest, AWrongUnitIsAProblem) {
  ExpectSuccess("motion convert grid.csv cloth.bin --scene scene.json --grid 2x2:0.1x0.2 --handle_nodes 0");
  const ToolResult check = Run("motion check cloth.bin");
  EXPECT_EQ(check.exit_code, 2);
  EXPECT_EQ(check.err, "motion: cloth.bin: cannot be fitted as it is: edge lengths\n");
  EXPECT_NE(check.out.find("--scale 0.001"), std::string::npos) << check.out;
  const nlohmann::json report = nlohmann::json::parse(Run("motion check cloth.bin --json").out);
  EXPECT_EQ(report["verdict"], "problem");
}

TEST_F(ConvertTest, ShippedRecordingsHaveNothingWrong) {
  for (const std::string name : {"bounce", "drape", "slope", "wind"}) {
    const ToolResult check = Run("motion check --json '" CLOTHID_SOURCE_DIR "/datasets/" + name + ".motion.bin'");
    EXPECT_EQ(check.exit_code, 0) << check.err;
    EXPECT_EQ(nlohmann::json::parse(check.out)["verdict"], "ok") << name << "\n" << check.out;
  }
}

}  // namespace
}  // namespace clothid::convert_test

// Runs the built programs as a user would: a command line in, exit code, stdout and stderr out.
#ifndef CLOTHID_TESTS_TOOLS_TOOL_TEST_H_
#define CLOTHID_TESTS_TOOLS_TOOL_TEST_H_

#include <gtest/gtest.h>
#include <stdlib.h>
#include <sys/wait.h>

#include <algorithm>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <nlohmann/json.hpp>
#include <set>
#include <string>

namespace clothid {

struct ToolResult {
  int exit_code = -1;
  std::string out, err;
};

inline std::string ReadBytes(const std::filesystem::path& path) {
  std::ifstream file(path, std::ios::binary);
  EXPECT_TRUE(file) << path;
  return {std::istreambuf_iterator<char>(file), std::istreambuf_iterator<char>()};
}

inline void WriteBytes(const std::filesystem::path& path, const std::string& bytes) {
  std::ofstream(path, std::ios::binary) << bytes;
}

// A test with a folder of its own, which is the current folder of the tools that it runs.
class ToolTest : public testing::Test {
 protected:
  ToolTest() {
    std::string name = testing::TempDir() + "clothid_tool_XXXXXX";
    EXPECT_NE(mkdtemp(name.data()), nullptr);
    folder_ = name;
  }
  ~ToolTest() override { std::filesystem::remove_all(folder_); }

  const std::filesystem::path& folder() const { return folder_; }

  // `command` starts with the name of one of our programs, or of any other on the path.
  ToolResult Run(const std::string& command) const {
    // Outside of the folder, so that a test sees what the tool itself leaves behind.
    const std::string out = folder_.string() + ".out", err = folder_.string() + ".err";
    const std::string line = "cd '" + folder_.string() + "' && PATH='" CLOTHID_BINARY_DIR "':\"$PATH\" " + command +
                             " >'" + out + "' 2>'" + err + "'";
    const int status = std::system(line.c_str());
    ToolResult result = {WIFEXITED(status) ? WEXITSTATUS(status) : -1, ReadBytes(out), ReadBytes(err)};
    std::filesystem::remove(out);
    std::filesystem::remove(err);
    return result;
  }

  std::set<std::string> Files() const {
    std::set<std::string> files;
    for (const auto& entry : std::filesystem::recursive_directory_iterator(folder_))
      files.insert(entry.path().string());
    return files;
  }

  // `command` must end with `exit_code` and exactly one line on stderr, which names `culprit`, and leave nothing
  // behind.
  void ExpectRefused(const std::string& command, int exit_code, const std::string& culprit) const {
    const std::set<std::string> before = Files();
    const ToolResult result = Run(command);
    EXPECT_EQ(result.exit_code, exit_code) << command << "\n" << result.err;
    EXPECT_EQ(std::count(result.err.begin(), result.err.end(), '\n'), 1) << command << "\n" << result.err;
    EXPECT_NE(result.err.find(culprit), std::string::npos) << command << "\nexpected: " << culprit << "\n"
                                                           << result.err;
    EXPECT_EQ(Files(), before) << command;
  }

  void ExpectSuccess(const std::string& command) const {
    const ToolResult result = Run(command);
    EXPECT_EQ(result.exit_code, 0) << command << "\n" << result.err;
    EXPECT_EQ(result.err, "") << command;
  }

  // Writes a scene and returns its name.
  std::string WriteScene(const nlohmann::ordered_json& scene, const std::string& name = "scene.json") const {
    WriteBytes(folder_ / name, scene.dump(2));
    return name;
  }

 private:
  std::filesystem::path folder_;
};

// A square of cloth, 4 x 4 nodes, hung by an edge, 5 steps; no contact, bending, drag or wind.
inline nlohmann::ordered_json BareScene() {
  return nlohmann::ordered_json::parse(R"({
    "clothid_scene": 1,
    "time_step": 0.01,
    "duration": 0.05,
    "mesh": {"grid": {"nodes": [4, 4], "size": [0.2, 0.2]}},
    "handles": [0, 1, 2, 3],
    "materials": {"density": 0.15, "k_stretch": 100, "k_bend": 0, "drag": 0}
  })");
}

// The same over a sphere that it falls on at once.
inline nlohmann::ordered_json SphereJson() {
  nlohmann::ordered_json scene = BareScene();
  scene["obstacles"] = nlohmann::ordered_json::parse(
      R"([{"name": "ball", "type": "sphere", "center": [0.1, 0.2, -0.1005], "radius": 0.1, "mu": 0.3}])");
  return scene;
}

}  // namespace clothid

#endif  // CLOTHID_TESTS_TOOLS_TOOL_TEST_H_

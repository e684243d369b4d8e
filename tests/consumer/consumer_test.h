// A test that uses the installed clothid from outside.
#ifndef CLOTHID_TESTS_CONSUMER_CONSUMER_TEST_H_
#define CLOTHID_TESTS_CONSUMER_CONSUMER_TEST_H_

#include <gtest/gtest.h>

#include <filesystem>
#include <map>
#include <sstream>
#include <string>
#include <vector>

#include "tests/tools/tool_test.h"

namespace clothid {

namespace fs = std::filesystem;

inline constexpr char kPrefix[] = CLOTHID_PREFIX;
inline constexpr char kExamples[] = CLOTHID_SOURCE_DIR "/tests/consumer/";

// An estimate as the examples print it: NAME VALUE +- STD, and what follows in the line.
struct Estimate {
  double value = 0.0, std = 0.0;
  std::string rest;
};

inline std::map<std::string, Estimate> ParseEstimates(const std::string& text) {
  std::istringstream lines(text);
  std::map<std::string, Estimate> estimates;
  for (std::string line; std::getline(lines, line);) {
    std::istringstream words(line);
    std::string name, value, sign, std;
    words >> name >> value >> sign >> std;
    if (sign != "+-") continue;
    Estimate& estimate = estimates[name];
    estimate = {std::stod(value), std::stod(std), ""};
    std::getline(words, estimate.rest);
  }
  return estimates;
}

class ConsumerTest : public ToolTest {
 protected:
  void SetUp() override { ASSERT_TRUE(fs::exists(kPrefix)) << "made by the test consumer/install"; }

  std::string Success(const std::string& command) const {
    const ToolResult result = Run(command);
    EXPECT_EQ(result.exit_code, 0) << command << "\n" << result.out << result.err;
    return result.out;
  }

  // Builds the example `name` against the installed clothid; the program is `name`/`name`.
  void BuildExample(const std::string& name) const {
    Success(CONFIGURE " -S " + (kExamples + name) + " -B " + name + " -DCMAKE_PREFIX_PATH='" + kPrefix + "'");
    Success(BUILD " " + name);
  }

  // Where the dynamic linker finds our libraries for `program`.
  std::vector<std::string> LoadedLibraries(const std::string& program) const {
    std::istringstream lines(Success("ldd " + program));
    std::vector<std::string> paths;
    for (std::string line; std::getline(lines, line);) {
      const std::size_t arrow = line.find("=> ");
      if (line.find("libclothid_") != std::string::npos) paths.push_back(line.substr(arrow + 3));
    }
    return paths;
  }

  void ExpectLibrariesBelow(const std::string& program, const std::string& root, std::size_t count) const {
    const std::vector<std::string> paths = LoadedLibraries(program);
    EXPECT_EQ(paths.size(), count) << program;
    for (const std::string& path : paths) {
      EXPECT_EQ(fs::canonical(path.substr(0, path.find(' '))).string().rfind(root, 0), 0u) << path;
    }
  }
};

}  // namespace clothid

#endif  // CLOTHID_TESTS_CONSUMER_CONSUMER_TEST_H_

// The examples, built against the installed clothid.
#include <gtest/gtest.h>

#include <cmath>
#include <map>
#include <sstream>
#include <string>
#include <vector>

#include "tests/consumer/consumer_test.h"
#include "tests/page_blocks.h"

namespace clothid {
namespace {

using ExamplesTest = ConsumerTest;

std::map<std::string, double> ParseNumbers(const std::string& text) {
  std::istringstream words(text);
  std::map<std::string, double> numbers;
  std::string name;
  for (double number = 0.0; words >> name >> number;) numbers[name] = number;
  return numbers;
}

// The program of the README, as it stands there.
TEST_F(ExamplesTest, Readme) {
  Success("mkdir fit");
  for (const Block& block : ReadBlocks(ReadBytes(CLOTHID_SOURCE_DIR "/README.md"))) {
    if (block.language == "cpp" || block.language == "cmake")
      WriteBytes(folder() / "fit" / FileName(block), block.content);
  }
  Success(CONFIGURE " -S fit -B build -DCMAKE_PREFIX_PATH='" + std::string(kPrefix) + "'");
  Success(BUILD " build");
  const std::string out = Success("build/fit " CLOTHID_SOURCE_DIR "/datasets/capture.motion.bin");
  // As `identify` prints them in the README.
  EXPECT_EQ(FirstMissingLine("...\nmu 0.3457, 95 % interval 0.3281 .. 0.3632\n"
                             "k_stretch 25.38, 95 % interval 23.52 .. 27.38\n"
                             "time_offset 0.009182, 95 % interval 0.008071 .. 0.01029\n",
                             out),
            "")
      << out;
  EXPECT_EQ(out.rfind("converged: ", 0), 0u) << out;
  EXPECT_EQ(Run("build/fit").exit_code, 1);
  EXPECT_EQ(Run("build/fit absent.bin").exit_code, 2);
}

// Two drapes with k_stretch 70, mu 0.24 and 0.4, seen with 1 mm of noise, fitted together from the scene's values.
TEST_F(ExamplesTest, JointFit) {
  BuildExample("joint_fit");
  ExpectLibrariesBelow("joint_fit/joint_fit", kPrefix, 4);
  const std::string simulate = std::string(kPrefix) + "/bin/clothid simulate --scene " CLOTHID_SOURCE_DIR
                                                      "/datasets/drape.scene.json --noise 0.001 ";
  Success(simulate + "--seed 1 --set mu=0.24,k_stretch=70 --output first.bin");
  Success(simulate + "--seed 2 --set mu=0.4,k_stretch=70 --output second.bin");
  std::map<std::string, Estimate> estimates = ParseEstimates(Success("joint_fit/joint_fit first.bin second.bin"));
  const std::map<std::string, double> truth = {{"k_stretch", 70.0}, {"first.mu", 0.24}, {"second.mu", 0.4}};
  EXPECT_EQ(estimates.size(), truth.size());
  for (const auto& [name, true_value] : truth) {
    const Estimate& estimate = estimates[name];
    EXPECT_NEAR(estimate.value, true_value, 4.0 * estimate.std) << name;
    EXPECT_GT(estimate.std, 0.0) << name;
    EXPECT_LT(estimate.std, 0.02 * true_value) << name;
  }
  EXPECT_EQ(Run("joint_fit/joint_fit missing.bin missing.bin").exit_code, 2);
}

// What a recording hides, and that one measurement of the user's own reveals it.
TEST_F(ExamplesTest, Calibration) {
  struct Case {
    std::string recording, simulated, parameters, measurement, hidden;
    std::string measured;                 // the parameter that was measured,
    double sigma = 0.0;                   // and how well
    std::map<std::string, double> truth;  // of the parameters that the recording alone does not tell
  };
  const std::vector<Case> cases = {
      {"wind",
       "k_stretch=60,k_bend=4e-4",
       "k_stretch,k_bend,density,drag",
       "mass=0.0375:0.0001",
       "k_stretch, k_bend, density and drag multiplied by one factor",
       "density",
       0.0001 / (0.5 * 0.5),
       {{"k_stretch", 60.0}, {"k_bend", 0.0004}, {"density", 0.15}, {"drag", 0.3}}},
      {"wind", "k_stretch=60,k_bend=4e-4", "mu,k_stretch,k_bend", "mu=0.3:0.02", "mu", "mu", 0.02, {{"mu", 0.3}}},
      {"slope",
       "mu=0.2,k_stretch=30",
       "mu,k_stretch",
       "k_stretch=30:2",
       "k_stretch",
       "k_stretch",
       2.0,
       {{"k_stretch", 30.0}}}};
  BuildExample("calibration");
  for (const Case& c : cases) {
    // Of fewer nodes than the shipped recordings have.
    nlohmann::ordered_json scene =
        nlohmann::ordered_json::parse(ReadBytes(CLOTHID_SOURCE_DIR "/datasets/" + c.recording + ".scene.json"));
    scene["mesh"]["grid"]["nodes"] = {8, 8};
    if (c.recording == "wind") scene["handles"] = {0, 7};
    WriteScene(scene);
    Success(std::string(kPrefix) + "/bin/clothid simulate --scene scene.json --set " + c.simulated +
            " --output recording.bin");
    const std::string out =
        Success("calibration/calibration recording.bin 0.001 " + c.parameters + " " + c.measurement);
    const std::size_t split = out.find("\nwith ");
    ASSERT_NE(split, std::string::npos) << out;
    EXPECT_NE(out.find("\nhidden: " + c.hidden + "\n"), std::string::npos) << out;
    EXPECT_EQ(out.find("hidden:", split), std::string::npos) << out;
    std::map<std::string, Estimate> alone = ParseEstimates(out.substr(0, split));
    std::map<std::string, Estimate> both = ParseEstimates(out.substr(split));
    for (const auto& [name, value] : c.truth) {
      EXPECT_EQ(alone[name].rest, " not identifiable") << name << "\n" << out;
      EXPECT_TRUE(std::isnan(alone[name].std)) << name << "\n" << out;
      EXPECT_EQ(both[name].rest, "") << name << "\n" << out;
      EXPECT_NEAR(both[name].value, value, 0.01 * value) << name << "\n" << out;
    }
    EXPECT_NEAR(both[c.measured].std, c.sigma, 0.05 * c.sigma) << out;
  }
}

TEST_F(ExamplesTest, ObstacleOfTheUsersOwn) {
  BuildExample("obstacle");
  std::map<std::string, double> numbers = ParseNumbers(Success("obstacle/obstacle"));
  ASSERT_EQ(numbers.size(), 7u);
  EXPECT_LT(numbers["normal_error"], 1e-6);
  EXPECT_LT(numbers["normal_gradient_error"], 1e-4);
  EXPECT_GT(numbers["contacts_in_last_step"], 0.0);
  EXPECT_NEAR(numbers["adjoint"], numbers["central_difference"], 1e-5 * std::abs(numbers["adjoint"]));
  EXPECT_NEAR(numbers["mu"], numbers["true_mu"], 1e-6);
}

}  // namespace
}  // namespace clothid

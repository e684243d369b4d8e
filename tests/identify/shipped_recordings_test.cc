// The recordings in datasets/ as a user meets them: `identify` recovers the truth that datasets/README.md states, and
// `simulate` makes each of them again.
#include <gtest/gtest.h>

#include <cmath>
#include <iomanip>
#include <map>
#include <nlohmann/json.hpp>
#include <set>
#include <sstream>
#include <string>
#include <vector>

#include "datasets/motion/motion_file.h"
#include "tests/tools/tool_test.h"

namespace clothid::shipped_recordings_test {
namespace {

// A row of the table: `name.motion.bin` with nominal values and truth, both as NAME=VALUE[,...].
struct ShippedRecording {
  std::string name, nominal, truth;
};

std::string Trimmed(const std::string& text) {
  const size_t begin = text.find_first_not_of(' ');
  return begin == std::string::npos ? "" : text.substr(begin, text.find_last_not_of(' ') - begin + 1);
}

std::vector<ShippedRecording> ReadTable() {
  std::vector<ShippedRecording> recordings;
  std::istringstream text(ReadBytes(CLOTHID_SOURCE_DIR "/datasets/README.md"));
  for (std::string line; std::getline(text, line);) {
    const std::string start = "| `", suffix = ".motion.bin`";
    const size_t end = line.find(suffix);
    if (line.rfind(start, 0) != 0 || end == std::string::npos) continue;
    std::vector<std::string> cells;
    std::istringstream row(line);
    for (std::string cell; std::getline(row, cell, '|');) cells.push_back(Trimmed(cell));
    recordings.push_back({line.substr(start.size(), end - start.size()), cells.at(5), cells.at(6)});
  }
  return recordings;
}

std::map<std::string, double> ParseValues(const std::string& text) {
  std::map<std::string, double> values;
  std::istringstream items(text);
  for (std::string item; std::getline(items, item, ',');) {
    const size_t equals = item.find('=');
    values[item.substr(0, equals)] = std::stod(item.substr(equals + 1));
  }
  return values;
}

std::string Path(const std::string& file) { return CLOTHID_SOURCE_DIR "/datasets/" + file; }

struct StartingPoint {
  double cost = 0.0, gradient_norm = 0.0;
};

class ShippedRecordingsTest : public ToolTest {
 protected:
  // result.json of a fit that ends with one of `exit_codes`.
  nlohmann::json Identify(const std::string& flags, const std::set<int>& exit_codes) const {
    const ToolResult result = Run("identify --output result " + flags);
    EXPECT_EQ(exit_codes.count(result.exit_code), 1u) << result.exit_code << "\n" << result.err;
    return nlohmann::json::parse(ReadBytes(folder() / "result" / "result.json"));
  }

  // The first row of convergence.csv of the last fit, whose only parameter is k_stretch.
  StartingPoint Start() const {
    std::istringstream text(ReadBytes(folder() / "result" / "convergence.csv"));
    std::string header, row;
    std::getline(text, header);
    EXPECT_EQ(header, "iteration,seconds,cost,k_stretch,gradient_norm,rollouts");
    std::getline(text, row);
    std::vector<std::string> cells;
    std::istringstream cell_text(row);
    for (std::string cell; std::getline(cell_text, cell, ',');) cells.push_back(cell);
    return {std::stod(cells.at(2)), std::stod(cells.at(4))};
  }
};

TEST_F(ShippedRecordingsTest, AreMadeAgainBySimulate) {
  ASSERT_EQ(ReadTable().size(), 4u);
  for (const ShippedRecording& recording : ReadTable()) {
    ExpectSuccess("simulate --scene '" + Path(recording.name + ".scene.json") + "' --set " + recording.truth +
                  " --output again.bin");
    const MotionTensors shipped = ReadMotionTensors(Path(recording.name + ".motion.bin"));
    const MotionTensors again = ReadMotionTensors(folder() / "again.bin");
    EXPECT_EQ(shipped.scene_text, again.scene_text) << recording.name;
    ASSERT_EQ(shipped.positions.size(), again.positions.size()) << recording.name;
    // The same bytes on the same processor; another one may round differently in BLAS.
    EXPECT_LT((shipped.positions - again.positions).lpNorm<Eigen::Infinity>(), 1e-7) << recording.name;
    EXPECT_LT(ReadBytes(Path(recording.name + ".motion.bin")).size(), 2000000u) << recording.name;
  }
}

TEST_F(ShippedRecordingsTest, AreFarFromTheTruthAtTheirNominalValues) {
  for (const ShippedRecording& recording : ReadTable()) {
    const auto nominal = ParseValues(recording.nominal);
    for (const auto& [name, value] : ParseValues(recording.truth)) {
      if (name == "mu") {
        EXPECT_GE(std::abs(nominal.at(name) - value), 0.3) << recording.name;
      } else {
        EXPECT_GE(std::max(nominal.at(name) / value, value / nominal.at(name)), 3.0) << recording.name;
      }
    }
  }
}

TEST_F(ShippedRecordingsTest, GiveTheTruthBack) {
  const std::map<std::string, std::string> fitted = {
      {"drape", "mu,k_stretch"}, {"slope", "mu"}, {"wind", "k_stretch,k_bend"}, {"bounce", "k_stretch"}};
  for (const ShippedRecording& recording : ReadTable()) {
    const nlohmann::json result =
        Identify("--target '" + Path(recording.name + ".motion.bin") + "' --fit " + fitted.at(recording.name), {0});
    EXPECT_EQ(result["status"], "converged");
    // Without noise, and of a start that is known: no sigma is made up that residuals would be held against.
    EXPECT_FALSE(result.contains("recordings")) << result["recordings"];
    const std::string of_step = "usable with care: the error of the time step exceeds the noise";
    EXPECT_TRUE(result["usable"] == "yes" || result["verdict"][0] == of_step)
        << recording.name << ": " << result["verdict"];
    const auto truth = ParseValues(recording.truth), nominal = ParseValues(recording.nominal);
    for (const auto& [name, parameter] : result["parameters"].items()) {
      EXPECT_NEAR(parameter["value"].get<double>(), truth.at(name), 1e-4 * truth.at(name)) << recording.name;
      EXPECT_NEAR(parameter["start"].get<double>(), nominal.at(name), 1e-9 * nominal.at(name)) << recording.name;
    }
    std::filesystem::remove_all(folder() / "result");
  }
}

// A cloth that a bar draws over the edge of a table, recorded with finer steps and noise; all of it takes longer.
TEST_F(ShippedRecordingsTest, TheFirstPullGivesItsTruthBack) {
  ExpectSuccess("motion convert '" + Path("pull.motion.bin") + "' first.bin --frames 0:21");
  const nlohmann::json result = Identify("--target first.bin --fit mu.table,k_stretch --report=false", {0});
  EXPECT_EQ(result["status"], "converged");
  for (const auto& [name, truth] : ParseValues("mu.table=0.4,k_stretch=25")) {
    const nlohmann::json& parameter = result["parameters"][name];
    EXPECT_LE(parameter["lower95"].get<double>(), truth) << name;
    EXPECT_GE(parameter["upper95"].get<double>(), truth) << name;
    EXPECT_NEAR(parameter["value"].get<double>(), truth, 0.1 * truth) << name;
  }
}

// A folded strip whose layers slide on each other, from its defaults.
TEST_F(ShippedRecordingsTest, LayersGiveTheirFrictionBack) {
  for (const std::string name : {"slide", "shake"}) {
    const nlohmann::json result = Identify("--target '" + Path(name + ".motion.bin") + "' --report=false", {0});
    EXPECT_EQ(result["status"], "converged");
    const nlohmann::json& friction = result["parameters"]["mu.self"];
    EXPECT_LE(friction["lower95"].get<double>(), 0.2) << name;
    EXPECT_GE(friction["upper95"].get<double>(), 0.2) << name;
    EXPECT_NEAR(friction["value"].get<double>(), 0.2, 0.002) << name;
    std::filesystem::remove_all(folder() / "result");
  }
}

// A strip that bounces once too often within the recording is a minimum of its own: without gradient, lower than where
// it is reached from on either side, inside the bounds, and not the truth. Rollouts that the recording corrects have no
// such minimum, and lead out of it.
TEST_F(ShippedRecordingsTest, BounceHasTwoMinima) {
  for (const std::string jacobian : {"adjoint", "sensitivity"}) {
    SCOPED_TRACE(jacobian);
    const auto fit = [&](double start, const std::string& precision, int exit_code) {
      std::ostringstream flags;
      flags << "--target '" << Path("bounce.motion.bin") << "' --jacobian " << jacobian << " --precision " << precision
            << " --horizon full --assimilate off" << std::setprecision(17) << " --start k_stretch=" << start;
      const nlohmann::json result = Identify(flags.str(), {exit_code});
      EXPECT_EQ(result["status"], "converged") << start;
      EXPECT_EQ(result["parameters"]["k_stretch"]["at_bound"], false) << start;
      return result;
    };
    const nlohmann::json first = fit(6.0, "adaptive", 0);
    EXPECT_NEAR(first["parameters"]["k_stretch"]["value"].get<double>(), 5.0, 1e-4 * 5.0);
    EXPECT_LT(first["rmse_m"].get<double>(), 1e-6);
    double minimum = 0.0, cost = 0.0;
    for (const double start : {8.0, 9.0}) {
      const nlohmann::json second = fit(start, "adaptive", 6);
      minimum = second["parameters"]["k_stretch"]["value"].get<double>();
      cost = second["cost"].get<double>();
      EXPECT_EQ(second["usable"], "no") << "the cloth at rest would be nearer";
      EXPECT_NEAR(minimum, 8.553, 2e-4 * 8.553);
      EXPECT_NEAR(second["rmse_m"].get<double>(), 0.02202, 1e-5);
      EXPECT_LT(cost, 0.99 * Start().cost);
    }
    const double gradient = Start().gradient_norm;  // at 9
    fit(minimum, "full", 6);                        // else the cost at the start is that of a loose rollout
    EXPECT_LT(Start().gradient_norm, 1e-3 * gradient);
    EXPECT_NEAR(Start().cost, cost, 1e-9 * cost);
  }
  const std::string target = "--target '" + Path("bounce.motion.bin") + "' --horizon full --start k_stretch=";
  const nlohmann::json corrected = Identify(target + "9", {0});
  EXPECT_NEAR(corrected["parameters"]["k_stretch"]["value"].get<double>(), 5.0, 1e-4 * 5.0);
}

TEST_F(ShippedRecordingsTest, SeveralStartsFindBothMinimaOfBounce) {
  const std::string flags = "--target '" + Path("bounce.motion.bin") + "' --jacobian sensitivity --starts 8 --seed 1";
  const nlohmann::json led = Identify(flags, {0});
  ASSERT_EQ(led["starts"]["minima"].size(), 1u) << "the first frames lead all of them to the same";
  EXPECT_NEAR(led["parameters"]["k_stretch"]["value"].get<double>(), 5.0, 1e-4 * 5.0);
  std::filesystem::remove_all(folder() / "result");
  const nlohmann::json result = Identify(flags + " --horizon full", {0});
  EXPECT_NEAR(result["parameters"]["k_stretch"]["value"].get<double>(), 5.0, 1e-4 * 5.0);
  const nlohmann::json& minima = result["starts"]["minima"];
  ASSERT_EQ(minima.size(), 2u);
  EXPECT_NEAR(minima[0]["values"]["k_stretch"].get<double>(), 5.0, 1e-4 * 5.0);
  EXPECT_NEAR(minima[1]["values"]["k_stretch"].get<double>(), 8.553, 2e-4 * 8.553);
  EXPECT_NE(result["verdict"].dump().find("another minimum, k_stretch 8.55"), std::string::npos) << result["verdict"];
}

TEST_F(ShippedRecordingsTest, AnInterruptSavesWhatIsThere) {
  const std::string target = "--target '" + Path("drape.motion.bin") + "'";
  // The shell waits for the first progress line, that is, for the start to be evaluated, and then interrupts.
  const ToolResult result =
      Run("sh -c 'identify --output result " + target +
          " --jacobian numeric 2> progress & pid=$!; "
          "while ! grep -q iteration progress && kill -0 $pid; do sleep 0.05; done; kill -TERM $pid; wait $pid'");
  EXPECT_EQ(result.exit_code, 130) << result.err;
  const nlohmann::json written = nlohmann::json::parse(ReadBytes(folder() / "result" / "result.json"));
  EXPECT_EQ(written["status"], "interrupted");
  EXPECT_EQ(written["exit_code"], 130);
  EXPECT_TRUE(std::filesystem::exists(folder() / "result" / "predicted.bin"));
  EXPECT_TRUE(std::filesystem::exists(folder() / "result" / "convergence.csv"));
}

}  // namespace
}  // namespace clothid::shipped_recordings_test

#include <gflags/gflags.h>

#include <cmath>
#include <iostream>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "datasets/curves/lab_table.h"
#include "sim/base/error.h"
#include "sim/base/text_file.h"
#include "tools/motion/motion_commands.h"
#include "tools/motion/repeated_value.h"

DECLARE_bool(json);

namespace clothid {
namespace {

constexpr double kDegreesPerRadian = 57.29577951308232;
constexpr double kSteepestPlate = 80.0;  // degrees: there mu is 5.7

// tan(angle) of every row.
Eigen::VectorXd ReadSlidingAngles(const std::string& path) {
  static const std::vector<LabForm> forms = {
      {{{{"angle", "winkel"}, {LabQuantity::kAngle}, "deg or rad"}}, "a column of the angle", "Angle [deg]"}};
  const LabTable table = ReadLabTable(path, forms);
  for (Eigen::Index row = 0; row < table.values.rows(); ++row) {
    const double degrees = kDegreesPerRadian * table.values(row, 0);
    if (degrees > 0.0 && degrees <= kSteepestPlate) continue;
    throw Error(ErrorKind::kBadData, path + ":" + std::to_string(table.lines[static_cast<std::size_t>(row)]) +
                                         ": expected an angle between 0 and 80 degrees to the level, found " +
                                         ShortestText(degrees));
  }
  return table.values.col(0).array().tan();
}

nlohmann::ordered_json FrictionJson(const RepeatedValue& mu, const std::string& file) {
  nlohmann::ordered_json report = {
      {"schema", "clothid.friction/1"}, {"file", file}, {"tests", mu.count}, {"mu", mu.mean}};
  if (!mu.is_repeated()) return report;
  report["std"] = mu.std;
  report["lower95"] = mu.mean - mu.half95;
  report["upper95"] = mu.mean + mu.half95;
  report["prior"] = {{"mean", mu.mean}, {"std", mu.next_std}};
  return report;
}

}  // namespace

int MotionFriction(const std::vector<std::string>& arguments) {
  const std::string& path = arguments.front();
  const RepeatedValue mu = MeanOfRepetitions(ReadSlidingAngles(path));
  if (FLAGS_json) {
    std::cout << FrictionJson(mu, path).dump(2, ' ', false, nlohmann::ordered_json::error_handler_t::replace) << "\n";
  } else if (mu.is_repeated()) {
    std::cout << "mu " << mu.mean << ", 95 % interval " << mu.mean - mu.half95 << " .. " << mu.mean + mu.half95
              << ", standard deviation " << mu.std << " of " << mu.count << " tests\n"
              << "as what is believed of the next specimen: identify --prior mu=" << mu.mean << ":" << mu.next_std
              << "\n";
  } else {
    std::cout << "mu " << mu.mean << "; one test has no scatter: repeat it for an interval\n";
  }
  return kExitSuccess;
}

}  // namespace clothid

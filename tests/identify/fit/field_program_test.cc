// `simulate --set_field` and `identify --field`, from the command line to the files.
#include <gtest/gtest.h>

#include <filesystem>
#include <nlohmann/json.hpp>
#include <string>

#include "sim/scene/material_field.h"
#include "tests/tools/small_drape.h"
#include "tests/tools/tool_test.h"

namespace clothid::field_program_test {
namespace {

using Json = nlohmann::ordered_json;

class FieldProgramTest : public ToolTest {
 protected:
  FieldProgramTest() {
    WriteBytes(folder() / "scene.json", SmallDrape(8));
    Eigen::MatrixXd truth(3, 3);
    truth << 50, 60, 70, 60, 90, 100, 70, 80, 120;
    WriteBytes(folder() / "truth.npy", FieldValuesNpy(truth));
  }
};

TEST_F(FieldProgramTest, WhatIsFittedCanBeSimulatedAgain) {
  ExpectSuccess(
      "simulate --scene scene.json --set_field k_stretch=truth.npy --set mu=0.24 --noise 0.0005 --output cloth.bin");
  const ToolResult result =
      Run("identify --target cloth.bin --fit mu,k_stretch --field k_stretch:3x3 --report=false --output result");
  EXPECT_TRUE(result.exit_code == 0 || result.exit_code == 4) << result.exit_code << result.err << result.out;
  EXPECT_NE(result.out.find("field           k_stretch over 3 x 3: "), std::string::npos) << result.out;
  const Json json = Json::parse(ReadBytes(folder() / "result" / "result.json"));
  const Json& field = json["fields"]["fields"]["k_stretch"];
  EXPECT_EQ(field["values"].size(), 3u);
  EXPECT_EQ(field["determined"][2].size(), 3u);
  EXPECT_EQ(json["status"], "converged");
  EXPECT_EQ(json["plan"].back()["stage"], "all frames: parameters, fields, smoothness");
  EXPECT_TRUE(json["fields"]["weight_is_chosen"].get<bool>());
  const std::string file = (folder() / "result" / "field_k_stretch.npy").string();
  const Eigen::MatrixXd values = ReadFieldValues(file);
  EXPECT_EQ(values(2, 0), field["values"][2][0].get<double>());
  ExpectSuccess("simulate --scene scene.json --set_field k_stretch=" + file + " --set mu=0.24 --output again.bin");
}

// Nothing of another fit is left.
TEST_F(FieldProgramTest, FilesOfFieldsGoWithTheirFit) {
  std::filesystem::create_directories(folder() / "result");
  WriteBytes(folder() / "flat.json", SmallDrape(4));
  ExpectSuccess("simulate --scene flat.json --output flat.bin");
  WriteBytes(folder() / "result" / "field_k_bend.npy", "old");
  Run("identify --target flat.bin --fit k_stretch --max_iterations 1 --report=false --output result");
  EXPECT_FALSE(std::filesystem::exists(folder() / "result" / "field_k_bend.npy"));
}

TEST_F(FieldProgramTest, RefusesWhatDoesNotGoTogether) {
  ExpectSuccess("simulate --scene scene.json --output cloth.bin");
  const auto expect = [this](const std::string& flags, const std::string& culprit) {
    ExpectRefused("identify --target cloth.bin --output result " + flags, 1, culprit);
  };
  expect("--field k_stretch", "--field: expected NAME:ROWSxCOLUMNS");
  expect("--field mu:4x4", "--field: 'mu' can be no field");
  expect("--field_weight 1", "--field_weight: expected with --field");
  expect("--field k_stretch:2x2 --field_weight -1", "--field_weight: expected a number > 0");
  expect("--field k_stretch:2x2 --each k_stretch", "--each: 'k_stretch' is a field");
  ExpectRefused("simulate --scene scene.json --set_field mu=truth.npy --output x.bin", 1,
                "--set_field: 'mu' can be no field");
  ExpectRefused("simulate --scene scene.json --set_field k_stretch=absent.npy --output x.bin", 1, "absent.npy");
  WriteBytes(folder() / "text.npy", "no array");
  ExpectRefused("simulate --scene scene.json --set_field k_stretch=text.npy --output x.bin", 2, "text.npy");
}

}  // namespace
}  // namespace clothid::field_program_test

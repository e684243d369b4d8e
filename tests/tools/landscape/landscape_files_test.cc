// What is written of a landscape reads back exactly, or is refused.
#include "tools/landscape/landscape_files.h"

#include <gtest/gtest.h>

#include <cmath>
#include <filesystem>
#include <fstream>
#include <iterator>

#include "datasets/files/sha256.h"
#include "identify/landscape/landscape_row.h"
#include "tests/expect_error.h"
#include "tests/temporary_folder.h"
#include "tests/tools/landscape/made_up_landscape.h"
#include "tools/landscape/landscape_store.h"

namespace clothid::landscape_files_test {
namespace {

class LandscapeFilesTest : public testing::Test {
 protected:
  std::string Write(const Landscape& landscape, const LandscapeOrigin& origin, const std::string& name) const {
    OutputFolder folder(folder_.File(name));
    WriteLandscape(landscape, origin, &folder);
    folder.Commit();
    return folder.path();
  }
  static std::string Bytes(const std::string& folder, const char* name) {
    std::ifstream file(std::filesystem::path(folder) / name, std::ios::binary);
    return {std::istreambuf_iterator<char>(file), std::istreambuf_iterator<char>()};
  }
  // The file `name` with its first `before` as `after`; plan.json is made to fit landscape.csv.
  static void Replace(const std::string& folder, const char* name, const std::string& before,
                      const std::string& after) {
    const auto replace = [](std::string text, const std::string& from, const std::string& to) {
      EXPECT_NE(text.find(from), std::string::npos) << from;
      return text.replace(text.find(from), from.size(), to);
    };
    const std::string old_digest = Sha256Hex({Bytes(folder, kLandscapeCsv)}), plan = Bytes(folder, kPlanJson);
    const std::string changed = replace(Bytes(folder, name), before, after);
    std::ofstream(std::filesystem::path(folder) / name, std::ios::binary) << changed;
    if (name != std::string(kLandscapeCsv)) return;
    std::ofstream(std::filesystem::path(folder) / kPlanJson) << replace(plan, old_digest, Sha256Hex({changed}));
  }

  TemporaryFolder folder_;
};

TEST_F(LandscapeFilesTest, ReadBackExactly) {
  for (const bool has_gradients : {false, true}) {
    const Landscape landscape = MadeUpLandscape(has_gradients);
    const std::string folder = Write(landscape, MadeUpOrigin({}), has_gradients ? "with" : "without");
    const LandscapePart part = ReadLandscapePart(folder);
    ExpectSameLandscape(part.landscape, landscape);
    EXPECT_EQ(part.origin.truth, MadeUpOrigin({}).truth);
    EXPECT_EQ(part.origin.fingerprint, MadeUpOrigin({}).fingerprint);
    ASSERT_TRUE(part.origin.sigma);
    EXPECT_TRUE(IsSameSigma(*part.origin.sigma, *MadeUpOrigin({}).sigma));
    EXPECT_EQ(part.origin.sigma->rmse_of_root_cost, MadeUpOrigin({}).sigma->rmse_of_root_cost);
    const std::string again = Write(part.landscape, part.origin, "again");
    for (const char* name : {kLandscapeCsv, kTimingCsv, kPlanJson}) EXPECT_EQ(Bytes(again, name), Bytes(folder, name));
    ExpectSameLandscape(ReadWholeLandscape(folder).landscape, landscape);
  }
}

TEST_F(LandscapeFilesTest, RowsHaveTheAgreedColumns) {
  const Landscape landscape = MadeUpLandscape(true);
  EXPECT_EQ(
      RowHeader(landscape.plan),
      "x,y,setting,contact,cost,contact_changes,contacts,failed_steps,zoom,nodes_joined,nodes_left,branch_switches,"
      "obstacle_switches,pair_changes,steps,substeps,gradient_x,gradient_y,failure");
  EXPECT_EQ(CellRow(landscape.plan, 25, landscape.cells[25]),
            "0.25,10,touch=1e-05,velocity,8.5,128,25,0,1,26,26,26,25,50,20,0,-0.25,1e-300,");
  EXPECT_EQ(CellRow(landscape.plan, kFailedCell, landscape.cells[kFailedCell]),
            "0.5,10,touch=1e-05,gap,,13,2,1,1,3,3,3,2,4,20,0,,,\"step 3 \"\"failed\"\", residual 1e-3, badly\"");
}

TEST_F(LandscapeFilesTest, RefusesDamagedRows) {
  const Landscape landscape = MadeUpLandscape(true);
  const auto expect_refused = [&](const std::string& before, const std::string& after, const char* where,
                                  const char* expected) {
    const std::string folder = Write(landscape, MadeUpOrigin({}), "damaged");
    Replace(folder, kLandscapeCsv, before, after);
    ExpectError([&] { ReadWholeLandscape(folder); }, ErrorKind::kBadData, {where, expected});
  };
  expect_refused("x,y,", "y,x,", "landscape.csv:1", "header");
  expect_refused("\n0.25,", "\n0.35,", "landscape.csv:3", "of this cell in the plan");
  expect_refused("\n0.25,10,touch=1e-05,gap,", "\n0.25,10,touch=1e-05,velocity,", "landscape.csv:3",
                 "of this cell in the plan");
  expect_refused(",3,", ",-3,", "landscape.csv:2", "count");
  expect_refused("gap,0.5,", "gap,O.5,", "landscape.csv:2", "'cost'");
  expect_refused("gap,0.5,", "gap,,", "landscape.csv:2", "a cost");
  expect_refused("gap,0.5,3,", "gap,0.5,4,", "landscape.csv:2", "sum of its parts");
  expect_refused(",-0.25,1e-300,\n", ",,1e-300,\n", "landscape.csv:2", "gradients");
  expect_refused(", badly\"", ", badly", "landscape.csv:4", "reason");
  const std::string folder = Write(landscape, MadeUpOrigin({}), "damaged");
  std::ofstream(std::filesystem::path(folder) / kLandscapeCsv, std::ios::app) << "1";
  ExpectError([&] { ReadWholeLandscape(folder); }, ErrorKind::kBadData, {"landscape.csv", "plan.json"});
}

// A scan of clothid 0.1, and one whose points differ in sigma.
TEST_F(LandscapeFilesTest, SigmaMayBeMissing) {
  LandscapeOrigin origin = MadeUpOrigin({});
  origin.sigma.reset();
  EXPECT_FALSE(ReadWholeLandscape(Write(MadeUpLandscape(false), origin, "old")).origin.sigma);
  origin.sigma.emplace().source = SigmaSource::kRecorded;
  const LandscapePart part = ReadWholeLandscape(Write(MadeUpLandscape(false), origin, "differ"));
  ASSERT_TRUE(part.origin.sigma);
  EXPECT_TRUE(std::isnan(part.origin.sigma->value));
  EXPECT_TRUE(IsSameSigma(*part.origin.sigma, *origin.sigma));
  EXPECT_FALSE(IsSameSigma(*part.origin.sigma, *MadeUpOrigin({}).sigma));
}

TEST_F(LandscapeFilesTest, RefusesDamagedPlans) {
  const auto expect_refused = [&](const std::string& before, const std::string& after, const char* expected) {
    const std::string folder = Write(MadeUpLandscape(false), MadeUpOrigin({}), "damaged");
    Replace(folder, kPlanJson, before, after);
    ExpectError([&] { ReadWholeLandscape(folder); }, ErrorKind::kBadData, {"plan.json", expected});
  };
  expect_refused("clothid.landscape/1", "clothid.landscape/2", "schema");
  expect_refused("\"given\"", "\"guessed\"", "sigma.source");
  expect_refused("\"sigma_m\": 0.3", "\"sigma_m\": -0.3", "sigma.sigma_m");
  expect_refused("\"rmse_of_root_cost_m\"", "\"rmse_m\"", "rmse_of_root_cost_m");
  expect_refused("\"cells\": 4", "\"cells\": 1", "cells");
  expect_refused("\"given\"", "\"guessed\"", "sigma.source");
  expect_refused("\"sigma_m\": 0.3", "\"sigma_m\": -0.3", "sigma.sigma_m");
  expect_refused("\"rmse_of_root_cost_m\"", "\"rmse_m\"", "rmse_of_root_cost_m");
  expect_refused("\"cells\": 4", "\"cells\": 2000001", "at most");
  expect_refused("\"log\"", "\"cubic\"", "scale");
  expect_refused("\"velocity\"", "\"both\"", "contact");
  expect_refused("0.75", "-1", "increasing");
  expect_refused("10.0", "-10.0", "log axis");
  expect_refused("\"k_stretch\"", "\"mu\"", "two parameters");
  expect_refused("\"fingerprint\"", "\"thumbprint\"", "fingerprint");
  const std::string folder = Write(MadeUpLandscape(false), MadeUpOrigin({}), "damaged");
  Replace(folder, kTimingCsv, "\n3,", "\n4,");
  ExpectError([&] { ReadWholeLandscape(folder); }, ErrorKind::kBadData, {"timing.csv:5", "cell 3"});
  ExpectError([&] { ReadWholeLandscape(folder_.File("nowhere")); }, ErrorKind::kIo, {"nowhere", "plan.json"});
}

class LandscapeMergeTest : public LandscapeFilesTest {
 protected:
  std::string WriteShard(int index, int count) const {
    Landscape part = landscape_;
    for (std::size_t cell = 0; cell < part.cells.size(); ++cell) {
      if (static_cast<int>(cell) % count != index) part.cells[cell] = {};
    }
    return Write(part, MadeUpOrigin({index, count}), std::to_string(index) + "_" + std::to_string(count));
  }
  static void ExpectRefused(const std::vector<std::string>& folders, ErrorKind kind,
                            std::initializer_list<const char*> expected) {
    ExpectError([&] { MergeLandscapes(folders); }, kind, expected);
  }

  const Landscape landscape_ = MadeUpLandscape(true);
};

TEST_F(LandscapeMergeTest, GivesTheBytesOfTheWhole) {
  const std::string whole = Write(landscape_, MadeUpOrigin({}), "whole");
  for (const int count : {1, 2, 3, 7, 100}) {
    std::vector<std::string> folders;
    for (int index = count - 1; index >= 0; --index) folders.push_back(WriteShard(index, count));
    const LandscapePart merged = MergeLandscapes(folders);
    const std::string folder = Write(merged.landscape, merged.origin, "merged");
    for (const char* name : {kLandscapeCsv, kTimingCsv, kPlanJson}) EXPECT_EQ(Bytes(folder, name), Bytes(whole, name));
  }
}

TEST_F(LandscapeMergeTest, RefusesWhatIsNotOneScan) {
  const std::string first = WriteShard(0, 3), second = WriteShard(1, 3), third = WriteShard(2, 3);
  ExpectRefused({}, ErrorKind::kUsage, {"folders of the shards"});
  ExpectRefused({first, third}, ErrorKind::kUsage, {"shard 1 of 3 is missing"});
  ExpectRefused({first, second, third, second}, ErrorKind::kUsage, {"1_3", "shard 1 of 3"});
  ExpectRefused({first, second, WriteShard(2, 4)}, ErrorKind::kUsage, {"2_4", "shard 2 of 4", "shard 0 of 3"});
  ExpectRefused({first, Write(landscape_, MadeUpOrigin({}), "whole")}, ErrorKind::kUsage, {"whole", "shard 0 of 1"});
  LandscapeOrigin other = MadeUpOrigin({1, 3});
  other.fingerprint = std::string(64, 'c');
  ExpectRefused({first, Write(landscape_, other, "other"), third}, ErrorKind::kUsage, {"other", "another scan"});
  ExpectRefused({first, second, folder_.File("nowhere")}, ErrorKind::kIo, {"nowhere"});
  ExpectError([&] { ReadWholeLandscape(first); }, ErrorKind::kBadData, {"0_3", "shard 0 of 3", "merge"});
  { LandscapeStore store(second, landscape_.plan, MadeUpOrigin({1, 3})); }
  ExpectRefused({first, second, third}, ErrorKind::kBadData, {"1_3", "--resume"});
}

}  // namespace
}  // namespace clothid::landscape_files_test

// A scan that is stopped at any byte goes on from its whole cells.
#include "tools/landscape/landscape_store.h"

#include <gtest/gtest.h>

#include <filesystem>
#include <fstream>
#include <iterator>

#include "tests/expect_error.h"
#include "tests/temporary_folder.h"
#include "tests/tools/landscape/made_up_landscape.h"

namespace clothid::landscape_store_test {
namespace {

const std::vector<int> kCells = {4, 1, 7};  // of shard 1 of 3, in the order of two threads

class LandscapeStoreTest : public testing::Test {
 protected:
  LandscapeStoreTest() {
    LandscapeStore store(folder_.path(), landscape_.plan, origin_);
    for (const int cell : kCells) {
      ends_.push_back(Bytes().size());
      store.Append(cell, landscape_.cells[cell]);
    }
    whole_ = Bytes();
  }

  std::string path() const { return folder_.File(".landscape_cells"); }
  std::string Bytes() const {
    std::ifstream file(path(), std::ios::binary);
    return {std::istreambuf_iterator<char>(file), std::istreambuf_iterator<char>()};
  }
  void Write(const std::string& bytes) const { folder_.Write(".landscape_cells", bytes); }

  // The cells that the store gives back, each as it was.
  std::vector<int> Replay(LandscapeStore* store) const {
    Landscape found, expected;
    found.plan = expected.plan = landscape_.plan;
    found.cells.resize(landscape_.cells.size());
    const std::vector<int> cells = store->Replay(&found);
    expected.cells.resize(landscape_.cells.size());
    for (const int cell : cells) expected.cells[cell] = landscape_.cells[cell];
    ExpectSameLandscape(found, expected);
    return cells;
  }
  void ExpectRefused(ErrorKind kind, std::initializer_list<const char*> expected) const {
    ExpectError(
        [&] {
          LandscapeStore store(folder_.path(), landscape_.plan, origin_);
          Replay(&store);
        },
        kind, expected);
  }

  const Landscape landscape_ = MadeUpLandscape(true);
  const LandscapeOrigin origin_ = MadeUpOrigin({1, 3});
  TemporaryFolder folder_;
  std::string whole_;
  std::vector<std::size_t> ends_;  // [i] of the file before cell i
};

TEST_F(LandscapeStoreTest, GivesBackItsCells) {
  EXPECT_TRUE(LandscapeStore::ExistsIn(folder_.path()));
  LandscapeStore store(folder_.path(), landscape_.plan, origin_);
  EXPECT_EQ(Replay(&store), kCells);
  store.Remove();
  EXPECT_FALSE(LandscapeStore::ExistsIn(folder_.path()));
}

TEST_F(LandscapeStoreTest, GoesOnFromEveryTornTail) {
  for (std::size_t length = 0; length < whole_.size(); length += 3) {
    Write(whole_.substr(0, length));
    LandscapeStore store(folder_.path(), landscape_.plan, origin_);
    const std::size_t num_whole = Replay(&store).size();
    ASSERT_EQ(num_whole, length < ends_[1] ? 0u : length < ends_[2] ? 1u : 2u) << length;
    for (std::size_t i = num_whole; i < kCells.size(); ++i) store.Append(kCells[i], landscape_.cells[kCells[i]]);
    ASSERT_EQ(Bytes(), whole_) << length;
  }
}

TEST_F(LandscapeStoreTest, RefusesADamagedCell) {
  for (std::size_t i = ends_[0]; i < ends_[2]; ++i) {
    std::string damaged = whole_;
    damaged[i] = static_cast<char>(damaged[i] ^ (1 << (i % 8)));
    Write(damaged);
    ExpectRefused(ErrorKind::kBadData,
                  {".landscape_cells", i < ends_[1] ? "record 1 is damaged" : "record 2 is damaged"});
    ASSERT_EQ(Bytes(), damaged);
  }
}

TEST_F(LandscapeStoreTest, RefusesOtherScans) {
  const auto expect_refused = [&](const LandscapeOrigin& origin) {
    ExpectError([&] { LandscapeStore(folder_.path(), landscape_.plan, origin); }, ErrorKind::kUsage,
                {".landscape_cells", "another recording", "remove"});
  };
  expect_refused(MadeUpOrigin({2, 3}));
  expect_refused(MadeUpOrigin({1, 4}));
  LandscapeOrigin origin = origin_;
  origin.fingerprint[0] = 'b';
  expect_refused(origin);
  EXPECT_EQ(Bytes(), whole_);
  const LandscapeStore store(folder_.path(), landscape_.plan, origin_);
  ExpectError([&] { LandscapeStore(folder_.path(), landscape_.plan, origin_); }, ErrorKind::kIo, {"another process"});
}

TEST_F(LandscapeStoreTest, RefusesCellsThatItCannotHave) {
  const auto append = [&](int cell, int row) {
    Write(whole_);
    LandscapeStore store(folder_.path(), landscape_.plan, origin_);
    ASSERT_EQ(Replay(&store), kCells);
    store.Append(cell, landscape_.cells[row]);
  };
  append(7, 7);
  ExpectRefused(ErrorKind::kBadData, {"record 4", "there already"});
  append(5, 5);
  ExpectRefused(ErrorKind::kBadData, {"record 4", "no cell of this scan"});
}

}  // namespace
}  // namespace clothid::landscape_store_test

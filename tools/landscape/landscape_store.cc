#include "tools/landscape/landscape_store.h"

#include <algorithm>
#include <filesystem>
#include <optional>
#include <set>
#include <string_view>
#include <system_error>

#include "datasets/files/sha256.h"
#include "identify/landscape/landscape_row.h"
#include "sim/base/error.h"
#include "sim/base/text_file.h"

namespace clothid {
namespace {

namespace fs = std::filesystem;

fs::path PathIn(const std::string& folder) { return fs::path(folder) / kCellStore; }

RecordFile::Kind StoreKind() {
  return {"clothid landscape cells 1", "the cells of a landscape, version 1",
          "is of a scan with another recording, scene, program, shard or other flags; remove it, or use another "
          "--output"};
}

std::string ShardFingerprint(const LandscapeOrigin& origin) {
  return Sha256Hex({origin.fingerprint, std::to_string(origin.shard.index), "/", std::to_string(origin.shard.count)});
}

// Takes the text before the next comma off the front of `rest`.
std::string_view TakeColumn(std::string_view* rest) {
  const std::size_t comma = std::min(rest->find(','), rest->size());
  const std::string_view column = rest->substr(0, comma);
  rest->remove_prefix(std::min(comma + 1, rest->size()));
  return column;
}

}  // namespace

bool LandscapeStore::ExistsIn(const std::string& folder) {
  std::error_code ignored;
  return fs::exists(PathIn(folder), ignored);
}

LandscapeStore::LandscapeStore(const std::string& folder, const LandscapePlan& plan, const LandscapeOrigin& origin)
    : plan_(plan), shard_(origin.shard), file_(PathIn(folder).string(), StoreKind(), ShardFingerprint(origin)) {}

std::vector<int> LandscapeStore::Replay(Landscape* landscape) {
  std::vector<int> cells;
  std::set<int> seen;
  std::string record;
  for (;;) {
    const RecordFile::Next next = file_.Read(&record);
    if (next == RecordFile::Next::kEnd || next == RecordFile::Next::kTorn) break;
    const std::string source = file_.path() + ": record " + std::to_string(cells.size() + 1);
    const auto fail = [&](const std::string& problem) {
      throw Error(ErrorKind::kBadData, source + " " + problem + "; remove the file to start again");
    };
    if (next == RecordFile::Next::kDamaged) fail("is damaged");
    std::string_view row = record;
    const std::optional<long long> cell = ParseInteger(TakeColumn(&row));
    const std::optional<double> seconds = ParseNumber(TakeColumn(&row));
    const bool is_known = cell && seconds && *cell >= 0 && *cell < plan_.num_cells();
    if (!is_known || *cell % shard_.count != shard_.index) fail("is of no cell of this scan");
    cells.push_back(static_cast<int>(*cell));
    if (!seen.insert(cells.back()).second) fail("is of a cell that is there already");
    LandscapeCell& result = landscape->cells[cells.back()];
    result = ParseRow(plan_, cells.back(), row, source);
    result.seconds = *seconds;
  }
  file_.Truncate();
  return cells;
}

void LandscapeStore::Append(int cell, const LandscapeCell& result) {
  file_.Append(std::to_string(cell) + "," + ShortestText(result.seconds) + "," + CellRow(plan_, cell, result));
}

void LandscapeStore::Remove() {
  std::error_code error;
  fs::remove(file_.path(), error);
  if (error) throw Error(ErrorKind::kIo, file_.path() + ": cannot be removed: " + error.message());
}

}  // namespace clothid

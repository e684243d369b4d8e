// The folder of a finished scan: plan.json, landscape.csv and timing.csv, with a byte 0 between them. The checksum of
// landscape.csv is made right.
#include "datasets/files/sha256.h"
#include "identify/landscape/landscape_folder.h"
#include "identify/landscape/landscape_row.h"
#include "sim/base/json_document.h"
#include "sim/base/text_file.h"
#include "tests/fuzz/fuzz_target.h"
#include "tests/temporary_folder.h"
#include "tools/landscape/landscape_summary.h"

namespace clothid {
namespace {

// What every row tells can be told again.
void CheckRows(const LandscapePart& part) {
  const LandscapePlan& plan = part.landscape.plan;
  for (const int cell : part.origin.shard.Cells(plan)) {
    const std::string row = CellRow(plan, cell, part.landscape.cells[cell]);
    LandscapeCell again;
    Check(Accepts([&] { again = ParseRow(plan, cell, row, "row"); }, "row"), "a row that reads back");
    Check(CellRow(plan, cell, again) == row, "the same row");
  }
}

}  // namespace
}  // namespace clothid

int clothid::FuzzLandscapeFolder(const std::uint8_t* data, std::size_t size) {
  static const TemporaryFolder folder;
  std::vector<std::string> files = Split(AsText(data, size), '\0');
  files.resize(3);
  SetDigest("landscape_sha256", Sha256Hex({files[1]}), &files[0]);
  folder.Write(kPlanJson, files[0]);
  folder.Write(kLandscapeCsv, files[1]);
  folder.Write(kTimingCsv, files[2]);
  LandscapePart part;
  if (!Accepts([&] { part = ReadLandscapePart(folder.path()); }, folder.path())) return 0;
  CheckRows(part);
  if (part.origin.shard.is_whole()) SummaryJson(Summarize(part.landscape));
  return 0;
}

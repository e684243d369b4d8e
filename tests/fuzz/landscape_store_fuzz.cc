// The cells of a scan under way. The first byte is that of tests/fuzz/record_bytes.h.
#include <algorithm>

#include "sim/base/text_file.h"
#include "tests/fuzz/fuzz_target.h"
#include "tests/fuzz/record_bytes.h"
#include "tests/temporary_folder.h"
#include "tools/landscape/landscape_store.h"

namespace clothid {
namespace {

LandscapePlan MakePlan() {
  LandscapePlan plan;
  LandscapeWindow window;
  window.x = {"mu", ParameterScale::kLinear, 0.0, 0.5, 3};
  window.y = {"k_stretch", ParameterScale::kLog, 10.0, 1000.0, 2};
  plan.windows = {window};
  plan.settings = {{"", ContactMode::kGap}, {"touch=1e-05", ContactMode::kVelocity}};
  plan.has_gradients = true;
  return plan;
}

// The header that the store itself writes.
std::string MakeHeader(const std::string& folder, const LandscapePlan& plan, const LandscapeOrigin& origin) {
  LandscapeStore(folder, plan, origin);
  return ReadFile(folder + "/.landscape_cells", 4096);
}

}  // namespace
}  // namespace clothid

int clothid::FuzzLandscapeStore(const std::uint8_t* data, std::size_t size) {
  if (size == 0) return 0;
  static const TemporaryFolder folder;
  static const LandscapePlan plan = MakePlan();
  static const LandscapeOrigin origin;
  static const std::string header = MakeHeader(folder.path(), plan, origin);
  folder.Write(".landscape_cells", header + RecordBytes(data[0], AsText(data + 1, size - 1)));
  Landscape landscape{plan, std::vector<LandscapeCell>(plan.num_cells())};
  Accepts(
      [&] {
        LandscapeStore store(folder.path(), plan, origin);
        const std::vector<int> cells = store.Replay(&landscape);
        Check(std::all_of(cells.begin(), cells.end(), [&](int cell) { return cell < plan.num_cells(); }),
              "known cells");
      },
      folder.path());
  return 0;
}

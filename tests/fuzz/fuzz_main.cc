// One program for every target, which CLOTHID_FUZZ_TARGET names: libFuzzer calls LLVMFuzzerTestOneInput. Without
// libFuzzer, replay_main.cc does.
#include <array>
#include <cstdlib>
#include <string>
#include <string_view>

#include "tests/fuzz/fuzz_target.h"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size);

namespace clothid {
namespace {

struct Target {
  std::string_view name;
  int (*run)(const std::uint8_t* data, std::size_t size);
};

constexpr std::array kTargets = {
    Target{"curve", &FuzzCurve},
    Target{"fabric_card", &FuzzFabricCard},
    Target{"flags", &FuzzFlags},
    Target{"handle_csv", &FuzzHandleCsv},
    Target{"import", &FuzzImport},
    Target{"journal", &FuzzJournal},
    Target{"landscape_folder", &FuzzLandscapeFolder},
    Target{"landscape_store", &FuzzLandscapeStore},
    Target{"motion", &FuzzMotion},
    Target{"npy", &FuzzNpy},
    Target{"obj", &FuzzObj},
    Target{"pc2", &FuzzPc2},
    Target{"ply", &FuzzPly},
    Target{"ros_csv", &FuzzRosCsv},
    Target{"scene", &FuzzScene},
    Target{"sensor", &FuzzSensor},
    Target{"tracks_csv", &FuzzTracksCsv},
    Target{"trc", &FuzzTrc},
};

const Target& ChosenTarget() {
  const char* chosen = std::getenv("CLOTHID_FUZZ_TARGET");
  const std::string_view name = chosen ? chosen : "";
  for (const Target& target : kTargets) {
    if (target.name == name) return target;
  }
  std::fprintf(stderr, "CLOTHID_FUZZ_TARGET: expected the name of a target, got '%s'\n", std::string(name).c_str());
  std::exit(2);
}

}  // namespace
}  // namespace clothid

int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  static const clothid::Target& target = clothid::ChosenTarget();
  return target.run(data, size);
}

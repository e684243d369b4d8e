#include "identify/export/export.h"

#include <gtest/gtest.h>

#include "tests/expect_error.h"
#include "tests/sim/garments.h"
#include "tests/sim/plain_scenes.h"

namespace clothid::export_test {
namespace {

// What no file here can tell is refused before a fit, not left out after it.
TEST(ExpectExportableTest, RefusesWhatIsSewn) {
  const Scene plain = ClothScene(SquareGrid(4, 0.3), 0.01);
  EXPECT_NO_THROW(ExpectExportable(plain, "a.bin"));
  EXPECT_FALSE(ExportCloth(plain, plain.nominal_parameters(), {"mujoco"}).empty());
  Scene garment = plain, buttoned = plain;
  garment.mesh = WithUvRest(plain.mesh);
  buttoned.mesh.links = {{0, {15, 15}, 0.0, 100.0, 0.0}};
  for (const Scene& scene : {garment, buttoned}) {
    ExpectError([&] { ExpectExportable(scene, "a.bin"); }, ErrorKind::kUsage,
                {"a.bin: expected a cloth without seams", "\"rest\": \"uv\""});
    ExpectError([&] { ExportCloth(scene, scene.nominal_parameters(), {"mujoco"}); }, ErrorKind::kUsage,
                {"expected a cloth without seams"});
  }
}

}  // namespace
}  // namespace clothid::export_test

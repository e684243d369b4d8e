// A scene runs none of the code that it has no use for: callgrind lists the source files of every executed instruction.
#include <gtest/gtest.h>

#include <filesystem>
#include <nlohmann/json.hpp>
#include <set>
#include <sstream>
#include <string>

#include "tests/tools/tool_test.h"

namespace clothid::profile_test {
namespace {

using Json = nlohmann::ordered_json;

class ProfileTest : public ToolTest {
 protected:
  // The names, without folders, of the files of which `simulate` executes something on `scene`.
  std::set<std::string> ExecutedFiles(const Json& scene) const {
    // OPENBLAS_CORETYPE: kernels that valgrind can decode, whatever the machine.
    const ToolResult result = Run(
        "env OPENBLAS_CORETYPE=Haswell valgrind --tool=callgrind --compress-strings=no --callgrind-out-file=profile "
        "'" CLOTHID_BINARY_DIR "/simulate' --scene " +
        WriteScene(scene) + " --output out.bin");
    EXPECT_EQ(result.exit_code, 0) << result.err;
    std::istringstream profile(ReadBytes(folder() / "profile"));
    std::set<std::string> files;
    for (std::string line; std::getline(profile, line);) {
      for (const char* key : {"fl=", "fi=", "fe="}) {
        if (line.rfind(key, 0) == 0) files.insert(std::filesystem::path(line.substr(3)).filename());
      }
    }
    return files;
  }

  // Whether the last of them called it. (What picks the version of a function for the processor is executed in every
  // program, and counts as a line of that function's file.)
  bool Called(const std::string& function) const {
    return ReadBytes(folder() / "profile").find("\nfn=clothid::" + function + "(") != std::string::npos;
  }
};

TEST_F(ProfileTest, BareSceneRunsNoContactBendingDragOrDamping) {
  const std::set<std::string> files = ExecutedFiles(BareScene());
  EXPECT_EQ(files.count("stretch_energy.cc"), 1u);
  for (const char* file :
       {"contact.cc", "contact_law.cc", "contact_law.h", "contact_elimination.cc", "obstacle.cc", "bending_energy.cc",
        "bending_patch.cc", "air_drag.cc", "directional_drag.cc", "strain_rate_damping.cc", "warp.cc"}) {
    EXPECT_EQ(files.count(file), 0u) << file;
  }
  EXPECT_TRUE(Called("StretchEnergy::AddForce"));
  EXPECT_FALSE(Called("OrthotropicEnergy::AddForce"));
}

TEST_F(ProfileTest, SphereRunsContactAlone) {
  const std::set<std::string> files = ExecutedFiles(SphereJson());
  for (const char* file : {"contact.cc", "contact_law.cc", "contact_law.h", "contact_elimination.cc", "obstacle.cc"})
    EXPECT_EQ(files.count(file), 1u) << file;
  for (const char* file : {"bending_energy.cc", "air_drag.cc", "strain_rate_damping.cc"})
    EXPECT_EQ(files.count(file), 0u) << file;
}

TEST_F(ProfileTest, BendingDragAndDampingRunWhereTheSceneHasThem) {
  Json scene = BareScene();
  scene["materials"]["k_bend"] = 1e-4;
  std::set<std::string> files = ExecutedFiles(scene);
  EXPECT_EQ(files.count("bending_energy.cc"), 1u);
  EXPECT_EQ(files.count("bending_patch.cc"), 0u);
  EXPECT_EQ(files.count("air_drag.cc"), 0u);
  scene = BareScene();
  scene["materials"]["drag"] = 0.1;
  files = ExecutedFiles(scene);
  EXPECT_EQ(files.count("bending_energy.cc"), 0u);
  EXPECT_EQ(files.count("air_drag.cc"), 1u);
  EXPECT_EQ(files.count("directional_drag.cc"), 0u);
  EXPECT_EQ(files.count("strain_rate_damping.cc"), 0u);
  scene = BareScene();
  scene["materials"]["drag_normal"] = 0.1;
  files = ExecutedFiles(scene);
  EXPECT_EQ(files.count("air_drag.cc"), 0u);
  EXPECT_EQ(files.count("directional_drag.cc"), 1u);
  scene = BareScene();
  scene["materials"]["damping"] = 0.1;
  files = ExecutedFiles(scene);
  EXPECT_EQ(files.count("bending_energy.cc"), 0u);
  EXPECT_EQ(files.count("air_drag.cc"), 0u);
  EXPECT_EQ(files.count("strain_rate_damping.cc"), 1u);
}

TEST_F(ProfileTest, AnOrthotropicMembraneRunsInPlaceOfTheIsotropicOne) {
  Json scene = BareScene();
  scene["materials"].erase("k_stretch");
  scene["materials"].update({{"membrane", "orthotropic"}, {"k_warp", 100}, {"k_weft", 80}, {"k_shear", 10}});
  ExecutedFiles(scene);
  EXPECT_TRUE(Called("OrthotropicEnergy::AddForce"));
  EXPECT_FALSE(Called("StretchEnergy::AddForce"));
}

}  // namespace
}  // namespace clothid::profile_test

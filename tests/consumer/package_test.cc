// What installation makes: a tree that can be moved, the command, packages for CMake, pkg-config and Debian.
#include <gtest/gtest.h>

#include <algorithm>
#include <filesystem>
#include <map>
#include <regex>
#include <string>
#include <vector>

#include "tests/consumer/consumer_test.h"

namespace clothid {
namespace {

const std::string kPython = CLOTHID_PYTHON;  // empty: the module is not built

class PackageTest : public ConsumerTest {
 protected:
  static std::vector<std::string> Programs() {
    std::vector<std::string> names;
    for (const auto& entry : fs::directory_iterator(fs::path(kPrefix) / "libexec/clothid")) {
      names.push_back(entry.path().filename());
    }
    EXPECT_GE(names.size(), 4u);
    return names;
  }

  // The module of `prefix`, with the libraries of that prefix and no other, gives the estimate of its program.
  void ExpectPythonFits(const std::string& prefix) const {
    WriteScene(SphereJson());
    const std::string command = prefix + "/bin/clothid ";
    Success(command + "simulate --scene scene.json --set k_stretch=70 --output python.motion.bin");
    Success(command + "identify --target python.motion.bin --fit k_stretch --output python");
    WriteBytes(folder() / "fit.py", R"(
import clothid, json
result = clothid.identify(clothid.Motion.load("python.motion.bin"), fit="k_stretch")
with open("python/result.json") as file:
    assert result.values["k_stretch"] == json.load(file)["parameters"]["k_stretch"]["value"], result
print(*sorted({line.split()[-1] for line in open("/proc/self/maps") if "clothid" in line and ".so" in line}), sep="\n")
)");
    const std::string python = "env -i PYTHONPATH='" + prefix + "/lib/python3/dist-packages' '" + kPython + "' -B ";
    std::istringstream loaded(Success(python + "fit.py"));
    int num_libraries = 0;
    for (std::string path; std::getline(loaded, path); ++num_libraries) {
      EXPECT_EQ(path.rfind(fs::canonical(prefix).string(), 0), 0u) << path;
    }
    EXPECT_EQ(num_libraries, 5);
  }

  // Configures a project of `lines` after the usual two, and nothing to build.
  ToolResult Configure(const std::string& lines) const {
    WriteBytes(folder() / "CMakeLists.txt",
               "cmake_minimum_required(VERSION 3.21)\nproject(user LANGUAGES CXX)\n" + lines + "\n");
    return Run(CONFIGURE " -S . -B build -DCMAKE_PREFIX_PATH='" + std::string(kPrefix) + "'");
  }

  void ExpectConfigureRefused(const std::string& lines, const std::vector<std::string>& culprits) const {
    const ToolResult result = Configure(lines);
    EXPECT_NE(result.exit_code, 0);
    // CMake breaks the lines of its messages.
    const std::string message = std::regex_replace(result.err, std::regex("\\s+"), " ");
    for (const std::string& culprit : culprits) {
      EXPECT_NE(message.find(culprit), std::string::npos) << culprit << "\n" << result.err;
    }
  }

  void CompileSyntax(const std::string& source) const {
    WriteBytes(folder() / "source.cc", source);
    Success(COMPILER " -fsyntax-only -Wall -Wextra -Werror source.cc " + PkgConfig("--cflags"));
  }

  // A program that is compiled in no time and runs code of clothid; the examples use more of it.
  void WriteVersionProgram() const {
    WriteBytes(folder() / "version.cc",
               "#include <cstdio>\n#include \"identify/base/version.h\"\n"
               "int main() { std::puts(clothid::Version().c_str()); }\n");
  }
  void ExpectTellsVersion(const std::string& program, const std::string& root) const {
    ExpectLibrariesBelow(program, root, 4);
    EXPECT_EQ(Success("./" + program), CLOTHID_VERSION "\n");
  }

  static std::string PkgConfig(const std::string& what) {
    return "$(PKG_CONFIG_PATH='" + std::string(kPrefix) + "/" CLOTHID_LIBDIR "/pkgconfig' pkg-config " + what +
           " 'clothid >= 0.1')";
  }
};

TEST_F(PackageTest, PrefixMentionsNoBuildOrSourceFolder) {
  for (const char* name : {CLOTHID_SOURCE_DIR, CLOTHID_BINARY_DIR}) {
    const ToolResult result = Run("grep -rlF '" + std::string(name) + "' '" + kPrefix + "'");
    EXPECT_EQ(result.exit_code, 1) << name << " in\n" << result.out << result.err;
  }
}

TEST_F(PackageTest, PrefixWorksWhereverItIsMoved) {
  Success("cp -a '" + std::string(kPrefix) + "' moved && ln -s moved/bin/clothid link");
  const std::string root = fs::canonical(folder() / "moved").string();
  for (const std::string& program : Programs()) {
    const std::size_t count = LoadedLibraries(CLOTHID_BINARY_DIR "/" + program).size();
    EXPECT_GT(count, 0u) << program;
    ExpectLibrariesBelow("moved/libexec/clothid/" + program, root, count);
  }
  EXPECT_EQ(Success("./link --version"), "clothid " CLOTHID_VERSION "\n");
  EXPECT_EQ(Success("cd / && '" + root + "/bin/clothid' identify --version").rfind("identify (clothid)", 0), 0u);
  Success("./link simulate --scene " CLOTHID_SOURCE_DIR "/datasets/slope.scene.json --output out.bin");
  Success("./link motion check out.bin");
  Success("./link simulate --scene moved/share/doc/clothid/datasets/experiments/edge.scene.json --output edge.bin");
}

// Every page of the sources is there, and no link to a file leads nowhere.
TEST_F(PackageTest, PagesAreThereWithWhatTheyLinkTo) {
  const fs::path root = fs::path(kPrefix) / "share/doc/clothid";
  for (const char* name : {"README.md", "CHANGELOG.md", "identify/tutorial.md", "identify/faq.md",
                           "identify/glossary.md", "sim/README.md", "datasets/README.md", "costs/README.md",
                           "identify/README.md", "tools/README.md", "tests/README.md", "datasets/scene.md"}) {
    EXPECT_EQ(ReadBytes(root / name), ReadBytes(fs::path(CLOTHID_SOURCE_DIR) / name)) << name;
  }
  const std::regex link(R"(\]\(([^)#\s]+)(#[^)\s]*)?\))");
  int num_links = 0;
  for (const auto& entry : fs::recursive_directory_iterator(root)) {
    if (entry.path().extension() != ".md") continue;
    const std::string text = ReadBytes(entry.path());
    for (std::sregex_iterator match(text.begin(), text.end(), link), end; match != end; ++match) {
      const std::string target = (*match)[1];
      if (target.find("://") != std::string::npos) continue;
      EXPECT_TRUE(fs::exists(entry.path().parent_path() / target)) << entry.path() << " -> " << target;
      ++num_links;
    }
  }
  EXPECT_GT(num_links, 50);
  const std::string help = Success(std::string(kPrefix) + "/bin/clothid --help");
  EXPECT_NE(help.find("\n  " + fs::canonical(root / "README.md").string() + "\n"), std::string::npos) << help;
}

TEST_F(PackageTest, LibrariesCarryTheVersionOfTheirInterface) {
  for (const std::string component : {"sim", "datasets", "costs", "identify"}) {
    const std::string library = "libclothid_" + component + ".so";
    const fs::path path = fs::path(kPrefix) / CLOTHID_LIBDIR / library;
    EXPECT_EQ(fs::read_symlink(path), library + "." CLOTHID_SOVERSION);
    EXPECT_EQ(fs::canonical(path).filename(), library + "." CLOTHID_VERSION);
    EXPECT_NE(Success("readelf -d '" + path.string() + "'").find("soname: [" + library + "." CLOTHID_SOVERSION "]"),
              std::string::npos);
  }
}

TEST_F(PackageTest, CommandListsItsProgramsAndRefusesOthers) {
  const std::string command = std::string(kPrefix) + "/bin/clothid";
  const std::string help = Success(command + " --help");
  for (const std::string& program : Programs()) {
    EXPECT_NE(help.find("\n  " + program + " "), std::string::npos) << help;
  }
  EXPECT_NE(help.find("  identify    fits friction and stiffness"), std::string::npos) << help;
  ExpectRefused(command + " fit", 1, "unknown command 'fit': expected one of benchmark identify ");
  ExpectRefused(command + " ../../bin/clothid", 1, "unknown command '../../bin/clothid'");
  ExpectRefused(command + " --target", 1, "unknown command '--target'");
  ExpectRefused(command, 1, "no command");
  // The exit code of a program is that of the command.
  ExpectRefused(command + " motion check '" + kExamples + "CMakeLists.txt'", 2, "CMakeLists.txt");
}

// Each header is the first include of its source file, so it compiles alone there; those without a source file and the
// whole set, against nothing but the prefix, are compiled here.
TEST_F(PackageTest, PublicHeadersIncludeOnlyPublicHeaders) {
  const fs::path root = fs::path(kPrefix) / "include/clothid";
  std::string all;
  for (const auto& entry : fs::recursive_directory_iterator(root)) {
    if (!entry.is_regular_file()) continue;
    const fs::path header = fs::relative(entry.path(), root);
    const fs::path origin = fs::path(CLOTHID_SOURCE_DIR) / header;
    const std::string line = "#include \"" + header.string() + "\"\n";
    all += line;
    const bool is_generated = !fs::exists(origin);  // all that it does is to include others
    if (!is_generated && !fs::exists(fs::path(origin).replace_extension(".cc"))) CompileSyntax(line);
  }
  EXPECT_GT(std::count(all.begin(), all.end(), '\n'), 100);
  CompileSyntax(all);
}

TEST_F(PackageTest, HeaderOfAComponentIncludesAllOfIt) {
  const fs::path root = fs::path(kPrefix) / "include/clothid";
  for (const std::string component : {"sim", "datasets", "costs", "identify"}) {
    const std::string text = ReadBytes(root / component / (component + ".h"));
    int num_headers = 0;
    for (const auto& entry : fs::recursive_directory_iterator(root / component)) {
      const fs::path header = fs::relative(entry.path(), root);
      if (!entry.is_regular_file() || !fs::exists(CLOTHID_SOURCE_DIR / header)) continue;
      EXPECT_NE(text.find("#include \"" + header.string() + "\"\n"), std::string::npos) << header;
      ++num_headers;
    }
    EXPECT_GT(num_headers, 5) << component;
  }
  CompileSyntax(
      "#include \"identify/identify.h\"\n"
      "#include \"sim/sim.h\"\n"
      "using clothid::Fit, clothid::PullBack, clothid::PushForward, clothid::Simulate;\n");
}

// Programs written for version 0.1, whose headers stood in no rooms. What is there is compiled above.
TEST_F(PackageTest, HeadersOfVersion01KeepTheirPaths) {
  const fs::path root = fs::path(kPrefix) / "include/clothid";
  const std::map<std::string, std::vector<std::string>> headers = {
      {"sim",
       {"adjoint", "contact", "contact_law", "error", "handle_path", "mesh", "obstacle", "parameters", "phase_seconds",
        "record_reader", "rollout", "scene", "scene_json", "sensitivity", "simulator", "triangulated_surface"}},
      {"datasets",
       {"cloth_surface", "cloud_import", "cloud_observation", "motion_file", "observation", "point_tracks",
        "recorded_motion", "synthetic", "track_file"}},
      {"costs",
       {"alignment", "frame_interpolation", "full_residual_cost", "parameter_block", "pass_step", "recording_model",
        "robust_loss", "rollout_cost", "rollout_cost_options"}},
      {"identify", {"evaluation_progress", "fit",        "fit_landscape", "gradient_check",  "holdout",
                    "interval_check",      "landscape",  "multi_start",   "node_prediction", "options",
                    "output_folder",       "problem",    "profile",       "report",          "report_page",
                    "result_json",         "step_check", "uncertainty",   "verdict",         "version"}}};
  for (const auto& [component, names] : headers) {
    for (const std::string& name : names) EXPECT_TRUE(fs::exists(root / component / (name + ".h"))) << name;
  }
}

TEST_F(PackageTest, OtherVersionsAreRefused) {
  ExpectConfigureRefused("find_package(clothid 9.0 REQUIRED)",
                         {"requested version \"9.0\"", "version: " CLOTHID_VERSION});
  ExpectConfigureRefused("find_package(clothid 0.0 REQUIRED)",
                         {"requested version \"0.0\"", "version: " CLOTHID_VERSION});
}

TEST_F(PackageTest, UnknownComponentIsRefused) {
  ExpectConfigureRefused("find_package(clothid 0.4 REQUIRED COMPONENTS sim rendering)",
                         {"no component 'rendering'", "sim, datasets, costs, identify"});
}

TEST_F(PackageTest, ComponentBringsWhatItNeedsAndNoMore) {
  const ToolResult result = Configure(R"(
    find_package(clothid 0.4 REQUIRED COMPONENTS datasets OPTIONAL_COMPONENTS rendering)
    foreach(target clothid::sim clothid::datasets Eigen3::Eigen)
      if(NOT TARGET ${target})
        message(FATAL_ERROR "${target} is missing")
      endif()
    endforeach()
    foreach(target clothid::costs clothid::identify Ceres::ceres)
      if(TARGET ${target})
        message(FATAL_ERROR "${target} is there")
      endif()
    endforeach()
    if(clothid_rendering_FOUND OR NOT clothid_sim_FOUND OR NOT clothid_datasets_FOUND)
      message(FATAL_ERROR "components")
    endif())");
  EXPECT_EQ(result.exit_code, 0) << result.err;
}

TEST_F(PackageTest, PkgConfig) {
  WriteVersionProgram();
  Success(COMPILER " version.cc -o version " + PkgConfig("--cflags --libs") + " -Wl,-rpath,'" + kPrefix +
          "/" CLOTHID_LIBDIR "'");
  ExpectTellsVersion("version", kPrefix);
}

TEST_F(PackageTest, DebianPackage) {
  if (Run("command -v dpkg-deb && command -v dpkg-shlibdeps").exit_code != 0)
    GTEST_SKIP() << "a package is absent: dpkg or dpkg-dev";
  Success(CPACK " -G DEB --config '" CLOTHID_BINARY_DIR "/CPackConfig.cmake' -B package");
  const std::string control = Success("dpkg-deb --info package/clothid_*.deb");
  for (const char* line : {"Package: clothid\n", "Version: " CLOTHID_VERSION, "libcholmod", "libopenblas0-pthread",
                           "Recommends: libceres-dev, libeigen3-dev\n", "binaries are under the GPL"}) {
    EXPECT_NE(control.find(line), std::string::npos) << line << "\n" << control;
  }
  Success("mkdir root && dpkg-deb -x package/clothid_*.deb root");
  EXPECT_EQ(Run("test -e root/usr/bin/identify").exit_code, 1);
  EXPECT_EQ(Run("test -s root/usr/share/doc/clothid/identify/tutorial.md").exit_code, 0);
  const std::string root = fs::canonical(folder() / "root").string();
  EXPECT_EQ(Success("root/usr/bin/clothid identify --version").rfind("identify (clothid)", 0), 0u);
  ExpectLibrariesBelow("root/usr/libexec/clothid/identify", root, 4);
  EXPECT_EQ(Success("readelf --sections root/usr/libexec/clothid/identify").find(".debug_info"), std::string::npos);
  WriteVersionProgram();
  WriteBytes(folder() / "CMakeLists.txt",
             "cmake_minimum_required(VERSION 3.21)\nproject(user LANGUAGES CXX)\n"
             "find_package(clothid REQUIRED)\nadd_executable(version version.cc)\n"
             "target_link_libraries(version clothid::identify)\n");
  Success(CONFIGURE " -S . -B build -DCMAKE_PREFIX_PATH='" + root + "/usr' && " BUILD " build");
  ExpectTellsVersion("build/version", root);
  if (kPython.empty()) return;
  const std::string of_python = Success("dpkg-deb --info package/python3-clothid_*.deb");
  for (const char* line : {"Package: python3-clothid\n", "clothid (= " CLOTHID_VERSION ")", "python3-numpy"}) {
    EXPECT_NE(of_python.find(line), std::string::npos) << line << "\n" << of_python;
  }
  EXPECT_EQ(Run("test -e root/usr/lib/python3").exit_code, 1);
  Success("dpkg-deb -x package/python3-clothid_*.deb root");
  ExpectPythonFits(root + "/usr");
}

TEST_F(PackageTest, PythonFindsItsLibrariesInAPrefix) {
  if (kPython.empty()) GTEST_SKIP() << "the Python module is not built";
  ExpectPythonFits(kPrefix);
}

}  // namespace
}  // namespace clothid

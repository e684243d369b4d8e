// Runs the GoogleTest cases of a program, as gtest_main does. `--list_for_ctest=FILE` writes CTest's script about them
// instead: a program holds the cases of several files, and the test of a case is named after its file.
#include <gtest/gtest.h>

#include <cstdio>
#include <filesystem>
#include <fstream>
#include <string>
#include <string_view>

namespace {

// "sim/scene/mesh_test" of "tests/sim/scene/mesh_test.cc", whatever stands before that.
std::string NameOfFile(const std::string& path) {
  constexpr std::string_view kFolder = "tests/";
  const std::size_t start = path.rfind(kFolder);
  const std::string name = start == std::string::npos ? path : path.substr(start + kFolder.size());
  return std::filesystem::path(name).replace_extension().string();
}

// A literal of CMake.
std::string Quoted(const std::string& text) { return "[==[" + text + "]==]"; }

// Adds a test of all cases that `filter` takes, with the properties LABELS and COST from the variables label_<file> and
// cost_<file>.
void WriteTest(const std::string& program, const std::string& file, const std::string& filter, const std::string& name,
               std::ostream& script) {
  const std::string test = Quoted(file + "." + name);
  script << "add_test(" << test << " " << Quoted(program) << " " << Quoted("--gtest_filter=" + filter) << ")\n"
         << "set_tests_properties(" << test << " PROPERTIES LABELS \"${label_" << file << "}\" COST \"${cost_" << file
         << "}\" SKIP_REGULAR_EXPRESSION " << Quoted("\\[  SKIPPED \\]") << ")\n";
}

// Adds every case as a test, or the cases of a suite as one where the variable as_one_<file> is set.
void WriteList(const std::string& program, std::ostream& script) {
  const ::testing::UnitTest& all = *::testing::UnitTest::GetInstance();
  for (int i = 0; i < all.total_test_suite_count(); ++i) {
    const ::testing::TestSuite& suite = *all.GetTestSuite(i);
    const std::string suite_name = suite.name(), file = NameOfFile(suite.GetTestInfo(0)->file());
    script << "if(as_one_" << file << ")\n";
    WriteTest(program, file, suite_name + ".*", suite_name, script);
    script << "else()\n";
    for (int j = 0; j < suite.total_test_count(); ++j) {
      const std::string name = suite_name + "." + suite.GetTestInfo(j)->name();
      WriteTest(program, NameOfFile(suite.GetTestInfo(j)->file()), name, name, script);
    }
    script << "endif()\n";
  }
}

}  // namespace

int main(int argc, char** argv) {
  ::testing::InitGoogleTest(&argc, argv);
  constexpr std::string_view kList = "--list_for_ctest=";
  if (argc != 2 || std::string_view(argv[1]).substr(0, kList.size()) != kList) return RUN_ALL_TESTS();
  const std::string path = argv[1] + kList.size();
  std::ofstream script(path);
  WriteList(std::filesystem::absolute(argv[0]).string(), script);
  script.close();
  if (!script) std::fprintf(stderr, "%s cannot be written\n", path.c_str());
  return script ? 0 : 1;
}

// The pictures: complete, one file, nothing asked of any server, names shown and never run.
#include "tools/landscape/landscape_plot.h"

#include <gtest/gtest.h>
#include <signal.h>

#include <algorithm>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <nlohmann/json.hpp>
#include <regex>
#include <string>
#include <string_view>

#include "identify/report/vendor/plotly.h"
#include "tests/expect_error.h"
#include "tests/optional_package.h"
#include "tests/temporary_folder.h"
#include "tests/tools/landscape/bumpy_landscape.h"
#include "tools/base/run_program.h"

namespace clothid::landscape_plot_test {
namespace {

constexpr char kHostileName[] = "</script><img src=x onerror=\"alert(1)\">";

std::string ReadBytes(const std::string& path) {
  std::ifstream file(path, std::ios::binary);
  EXPECT_TRUE(file) << path;
  return {std::istreambuf_iterator<char>(file), std::istreambuf_iterator<char>()};
}

Landscape WithHoles() {
  Landscape landscape = BumpyLandscape({"ball.center.x=0.05", kHostileName}, {1.0, 0.1}, 9);
  FailCell(landscape.plan.FirstCell(1, 0) + 40, "step 3 <did> not converge", &landscape);
  return landscape;
}

// The page without the library and its licences, whose own texts mention addresses.
std::string OwnText(std::string html) {
  for (const std::string_view foreign : {PlotlyLibrary(), PlotlyLicences()}) {
    EXPECT_NE(html.find(foreign), std::string::npos);
    EXPECT_EQ(foreign.find("</script"), std::string::npos);
    html.erase(html.find(foreign), foreign.size());
  }
  return html;
}

nlohmann::json DataOf(const std::string& html) {
  const std::string tag = "<script type=\"application/json\" id=\"data\">";
  const std::size_t start = html.find(tag) + tag.size();
  return nlohmann::json::parse(html.substr(start, html.find("</script>", start) - start));
}

TEST(LandscapeHtml, HoldsEveryWindowOfEverySetting) {
  const Landscape landscape = WithHoles();
  const nlohmann::json data = DataOf(LandscapeHtml({landscape, {}}, Summarize(landscape)));
  ASSERT_EQ(data["summary"]["settings"].size(), 4u);
  EXPECT_EQ(data["summary"]["settings"][0]["name"], "ball.center.x=0.05");
  EXPECT_EQ(data["summary"]["settings"][3]["name"], kHostileName);
  ASSERT_EQ(data["cells"].size(), 8u);
  for (int setting = 0; setting < 4; ++setting) {
    for (int window = 0; window < 2; ++window) {
      const nlohmann::json& cells = data["cells"][setting * 2 + window];
      ASSERT_EQ(cells["cost"].size(), 81u);
      for (int i = 0; i < 81; ++i) {
        const LandscapeCell& cell = landscape.cells[landscape.plan.FirstCell(setting, window) + i];
        if (!cell.failure.empty()) {
          EXPECT_TRUE(cells["cost"][i].is_null());
          EXPECT_EQ(cells["failure"][std::to_string(i)], cell.failure);
          continue;
        }
        EXPECT_NEAR(cells["cost"][i].get<double>(), cell.cost, 1e-11 * cell.cost);
        EXPECT_EQ(cells["changes"][i], cell.counts.contact_changes());
      }
      EXPECT_EQ(cells["gradient_y"].size(), 81u);
    }
  }
  EXPECT_EQ(data["y"][1][8], landscape.plan.windows[1].y.upper);
}

TEST(LandscapeHtml, IsOneFile) {
  const Landscape landscape = WithHoles();
  const std::string own = OwnText(LandscapeHtml({landscape, {}}, Summarize(landscape)));
  EXPECT_EQ(own.find("http:"), std::string::npos);
  EXPECT_EQ(own.find("https:"), std::string::npos);
  EXPECT_FALSE(std::regex_search(own, std::regex("<(script|link|iframe|img)[^>]*(src|href)", std::regex::icase)));
  EXPECT_NE(own.find("content=\"default-src 'none'"), std::string::npos);
  EXPECT_EQ(own.find("{{"), std::string::npos);
}

TEST(LandscapeHtml, NamesCannotEndTheirScript) {
  const Landscape landscape = WithHoles();
  const std::string own = OwnText(LandscapeHtml({landscape, {}}, Summarize(landscape)));
  EXPECT_EQ(own.find("<img"), std::string::npos);
  EXPECT_EQ(own.find("<did>"), std::string::npos);
  const std::regex tag("<script|</script>");
  EXPECT_EQ(std::distance(std::sregex_iterator(own.begin(), own.end(), tag), std::sregex_iterator()), 10);
}

TEST(LandscapeHtml, WithoutGradientsThereAreNone) {
  Landscape landscape = WithHoles();
  landscape.plan.has_gradients = false;
  const nlohmann::json data = DataOf(LandscapeHtml({landscape, {}}, Summarize(landscape)));
  EXPECT_EQ(data["cells"][0].count("gradient_x"), 0u);
  EXPECT_TRUE(data["summary"]["settings"][0]["windows"][0]["roughness"]["gradient_gap"].is_null());
}

TEST(PlotLandscape, WritesBothPictures) {
  const TemporaryFolder folder;
  const Landscape landscape = WithHoles();
  const LandscapeSummary summary = Summarize(landscape);
  folder.Write("landscape.csv", BumpyCsv(landscape));
  folder.Write("summary.json", SummaryJson(summary));
  const LandscapePictures pictures = PlotLandscape({landscape, {}}, summary, folder.path());
  EXPECT_EQ(pictures.html, folder.File("landscape.html"));
  EXPECT_EQ(ReadBytes(pictures.html), LandscapeHtml({landscape, {}}, summary));
  const std::string unusable = WhyNoPythonModule("python3-matplotlib", "matplotlib.pyplot");
  if (!unusable.empty()) {
    EXPECT_EQ(pictures.note.find("landscape.png is left out: "), 0u) << pictures.note;
    GTEST_SKIP() << unusable;
  }
  ASSERT_EQ(pictures.note, "");
  EXPECT_EQ(pictures.png, folder.File("landscape.png"));
  EXPECT_EQ(ReadBytes(pictures.png).substr(0, 8), "\x89PNG\r\n\x1a\n");
  const std::filesystem::directory_iterator files(folder.path());
  EXPECT_EQ(std::distance(begin(files), end(files)), 4);  // nothing else
}

// A picture of another scan would be taken for one of this.
TEST(PlotLandscape, ALeftOutPictureLeavesNoOlderOne) {
  const TemporaryFolder folder;
  const Landscape landscape = WithHoles();
  folder.Write("landscape.png", "of another scan");
  const LandscapePictures pictures =
      PlotLandscape({landscape, {}}, Summarize(landscape), folder.path());  // no landscape.csv
  EXPECT_EQ(pictures.png, "");
  EXPECT_EQ(pictures.note.find("landscape.png is left out: "), 0u) << pictures.note;
  EXPECT_EQ(std::count(pictures.note.begin(), pictures.note.end(), '\n'), 0) << pictures.note;
  const std::filesystem::directory_iterator files(folder.path());
  EXPECT_EQ(std::distance(begin(files), end(files)), 1);
}

// The first python3 lacks matplotlib, which is not why there is no picture.
TEST(PlotLandscape, SaysWhichFileIsDamaged) {
  const std::string unusable = WhyNoPythonModule("python3-matplotlib", "matplotlib.pyplot");
  if (!unusable.empty()) GTEST_SKIP() << unusable;
  const TemporaryFolder folder, programs;
  std::filesystem::permissions(programs.Write("python3", "#!/bin/sh\necho 'no matplotlib' >&2\nexit 3\n"),
                               std::filesystem::perms::owner_all);
  const std::string path = std::getenv("PATH");
  setenv("PATH", (programs.path() + ":" + path).c_str(), 1);
  const Landscape landscape = WithHoles();
  const LandscapeSummary summary = Summarize(landscape);
  folder.Write("landscape.csv", BumpyCsv(landscape));
  for (const std::string& text : {std::string("{"), std::string("[]"), std::string("{\"settings\": []}"),
                                  SummaryJson(summary).replace(SummaryJson(summary).find("minimum"), 7, "maximum")}) {
    folder.Write("summary.json", text);
    const std::string note = PlotLandscape({landscape, {}}, summary, folder.path()).note;
    EXPECT_NE(note.find("summary.json is damaged: "), std::string::npos) << note;
  }
  setenv("PATH", path.c_str(), 1);
}

TEST(PlotLandscape, AFolderThatIsAFile) {
  const TemporaryFolder folder;
  const Landscape landscape = WithHoles();
  const std::string path = folder.Write("file", "");
  ExpectError([&] { PlotLandscape({landscape, {}}, Summarize(landscape), path); }, ErrorKind::kIo, {"file"});
}

TEST(OptionalPackage, IsPresentAbsentOrDamaged) {
  EXPECT_EQ(WhyNoPythonModule("python3", "os.path"), "");
  EXPECT_EQ(WhyNoPythonModule("python3-nothing", "no_such_module.part"), "the package python3-nothing is absent");
  const TemporaryFolder folder;
  folder.Write("broken_module.py", "import no_such_module\n");
  ::setenv("PYTHONPATH", folder.path().c_str(), 1);
  EXPECT_EQ(WhyNoPythonModule("python3-broken", "broken_module"),
            "the package python3-broken is damaged: ModuleNotFoundError: No module named 'no_such_module'");
  ::unsetenv("PYTHONPATH");
}

TEST(RunProgram, ExitCodeAndMessages) {
  const ProgramResult result = RunProgram({"sh", "-c", "echo out; echo \"$0\" >&2; exit 3", "it's \"one\" argument"});
  EXPECT_EQ(result.exit_code, 3);
  EXPECT_EQ(result.err, "it's \"one\" argument\n");
  EXPECT_EQ(RunProgram({"sh", "-c", "kill -9 $$"}).exit_code, 128 + 9);
  EXPECT_EQ(RunProgram({"no-such-program-anywhere"}).exit_code, 127);
  sigset_t signals, before;
  sigemptyset(&signals);
  sigaddset(&signals, SIGTERM);
  pthread_sigmask(SIG_BLOCK, &signals, &before);
  EXPECT_EQ(RunProgram({"sh", "-c", "kill -TERM $$; exit 3"}).exit_code, 128 + SIGTERM) << "blocked here, not there";
  pthread_sigmask(SIG_SETMASK, &before, nullptr);
}

}  // namespace
}  // namespace clothid::landscape_plot_test

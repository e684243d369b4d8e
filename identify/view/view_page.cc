#include "identify/view/view_page.h"

#include <string_view>

#include "datasets/files/atomic_file.h"
#include "identify/report/page_template.h"
#include "identify/report/report_page.h"
#include "identify/view/view_data.h"
#include "sim/base/error.h"
#include "sim/base/text_file.h"

namespace clothid {

// Files embedded by CMake.
std::string_view ViewPage();      // view_page.html
std::string_view ReplayScript();  // the scripts that draw and play a replay
std::string_view ViewScript();    // those of all else

std::string ViewHtml(const RecordedMotion& motion, bool is_simulated) {
  const std::size_t page_bytes =
      PageStyle().size() + PageScript().size() + ReplayScript().size() + ViewPage().size() + ViewScript().size();
  const std::string data = ScriptText(ViewData(motion, is_simulated, kMaxReportBytes - page_bytes));
  return FillPage(ViewPage(), {{"{{style}}", PageStyle()},
                               {"{{data}}", data},
                               {"{{page}}", PageScript()},
                               {"{{replay}}", ReplayScript()},
                               {"{{script}}", ViewScript()}});
}

void CheckPageOutput(const std::string& flag, const std::string& path) {
  constexpr std::string_view kEnding = ".html";
  const bool is_page = path.size() > kEnding.size() && path.substr(path.size() - kEnding.size()) == kEnding;
  if (!is_page && !IsStream(path)) {
    throw Error(ErrorKind::kUsage, flag + ": expected a name that ends in .html, got '" + Printable(path) + "'");
  }
  CheckFileCanBeWritten(path);
}

}  // namespace clothid

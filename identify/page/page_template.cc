#include "identify/page/page_template.h"

#include <array>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <stdexcept>

#include "identify/report/vendor/plotly.h"

namespace clothid {

// What all pages have, embedded by CMake: page_frame.html, page_style.css, and page_text.js and page_plot.js.
std::string_view PageFrame();
std::string_view PageStyle();
std::string_view PageScript();

std::string ScriptText(const nlohmann::ordered_json& json) {
  std::string text;
  for (const char letter : json.dump(-1, ' ', false, nlohmann::ordered_json::error_handler_t::replace)) {
    text += letter == '<' ? "\\u003c" : std::string(1, letter);
  }
  return text;
}

nlohmann::ordered_json RoundedJson(double value, int digits) {
  if (!std::isfinite(value)) return nullptr;
  std::array<char, 32> text;
  std::snprintf(text.data(), text.size(), "%.*g", digits, value);
  return std::strtod(text.data(), nullptr);
}

nlohmann::ordered_json RoundedJson(const Eigen::VectorXd& values, int digits) {
  nlohmann::ordered_json json = nlohmann::ordered_json::array();
  for (const double value : values) json.push_back(RoundedJson(value, digits));
  return json;
}

std::string FillPage(std::string_view page, std::initializer_list<PageMark> marks) {
  std::string filled;
  for (const PageMark& mark : marks) {
    const std::size_t end = page.find(mark.mark);
    if (end == std::string_view::npos) throw std::logic_error("a page without " + std::string(mark.mark));
    filled += page.substr(0, end);
    filled += mark.text;
    page.remove_prefix(end + mark.mark.size());
  }
  filled += page;
  return filled;
}

std::string MakePage(const PageParts& parts, std::string_view data) {
  const auto script = [](std::string_view text) { return "<script>" + std::string(text) + "</script>\n"; };
  const std::string style = std::string(PageStyle()) + std::string(parts.style);
  std::string libraries, scripts;
  if (parts.has_charts) {
    libraries = "<script type=\"text/plain\" id=\"licences\">" + std::string(PlotlyLicences()) + "</script>\n" +
                script(PlotlyLibrary());
  }
  for (const std::string_view text : parts.scripts) scripts += script(text);
  return FillPage(PageFrame(), {{"{{title}}", parts.title},
                                {"{{style}}", style},
                                {"{{body}}", parts.body},
                                {"{{data}}", data},
                                {"{{libraries}}", libraries},
                                {"{{page}}", PageScript()},
                                {"{{scripts}}", scripts}});
}

}  // namespace clothid

#include "identify/report/page_template.h"

#include <array>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <stdexcept>

namespace clothid {

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

}  // namespace clothid

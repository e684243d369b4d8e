// Pages that our programs write: a file with marks, data as JSON inside of it.
#ifndef CLOTHID_IDENTIFY_PAGE_PAGE_TEMPLATE_H_
#define CLOTHID_IDENTIFY_PAGE_PAGE_TEMPLATE_H_

#include <Eigen/Core>
#include <initializer_list>
#include <nlohmann/json.hpp>
#include <string>
#include <string_view>
#include <vector>

namespace clothid {

// JSON that can stand inside of a <script>: in JSON "<" occurs in strings alone, and there it may be written otherwise.
// What is not UTF-8 is replaced.
std::string ScriptText(const nlohmann::ordered_json& json);

// `value` rounded to `digits` digits, enough to look at and a third shorter than all; NaN and infinity as null.
nlohmann::ordered_json RoundedJson(double value, int digits);
nlohmann::ordered_json RoundedJson(const Eigen::VectorXd& values, int digits);  // a list

// A mark of a page, such as "{{data}}", and what stands in its place.
struct PageMark {
  std::string_view mark, text;
};

// `page` with its marks replaced, in the order in which they stand there. Texts are not searched for marks. Throws
// `std::logic_error` where a mark is missing.
std::string FillPage(std::string_view page, std::initializer_list<PageMark> marks);

// What differs between our pages.
struct PageParts {
  std::string_view title, body;           // the texts of <title> and, but for its scripts, <body>
  std::string_view style = {};            // beside that of all pages
  bool has_charts = false;                // comes with Plotly and its licences
  std::vector<std::string_view> scripts;  // behind those of all pages
};

// The page (page_frame.html) that holds `data`, a `ScriptText`.
std::string MakePage(const PageParts& parts, std::string_view data);

}  // namespace clothid

#endif  // CLOTHID_IDENTIFY_PAGE_PAGE_TEMPLATE_H_

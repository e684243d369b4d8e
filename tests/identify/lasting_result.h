// The files of a result without what no two runs share.
#ifndef CLOTHID_TESTS_IDENTIFY_LASTING_RESULT_H_
#define CLOTHID_TESTS_IDENTIFY_LASTING_RESULT_H_

#include <filesystem>
#include <fstream>
#include <iterator>
#include <map>
#include <regex>
#include <string>

namespace clothid {

// Without the seconds, and without the flags, of which --resume is one.
inline std::string Lasting(const std::string& name, const std::string& content) {
  const std::regex passing("\"seconds\": \\{[^}]*\\}|\"flags\": \"[^\"]*\"");
  if (name == "result.json") return std::regex_replace(content, passing, "");
  if (name == "report.html") {
    const std::regex passing_here("\"seconds\":(\\{[^}]*\\}|\\[[^\\]]*\\])|\"flags\":\"[^\"]*\"");
    const std::size_t data = content.find("id=\"data\">"), end = content.find("\"recordings\":", data);
    return content.substr(0, data) + std::regex_replace(content.substr(data, end - data), passing_here, "") +
           content.substr(end);
  }
  if (name == "convergence.csv") return std::regex_replace(content, std::regex("(^|\n)([^,\n]*),[^,\n]*,"), "$1$2,,");
  return content;
}

inline std::map<std::string, std::string> ReadLastingResult(const std::filesystem::path& folder) {
  std::map<std::string, std::string> files;
  for (const auto& entry : std::filesystem::directory_iterator(folder)) {
    const std::string name = entry.path().filename();
    std::ifstream file(entry.path(), std::ios::binary);
    files[name] = Lasting(name, {std::istreambuf_iterator<char>(file), std::istreambuf_iterator<char>()});
  }
  return files;
}

}  // namespace clothid

#endif  // CLOTHID_TESTS_IDENTIFY_LASTING_RESULT_H_

#include "identify/verdict/reason.h"

#include <utility>

#include "identify/base/knot_names.h"

namespace clothid {

Reason Remark(const std::string& line, std::vector<int> parameters) {
  return {Usability::kUsable, kExitSuccess, std::move(parameters), "", line};
}

Reason Careful(std::vector<int> parameters, const std::string& brief, const std::string& line) {
  return {Usability::kWithCare, kExitSuccess, std::move(parameters), brief, line};
}

Reason AgainstAll(bool is_grave, const std::string& brief, const std::string& line) {
  return is_grave ? Reason{Usability::kDoNotUse, kExitDoNotUse, {}, brief, line} : Careful({}, brief, line);
}

Reason NotTold(std::vector<int> parameters, const std::string& brief, const std::string& line) {
  return {Usability::kDoNotUse, kExitNotIdentifiable, std::move(parameters), brief, line};
}

std::string ValuesText(const FitSummary& summary, const Eigen::VectorXd& values) {
  std::string text;
  for (std::size_t i = 0; i < summary.parameters.size(); ++i) {
    if (summary.parameters[i].frozen) continue;
    text += (text.empty() ? "" : ", ") + summary.parameters[i].name + " " +
            NumberText(values[static_cast<Eigen::Index>(i)]);
  }
  return text;
}

std::string NamesText(const FitSummary& summary, const std::vector<int>& parameters) {
  std::vector<std::string> names;
  for (const int i : parameters) names.push_back(summary.parameters[i].name);
  return JoinWords(WithKnotRuns(names));
}

}  // namespace clothid

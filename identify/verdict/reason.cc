#include "identify/verdict/reason.h"

#include <iomanip>
#include <sstream>

#include "identify/base/join_words.h"
#include "identify/base/knot_names.h"

namespace clothid {

std::string NumberText(double value, int digits) {
  std::ostringstream text;
  text << std::setprecision(digits) << value;
  return text.str();
}

std::string MillimetreText(double metres) { return NumberText(1e3 * metres) + " mm"; }

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

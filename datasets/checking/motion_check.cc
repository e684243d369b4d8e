#include "datasets/checking/motion_check.h"

#include <algorithm>
#include <iomanip>
#include <nlohmann/json.hpp>
#include <sstream>

#include "datasets/checking/check_clouds.h"
#include "datasets/checking/check_coverage.h"
#include "datasets/checking/check_edges.h"
#include "datasets/checking/check_fall.h"
#include "datasets/checking/check_handles.h"
#include "datasets/checking/check_points.h"
#include "datasets/checking/check_scene.h"
#include "datasets/checking/check_start.h"
#include "datasets/checking/checked_motion.h"

namespace clothid {
namespace {

// The words of `text`, in lines of at most `width` characters.
std::vector<std::string> Wrapped(const std::string& text, std::size_t width) {
  std::vector<std::string> lines = {""};
  std::istringstream words(text);
  for (std::string word; words >> word;) {
    if (!lines.back().empty() && lines.back().size() + 1 + word.size() > width) lines.emplace_back();
    lines.back() += (lines.back().empty() ? "" : " ") + word;
  }
  return lines;
}

// Handles, obstacles, gravity.
std::vector<Finding> CheckAgainstScene(const CheckedMotion& checked) {
  std::vector<Finding> findings = CheckHandles(checked);
  const Touch touch = FindTouch(checked);
  for (const std::vector<Finding>& more :
       {CheckObstaclePaths(checked), CheckContact(checked, touch), CheckSelfContact(checked),
        CheckGravity(checked, touch), CheckFall(checked, touch.num_free)}) {
    findings.insert(findings.end(), more.begin(), more.end());
  }
  return findings;
}

}  // namespace

std::vector<Finding> CheckMotion(const RecordedMotion& motion) {
  const CheckedMotion checked(motion);
  std::vector<Finding> findings;
  const auto add = [&](const std::vector<Finding>& more) { findings.insert(findings.end(), more.begin(), more.end()); };
  if (motion.num_points() > 0) {
    add(CheckCoverage(checked));
    const Finding edges = CheckEdges(checked);
    if (Worst(findings) == Severity::kProblem || edges.severity == Severity::kProblem) {
      if (edges.severity == Severity::kProblem) add({edges});
      add({CheckTimeStep(checked)});
      return findings;
    }
    const Finding order = CheckOrder(checked);
    add({CheckNoise(checked), order});
    add(CheckJumps(checked, order.frames));
    add({edges});
    if (edges.severity < Severity::kWarning) add(CheckPlaces(checked));
    add(CheckFirstFrame(checked));
  } else {
    add(CheckTimes(checked));
  }
  add(CheckClouds(checked));
  if (Worst(findings) < Severity::kProblem) add(CheckAgainstScene(checked));
  add(CheckForces(checked));
  add(CheckConstants(checked));
  add({CheckTimeStep(checked)});
  return findings;
}

Severity Worst(const std::vector<Finding>& findings) {
  Severity worst = Severity::kOk;
  for (const Finding& finding : findings) worst = std::max(worst, finding.severity);
  return worst;
}

std::string FindingsTable(const std::vector<Finding>& findings) {
  constexpr int kSeverityWidth = 9;
  constexpr std::size_t kTextWidth = 88;
  std::size_t what_width = 22;
  for (const Finding& finding : findings) what_width = std::max(what_width, finding.what.size() + 1);
  std::ostringstream table;
  table << std::left;
  for (const Finding& finding : findings) {
    table << std::setw(static_cast<int>(what_width)) << finding.what << std::setw(kSeverityWidth)
          << SeverityName(finding.severity);
    std::vector<std::string> lines = Wrapped(finding.value, kTextWidth);
    if (!finding.hint.empty()) {
      for (const std::string& line : Wrapped("-> " + finding.hint, kTextWidth)) lines.push_back(line);
    }
    for (std::size_t i = 0; i < lines.size(); ++i) {
      table << (i == 0 ? "" : std::string(what_width + kSeverityWidth, ' ')) << lines[i] << "\n";
    }
  }
  return table.str();
}

std::string FindingsJson(const std::vector<Finding>& findings, const std::string& file) {
  nlohmann::ordered_json list = nlohmann::ordered_json::array();
  for (const Finding& finding : findings) {
    list.push_back({{"what", finding.what},
                    {"verdict", SeverityName(finding.severity)},
                    {"value", finding.value},
                    {"hint", finding.hint},
                    {"frames", finding.frames},
                    {"points", finding.points}});
  }
  const nlohmann::ordered_json report = {
      {"schema", "clothid.check/1"}, {"file", file}, {"verdict", SeverityName(Worst(findings))}, {"findings", list}};
  return report.dump(2, ' ', false, nlohmann::ordered_json::error_handler_t::replace) + "\n";
}

}  // namespace clothid

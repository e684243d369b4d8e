#include "identify/verdict/verdict.h"

#include <algorithm>
#include <map>

#include "identify/verdict/reason.h"

namespace clothid {
namespace {

// The order of exit codes where several apply.
int Rank(ExitCode exit_code) {
  const std::vector<ExitCode> order = {kExitInterrupted,     kExitNotConverged,  kExitDoNotUse,
                                       kExitNotIdentifiable, kExitHoldoutFailed, kExitSuccess};
  return static_cast<int>(std::find(order.begin(), order.end(), exit_code) - order.begin());
}

bool IsGraver(const Reason& a, const Reason& b) {
  if (a.exit_code != b.exit_code) return Rank(a.exit_code) < Rank(b.exit_code);
  return a.usability > b.usability;
}

void AddReasonsOfFit(const FitSummary& summary, const FitChecks& checks, std::vector<Reason>* reasons) {
  AddModelErrorReasons(summary, checks, reasons);
  AddMeasuredReasons(summary, reasons);
  AddDentReasons(summary, checks, reasons);
  AddFitReasons(summary, checks, reasons);
  AddParameterReasons(summary, checks, reasons);
  AddPriorReasons(summary, reasons);
  AddDiscretizationReasons(summary, checks, reasons);
  AddCheckReasons(summary, checks, reasons);
}

std::vector<Reason> FindReasons(const FitSummary& summary, const FitChecks& checks) {
  std::vector<Reason> reasons;
  AddRepetitionReasons(summary, checks, &reasons);  // first: among reasons of one weight they lead
  const bool has_fit = !checks.repetitions || !checks.repetitions->is_of_folders;
  if (has_fit) AddReasonsOfFit(summary, checks, &reasons);
  std::stable_sort(reasons.begin(), reasons.end(), IsGraver);
  return reasons;
}

bool SpeaksOf(const Reason& reason, int index) {
  return reason.parameters.empty() ||
         std::find(reason.parameters.begin(), reason.parameters.end(), index) != reason.parameters.end();
}

std::vector<Usability> JudgeParameters(const FitSummary& summary, const std::vector<Reason>& reasons) {
  std::vector<Usability> parameters(summary.parameters.size(), Usability::kUsable);
  for (int i = 0; i < static_cast<int>(parameters.size()); ++i) {
    if (summary.parameters[i].frozen) continue;
    for (const Reason& reason : reasons) {
      if (SpeaksOf(reason, i)) parameters[i] = std::max(parameters[i], reason.usability);
    }
  }
  return parameters;
}

// The parameters of one usability that are not frozen.
std::vector<int> Having(const FitSummary& summary, const std::vector<Usability>& parameters, Usability usability) {
  std::vector<int> having;
  for (int i = 0; i < static_cast<int>(parameters.size()); ++i) {
    if (!summary.parameters[i].frozen && parameters[i] == usability) having.push_back(i);
  }
  return having;
}

// "k_bend (at its bound), mu and drag (not told by the recording)"
std::string ForbiddenText(const FitSummary& summary, const std::vector<Reason>& reasons,
                          const std::vector<int>& forbidden) {
  std::vector<std::string> briefs;
  std::map<std::string, std::vector<int>> parameters_of;
  for (const int i : forbidden) {
    const auto reason = std::find_if(reasons.begin(), reasons.end(), [&](const Reason& candidate) {
      return candidate.usability == Usability::kDoNotUse && SpeaksOf(candidate, i);
    });
    std::vector<int>& parameters = parameters_of[reason->brief];
    if (parameters.empty()) briefs.push_back(reason->brief);
    parameters.push_back(i);
  }
  std::string text;
  for (const std::string& brief : briefs) {
    text += (text.empty() ? "" : ", ") + NamesText(summary, parameters_of[brief]) + " (" + brief + ")";
  }
  return text;
}

// What asks for care with any of `parameters`, the first two of it.
std::string CareText(const std::vector<Reason>& reasons, const std::vector<int>& parameters) {
  constexpr std::size_t kShown = 2;
  std::vector<std::string> briefs;
  for (const Reason& reason : reasons) {
    const bool concerns = std::any_of(parameters.begin(), parameters.end(), [&](int i) { return SpeaksOf(reason, i); });
    if (reason.usability != Usability::kWithCare || !concerns) continue;
    if (std::find(briefs.begin(), briefs.end(), reason.brief) == briefs.end()) briefs.push_back(reason.brief);
  }
  std::string text;
  for (std::size_t i = 0; i < std::min(kShown, briefs.size()); ++i) text += (i > 0 ? "; " : "") + briefs[i];
  if (briefs.size() > kShown) text += "; and " + std::to_string(briefs.size() - kShown) + " more";
  return text;
}

// Where nothing asks for care.
std::string UsableText(const FitChecks& checks) {
  if (!checks.repetitions) return "usable: every fitted parameter is identifiable";
  return "usable: recordings differ by no more than their intervals say";
}

std::string OverallLine(const FitSummary& summary, const FitChecks& checks, const std::vector<Reason>& reasons,
                        const std::vector<Usability>& parameters) {
  const auto against_all = std::find_if(reasons.begin(), reasons.end(), [](const Reason& reason) {
    return reason.usability == Usability::kDoNotUse && reason.parameters.empty();
  });
  if (against_all != reasons.end()) return "do not use: " + against_all->brief;
  const std::vector<int> forbidden = Having(summary, parameters, Usability::kDoNotUse);
  const std::vector<int> careful = Having(summary, parameters, Usability::kWithCare);
  const std::vector<int> usable = Having(summary, parameters, Usability::kUsable);
  if (forbidden.empty() && careful.empty()) return UsableText(checks);
  if (forbidden.empty()) return "usable with care: " + CareText(reasons, careful);
  std::string line = "do not use " + ForbiddenText(summary, reasons, forbidden);
  if (!usable.empty()) line += "; usable: " + NamesText(summary, usable);
  if (!careful.empty()) line += "; with care: " + NamesText(summary, careful) + " (" + CareText(reasons, careful) + ")";
  return line;
}

// Where some parameters cannot be used and others can, the answer as a whole asks for care.
Usability Overall(const FitSummary& summary, const std::vector<Usability>& parameters) {
  const auto has = [&](Usability usability) { return !Having(summary, parameters, usability).empty(); };
  if (!has(Usability::kWithCare) && !has(Usability::kUsable)) return Usability::kDoNotUse;
  return has(Usability::kDoNotUse) || has(Usability::kWithCare) ? Usability::kWithCare : Usability::kUsable;
}

}  // namespace

std::vector<std::string> Verdict::Lines() const {
  std::vector<std::string> lines = {line};
  lines.insert(lines.end(), reasons.begin(), reasons.end());
  return lines;
}

Verdict Judge(const FitSummary& summary, const FitChecks& checks) {
  const std::vector<Reason> reasons = FindReasons(summary, checks);
  Verdict verdict;
  verdict.parameters = JudgeParameters(summary, reasons);
  verdict.overall = Overall(summary, verdict.parameters);
  verdict.line = OverallLine(summary, checks, reasons, verdict.parameters);
  for (const Reason& reason : reasons) {
    if (!reason.line.empty()) verdict.reasons.push_back(reason.line);
  }
  verdict.exit_code = reasons.empty() ? kExitSuccess : reasons.front().exit_code;
  return verdict;
}

ExitCode FitExitCode(const FitSummary& summary, const FitChecks& checks) { return Judge(summary, checks).exit_code; }

}  // namespace clothid

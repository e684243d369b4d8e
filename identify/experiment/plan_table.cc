// A plan as text for people.
#include <algorithm>
#include <cmath>
#include <iomanip>
#include <set>
#include <sstream>

#include "identify/base/join_words.h"
#include "identify/experiment/experiment_plan.h"
#include "identify/uncertainty/uncertainty.h"

namespace clothid {
namespace {

constexpr int kMostPartners = 3;  // of a candidate, the best ones
constexpr double kHelps = 0.95;   // a factor of an interval that is worth a line
constexpr int kNameWidth = 16, kValueWidth = 12, kIntervalWidth = 26;

// As in the names of `--initial`.
std::string StartWords(StartSource start) {
  switch (start) {
    case StartSource::kRest:
      return "start estimated, at rest";
    case StartSource::kMoving:
      return "start estimated, in motion";
    default:
      return "start known";
  }
}

std::string Padded(const std::string& text, int width) {
  std::ostringstream padded;
  padded << std::left << std::setw(width - 1) << text << ' ';
  return padded.str();
}

std::string IntervalText(const ExpectedParameter& parameter) {
  if (!parameter.is_told) return "-";
  return NumberText(parameter.lower95, 4) + " .. " + NumberText(parameter.upper95, 4);
}

// "noise +- 1.2 %, step +- 3 %" of a logarithm, else in the parameter's own unit.
std::string PartsText(const ExpectedParameter& parameter) {
  const auto part = [&](double std) {
    return parameter.scale == ParameterScale::kLog ? PercentText(std, 2) : NumberText(std, 2);
  };
  std::string text = "noise +- " + part(parameter.std);
  if (!std::isnan(parameter.step_error)) text += ", step +- " + part(parameter.step_error);
  return text;
}

std::string Remark(const ExpectedParameter& parameter, int num_cloths) {
  if (!parameter.is_told) {
    const std::string made_up = parameter.made_up_by.empty() ? "" : "; made up for: " + parameter.made_up_by;
    return "not told: " + parameter.not_told + made_up;
  }
  if (parameter.told_share == 1.0) return PartsText(parameter);
  return PartsText(parameter) + "; told in " + std::to_string(std::lround(parameter.told_share * num_cloths)) + " of " +
         std::to_string(num_cloths) + " cloths";
}

void AddParameters(const std::vector<ExpectedParameter>& parameters, int num_cloths, std::ostringstream* text) {
  for (const ExpectedParameter& parameter : parameters) {
    const std::string value = parameter.is_in_scene ? NumberText(parameter.value, 4) : "-";
    *text << "  " << Padded(parameter.name, kNameWidth) << Padded(value, kValueWidth)
          << Padded(IntervalText(parameter), kIntervalWidth) << Remark(parameter, num_cloths) << "\n";
  }
}

std::string FactorsText(const Plan& plan, const Improvement& improvement) {
  std::string text;
  for (std::size_t i = 0; i < plan.parameters.size(); ++i) {
    text += (i > 0 ? ", " : "") + plan.parameters[i] + " " +
            NumberText(improvement.factors[static_cast<Eigen::Index>(i)], 2);
  }
  return text + (improvement.tells.empty() ? "" : "; tells " + JoinWords(improvement.tells));
}

// Names of the parameters whose error of the step is the larger part.
std::vector<std::string> LedByStep(const CandidatePlan& candidate) {
  std::vector<std::string> names;
  for (const ExpectedParameter& parameter : candidate.parameters) {
    if (parameter.is_told && parameter.step_error > parameter.std) names.push_back(parameter.name);
  }
  return names;
}

bool Helps(const Improvement& improvement) {
  return !improvement.tells.empty() || (improvement.factors.array() < kHelps).any();
}

void AddImprovements(const Plan& plan, const CandidatePlan& candidate, std::ostringstream* text) {
  const bool any = std::any_of(
      candidate.improvements.begin(), candidate.improvements.end(),
      [](const auto& improvement) { return improvement.kind != ImprovementKind::kHalfStep && Helps(improvement); });
  const std::string& worst = plan.parameters[static_cast<std::size_t>(candidate.worst_told)];
  if (any)
    *text << "  what would help " << worst
          << ", told the least, and the others: so many times as wide, by noise, are\n";
  int num_partners = 0;
  for (const Improvement& improvement : candidate.improvements) {
    if (improvement.kind == ImprovementKind::kHalfStep || !Helps(improvement)) continue;
    if (improvement.partner >= 0 && ++num_partners > kMostPartners) continue;
    std::string name = ImprovementName(improvement.kind);
    if (improvement.partner >= 0) name = "with " + plan.candidates[static_cast<std::size_t>(improvement.partner)].name;
    *text << "    " << Padded(name, 2 * kNameWidth - 2) << FactorsText(plan, improvement) << "\n";
  }
  const std::vector<std::string> led_by_step = LedByStep(candidate);
  for (const Improvement& improvement : candidate.improvements) {
    if (improvement.kind != ImprovementKind::kHalfStep || led_by_step.empty()) continue;
    *text << "  the error of the time step exceeds the noise of " << JoinWords(led_by_step)
          << "; with half the step whole intervals are\n    " << Padded("half the time step", 2 * kNameWidth - 2)
          << FactorsText(plan, improvement) << "\n";
  }
}

void AddPrediction(const Plan& plan, double width, std::ostringstream* text) {
  if (plan.predicted.empty()) return;
  *text << "  prediction of " << plan.predicted << "  +- " << MillimetreText(width, 3)
        << " by what it does not tell, +- " << MillimetreText(plan.believed_width, 3) << " by what is believed\n";
}

// What narrows the prediction the most: of single motions, and of pairs.
void AddBestPrediction(const Plan& plan, std::ostringstream* text) {
  const auto line = [&](double width, const std::string& names) {
    *text << Padded("best", kNameWidth + 2) << "prediction of " << plan.predicted << "  +- " << MillimetreText(width, 3)
          << "  " << names << "\n";
  };
  const int candidate = BestCandidateToPredict(plan), pair = BestPairToPredict(plan);
  const auto name = [&](int c) { return plan.candidates[static_cast<std::size_t>(c)].name; };
  if (candidate >= 0) line(plan.candidates[static_cast<std::size_t>(candidate)].prediction_width, name(candidate));
  if (pair < 0) return;
  const PairPlan& both = plan.pairs[static_cast<std::size_t>(pair)];
  line(both.prediction_width, name(both.first) + " and " + name(both.second));
}

void AddCandidate(const Plan& plan, const CandidatePlan& candidate, std::ostringstream* text) {
  *text << candidate.name << ": ";
  if (!candidate.failure.empty()) {
    *text << "failed: " << candidate.failure << "\n";
    return;
  }
  *text << NumberText(candidate.duration, 3) << " s, " << candidate.num_frames << " frames of " << candidate.num_points
        << " points, " << StartWords(candidate.start) << ", " << candidate.num_cloths << " cloths\n";
  AddParameters(candidate.parameters, candidate.num_cloths, text);
  AddPrediction(plan, candidate.prediction_width, text);
  if (!candidate.failed_cloths.empty()) {
    *text << "  " << candidate.failed_cloths.size()
          << " more cloths could not be simulated; the first: " << candidate.failed_cloths.front() << "\n";
  }
  AddImprovements(plan, candidate, text);
}

void AddPair(const Plan& plan, const PairPlan& pair, std::ostringstream* text) {
  *text << plan.candidates[static_cast<std::size_t>(pair.first)].name << " and "
        << plan.candidates[static_cast<std::size_t>(pair.second)].name << ":\n";
  AddParameters(pair.parameters, pair.num_cloths, text);
  AddPrediction(plan, pair.prediction_width, text);
}

// Those that tell some parameter best, each once, in the order of the plan.
std::set<int> BestPairs(const Plan& plan) {
  std::set<int> pairs;
  for (std::size_t i = 0; i < plan.parameters.size(); ++i) pairs.insert(BestPair(plan, i));
  pairs.erase(-1);
  return pairs;
}

}  // namespace

std::string PlanTable(const Plan& plan) {
  std::ostringstream text;
  for (const CandidatePlan& candidate : plan.candidates) AddCandidate(plan, candidate, &text);
  for (const int pair : BestPairs(plan)) AddPair(plan, plan.pairs[static_cast<std::size_t>(pair)], &text);
  if (!plan.has_any()) return text.str();
  for (std::size_t i = 0; i < plan.parameters.size(); ++i) {
    const int best = BestCandidate(plan, i);
    text << Padded("best", kNameWidth + 2) << Padded(plan.parameters[i], kValueWidth);
    if (best < 0) {
      text << "not told by any of them\n";
      continue;
    }
    const CandidatePlan& candidate = plan.candidates[static_cast<std::size_t>(best)];
    text << Padded(IntervalText(candidate.parameters[i]), kIntervalWidth) << candidate.name << "\n";
  }
  if (!plan.predicted.empty()) AddBestPrediction(plan, &text);
  return text.str();
}

}  // namespace clothid

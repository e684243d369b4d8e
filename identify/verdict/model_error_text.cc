#include "identify/verdict/model_error_text.h"

#include <cmath>
#include <vector>

#include "identify/base/join_words.h"

namespace clothid {
namespace {

// An error that is larger by this before the end is worth a word.
constexpr double kMuchLarger = 1.3;

std::string SizeText(double deviation, PredictedKind kind) {
  if (kind == PredictedKind::kForces) return NumberText(deviation, 2) + " N";
  return MillimetreText(DistanceOf(deviation, kind), 2) + (kind == PredictedKind::kClouds ? " of the surface" : "");
}

std::string CurveText(const ErrorCurve& curve, PredictedKind kind) {
  Eigen::Index largest = 0;
  const double peak = std::sqrt(curve.variances.maxCoeff(&largest));
  const double end = std::sqrt(curve.variances[curve.variances.size() - 1]);
  const std::string at_end = SizeText(end, kind) + " at the end";
  if (!(peak > kMuchLarger * end)) return at_end;
  const std::string before =
      SizeText(peak, kind) + " after " + NumberText(curve.times[largest] - curve.times[0], 2) + " s";
  return end > 0.0 ? before + " and " + at_end : before;
}

}  // namespace

double DistanceOf(double deviation, PredictedKind kind) {
  return kind == PredictedKind::kPoints ? std::sqrt(3.0) * deviation : deviation;
}

double LargestDistance(const ModelError& error, PredictedKind kind) {
  const ErrorCurve& curve = error.CurveOf(kind);
  return curve.is_zero() ? 0.0 : DistanceOf(std::sqrt(curve.variances.maxCoeff()), kind);
}

std::string ModelErrorText(const ModelError& error) {
  std::vector<std::string> texts;
  for (const PredictedKind kind : {PredictedKind::kPoints, PredictedKind::kClouds, PredictedKind::kForces}) {
    if (!error.CurveOf(kind).is_zero()) texts.push_back(CurveText(error.CurveOf(kind), kind));
  }
  return JoinWords(texts);
}

std::string LeadTimesText(const std::vector<LeadTimeError>& lead_times) {
  std::vector<std::string> errors, still;
  for (const LeadTimeError& ahead : lead_times) {
    errors.push_back(MillimetreText(ahead.rmse, 2) + " after " + NumberText(ahead.lead, 2) + " s");
    still.push_back(MillimetreText(ahead.still_rmse, 2));
  }
  return JoinWords(errors) + " without measurements (" + JoinWords(still) +
         " for a cloth that stays where it was seen)";
}

}  // namespace clothid

#include "identify/base/source_names.h"

namespace clothid {

std::string SigmaSourceName(SigmaSource source) {
  switch (source) {
    case SigmaSource::kUnknown:
      return "unknown";
    case SigmaSource::kRecorded:
      return "recorded";
    case SigmaSource::kGiven:
      return "given";
    case SigmaSource::kEstimated:
      return "estimated";
  }
  return "unknown";
}

std::string StartSourceName(StartSource source) {
  switch (source) {
    case StartSource::kScene:
      return "scene";
    case StartSource::kFirstFrame:
      return "first";
    case StartSource::kSmoothed:
      return "smoothed";
    case StartSource::kRest:
      return "rest";
    case StartSource::kMoving:
      return "moving";
    case StartSource::kEstimated:
      return "estimated";
  }
  return "unknown";
}

}  // namespace clothid

#include "identify/base/source_names.h"

namespace clothid {

std::string SigmaSourceName(SigmaSource source) {
  constexpr const char* kNames[] = {"unknown", "recorded", "given", "estimated"};
  return kNames[static_cast<int>(source)];
}

std::string StartSourceName(StartSource source) {
  constexpr const char* kNames[] = {"scene", "first", "smoothed", "rest", "moving", "estimated"};
  return kNames[static_cast<int>(source)];
}

}  // namespace clothid

// Whether something can be used: the smallest verdict.
#ifndef CLOTHID_IDENTIFY_VERDICT_USABILITY_H_
#define CLOTHID_IDENTIFY_VERDICT_USABILITY_H_

#include <string>

namespace clothid {

// Whether an answer, or a parameter of it, can be used. From good to bad.
enum class Usability { kUsable, kWithCare, kDoNotUse };
// "yes", "with care" or "no", as result.json has it.
inline std::string UsabilityName(Usability usability) {
  constexpr const char* kNames[] = {"yes", "with care", "no"};
  return kNames[static_cast<int>(usability)];
}

}  // namespace clothid

#endif  // CLOTHID_IDENTIFY_VERDICT_USABILITY_H_

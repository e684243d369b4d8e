#include "identify/verdict/usability.h"

namespace clothid {

std::string UsabilityName(Usability usability) {
  switch (usability) {
    case Usability::kUsable:
      return "yes";
    case Usability::kWithCare:
      return "with care";
    case Usability::kDoNotUse:
      return "no";
  }
  return "no";
}

}  // namespace clothid

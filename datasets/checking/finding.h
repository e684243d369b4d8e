// One thing that was found out about a recording, and how grave it is.
#ifndef CLOTHID_DATASETS_CHECKING_FINDING_H_
#define CLOTHID_DATASETS_CHECKING_FINDING_H_

#include <string>
#include <vector>

namespace clothid {

enum class Severity {
  kOk,
  kNote,     // worth knowing; a fit takes it into account
  kWarning,  // a fit runs, and its estimates may be wrong
  kProblem,  // no fit can mean anything
};
// "ok", "note", "warning", "problem".
inline std::string SeverityName(Severity severity) {
  switch (severity) {
    case Severity::kOk:
      return "ok";
    case Severity::kNote:
      return "note";
    case Severity::kWarning:
      return "warning";
    case Severity::kProblem:
      break;
  }
  return "problem";
}

struct Finding {
  std::string what;  // a short name, the same for every recording
  Severity severity = Severity::kOk;
  std::string value;        // what was measured, in words
  std::string hint;         // what to do about it; empty where there is nothing to do
  std::vector<int> frames;  // all that it is about, ascending; may be empty
  std::vector<int> points;  // likewise
};

}  // namespace clothid

#endif  // CLOTHID_DATASETS_CHECKING_FINDING_H_

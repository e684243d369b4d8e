// The one exception type of clothid, for input that cannot be used, and what it means to the shell.
//
// Bad input (a file, a scene, a parameter value) throws; what a well-posed run may meet on its way (a time step that
// does not converge) never does: it is part of the result, see `StepFailure` in sim/rollout/rollout.h.
#ifndef CLOTHID_SIM_BASE_ERROR_H_
#define CLOTHID_SIM_BASE_ERROR_H_

#include <stdexcept>
#include <string>

namespace clothid {

enum class ErrorKind {
  kUsage,    // a wrong flag or argument
  kIo,       // a file or folder that cannot be opened, read or written
  kBadData,  // a file that was read and whose content cannot be used
};

// `what()` is one line: it names the file, the key or line, and what was expected. Names that stand in it may be those
// of hostile input, so control characters become '?', and of a message beyond any use the middle is left out.
class Error : public std::runtime_error {
 public:
  Error(ErrorKind kind, const std::string& message) : std::runtime_error(OneLine(message)), kind_(kind) {}
  ErrorKind kind() const { return kind_; }

 private:
  static std::string OneLine(std::string message) {
    constexpr std::size_t kHalf = 1000;  // bytes, of the longest message
    if (message.size() > 2 * kHalf) message.replace(kHalf, message.size() - 2 * kHalf, " [..] ");
    for (char& c : message) {
      if (static_cast<unsigned char>(c) < 0x20 || c == 0x7f) c = '?';
    }
    return message;
  }

  ErrorKind kind_;
};

// Throws that what `source` holds, a file or a part of one, cannot be used.
[[noreturn]] inline void FailOnData(const std::string& source, const std::string& message) {
  throw Error(ErrorKind::kBadData, source + ": " + message);
}

// Throws that a flag, an argument or an option is wrong, unless `condition` holds.
inline void ExpectUsage(bool condition, const std::string& message) {
  if (!condition) throw Error(ErrorKind::kUsage, message);
}

// Exit codes of the programs. Where several apply: 70, 130, 1, 2, 3, 6, 4, 5 in that order.
enum ExitCode : int {
  kExitSuccess = 0,
  kExitUsageOrIo = 1,
  kExitBadData = 2,
  kExitNotConverged = 3,
  kExitNotIdentifiable = 4,  // a fitted parameter is not determined by the recordings, or stands at its bound
  kExitHoldoutFailed = 5,    // the estimates predict what was held out worse than the nominal parameters
  kExitDoNotUse = 6,         // the fit converged on what cannot be right: no estimate must be used
  kExitInternal = 70,        // EX_SOFTWARE of sysexits.h: an error of clothid itself, or no memory left
  kExitInterrupted = 130,
};

inline ExitCode ExitCodeOf(ErrorKind kind) { return kind == ErrorKind::kBadData ? kExitBadData : kExitUsageOrIo; }

}  // namespace clothid

#endif  // CLOTHID_SIM_BASE_ERROR_H_

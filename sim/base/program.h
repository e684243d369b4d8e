// What our programs do beside their work: they mind signals, and see that what they print arrives.
#ifndef CLOTHID_SIM_BASE_PROGRAM_H_
#define CLOTHID_SIM_BASE_PROGRAM_H_

#include <atomic>
#include <functional>
#include <string>

namespace clothid {

// From now on the first SIGINT, SIGTERM or SIGHUP sets the flag, which lasts as long as the process; the next one ends
// the process as usual. Signals that the process was started to ignore (nohup) stay ignored. A thread waits for them:
// this one and those that are made from now on block them. For programs, before they begin a file or a thread: no file
// is left half-written behind them.
const std::atomic<bool>& CatchInterrupts();
// Whether that flag is set.
bool IsInterrupted();

// From now on a file that grows beyond the limit of the process (ulimit -f) is a failed write() with its reason, not
// the end of the process. For the start of main().
void CatchFileSizeLimit();

// The exit code that `work` returns. What it throws ends here, as one line on stderr, led by `name`, and as an exit
// code: an `Error` as `ExitCodeOf` says, memory that ran out and any other exception, an internal error, as
// kExitInternal.
int ReportErrors(const std::string& name, const std::function<int()>& work);

// For the end of main(): `exit_code`, unless what was printed on stdout could not be written. That is a line on stderr,
// led by `name`, and kExitUsageOrIo where the program was not interrupted.
int FinishOutput(const std::string& name, int exit_code);

// Behind it: ends the process without the ends of libraries. That of OpenBLAS waits for threads that may wait for
// memory, for ever. Sanitizers, which tell at the end what they have found, are let do so.
[[noreturn]] void EndProcess(int exit_code);

}  // namespace clothid

#endif  // CLOTHID_SIM_BASE_PROGRAM_H_

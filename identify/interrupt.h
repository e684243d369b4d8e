// Ctrl-C as a flag.
#ifndef CLOTHID_IDENTIFY_INTERRUPT_H_
#define CLOTHID_IDENTIFY_INTERRUPT_H_

#include <atomic>

namespace clothid {

// From now on the first SIGINT or SIGTERM sets the flag, which lasts as long as the process; the next one ends the
// process as usual. For programs.
const std::atomic<bool>& CatchInterrupts();

}  // namespace clothid

#endif  // CLOTHID_IDENTIFY_INTERRUPT_H_

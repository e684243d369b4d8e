// What a program does before main(), and before the libraries that it is linked with are set up.
#ifndef CLOTHID_IDENTIFY_BASE_PROGRAM_START_H_
#define CLOTHID_IDENTIFY_BASE_PROGRAM_START_H_

namespace clothid {

// A program that calls it, anywhere, has SIGINT, SIGTERM and SIGHUP blocked until main(): threads that libraries make
// meanwhile, OpenBLAS among them, block them for good. So they never run the handler that METIS has for a while, see
// `CatchInterrupts` in sim/base/program.h.
void KeepSignalsFromLibraries();

}  // namespace clothid

#endif  // CLOTHID_IDENTIFY_BASE_PROGRAM_START_H_

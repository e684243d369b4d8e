// Which BLAS is behind CHOLMOD, and may rollouts run side by side on it?
//
// OpenBLAS built without threads hands out its work buffers without a lock (Debian's libopenblas0-serial 0.3.21 does):
// two rollouts in two threads now and then get the same buffer and compute wrong numbers, silently. OpenBLAS built with
// threads locks, so with one thread per call it is as exact and safe.
#ifndef CLOTHID_IDENTIFY_BLAS_THREADS_H_
#define CLOTHID_IDENTIFY_BLAS_THREADS_H_

namespace clothid {

// False for an OpenBLAS without threads. Any other BLAS is taken to be safe.
bool BlasMayRunInThreads();

// Keeps every call of a threaded OpenBLAS to the calling thread: the numbers do not depend on the machine's cores, and
// the matrices of a cloth are too small to gain from it. Set for the whole process.
void UseOneThreadPerBlasCall();

}  // namespace clothid

#endif  // CLOTHID_IDENTIFY_BLAS_THREADS_H_

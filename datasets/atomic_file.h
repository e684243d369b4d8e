// Output files that are either complete or not there.
#ifndef CLOTHID_DATASETS_ATOMIC_FILE_H_
#define CLOTHID_DATASETS_ATOMIC_FILE_H_

#include <initializer_list>
#include <string>
#include <string_view>

namespace clothid {

// Writes `parts` one after the other to a temporary name beside `path`, flushes it to the disk and renames it to
// `path`, replacing a file that stood there. On failure the temporary is removed, what stood at `path` is untouched,
// and `Error` (kIo) is thrown.
void WriteFileAtomically(const std::string& path, std::initializer_list<std::string_view> parts);

}  // namespace clothid

#endif  // CLOTHID_DATASETS_ATOMIC_FILE_H_

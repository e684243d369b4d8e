// Output files that are either complete or not there.
#ifndef CLOTHID_DATASETS_FILES_ATOMIC_FILE_H_
#define CLOTHID_DATASETS_FILES_ATOMIC_FILE_H_

#include <initializer_list>
#include <string>
#include <string_view>

namespace clothid {

// Writes `parts` one after the other to a hidden file beside `path`, flushes it to the disk and gives it the name
// `path`, replacing a file that stood there (where `path` is a link, the file that it leads to). On failure, also where
// another process is about to write the same file, what stood at `path` is untouched, nothing is left behind, and
// `Error` (kIo) is thrown. A process that is killed may leave the hidden file, which the next one to write `path` takes
// over. A device or pipe is written to as it is.
void WriteFileAtomically(const std::string& path, std::initializer_list<std::string_view> parts);

// Throws `Error` (kIo) where `WriteFileAtomically` would, as far as can be told beforehand: for programs that work long
// before they write. Changes nothing.
void CheckFileCanBeWritten(const std::string& path);

// Whether `path` is there and is neither a file nor a folder: a device or a pipe, which nothing takes the place of.
bool IsStream(const std::string& path);

// Flushes a file, or the names in a folder, to the disk: after a power cut they are there. Whether that worked; else
// errno is set.
bool FlushToDisk(const std::string& path);

}  // namespace clothid

#endif  // CLOTHID_DATASETS_FILES_ATOMIC_FILE_H_

// What a file seems to be by its first bytes: for errors about files of the wrong kind.
#ifndef CLOTHID_DATASETS_FILES_FILE_KIND_H_
#define CLOTHID_DATASETS_FILES_FILE_KIND_H_

#include <cstddef>
#include <string>
#include <string_view>

namespace clothid {

inline constexpr std::size_t kKindBytes = 64;  // of a file's start, enough for `FileKind`

// The first bytes of a file, at most `max_bytes` of them, without a byte order mark. Throws `Error`: kIo where it
// cannot be read, kBadData where it is in UTF-16.
std::string ReadStart(const std::string& path, std::size_t max_bytes);

// "a NumPy array", "packed with gzip", "JSON text", "text", ..; empty where the bytes tell nothing.
std::string FileKind(std::string_view start);

}  // namespace clothid

#endif  // CLOTHID_DATASETS_FILES_FILE_KIND_H_

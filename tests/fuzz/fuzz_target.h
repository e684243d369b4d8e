// What the fuzz targets share. A target hands the bytes of one input to a reader of clothid. Accepted are success and
// an `Error` with a message of one line; every other end of the process is a finding: another exception, a failed check
// or assertion, a report of a sanitizer, too much time or memory.
#ifndef CLOTHID_TESTS_FUZZ_FUZZ_TARGET_H_
#define CLOTHID_TESTS_FUZZ_FUZZ_TARGET_H_

#include <fcntl.h>
#include <sys/mman.h>
#include <unistd.h>

#include <cstddef>
#include <cstdint>
#include <cstdio>
#include <cstdlib>
#include <string>
#include <string_view>

#include "sim/base/error.h"

namespace clothid {

// The targets: each takes an input, and returns 0. <name>_fuzz.cc defines one; fuzz_main.cc knows them by name.
int FuzzCurve(const std::uint8_t* data, std::size_t size);
int FuzzFabricCard(const std::uint8_t* data, std::size_t size);
int FuzzFlags(const std::uint8_t* data, std::size_t size);
int FuzzHandleCsv(const std::uint8_t* data, std::size_t size);
int FuzzImport(const std::uint8_t* data, std::size_t size);
int FuzzJournal(const std::uint8_t* data, std::size_t size);
int FuzzLandscapeFolder(const std::uint8_t* data, std::size_t size);
int FuzzLandscapeStore(const std::uint8_t* data, std::size_t size);
int FuzzMotion(const std::uint8_t* data, std::size_t size);
int FuzzNpy(const std::uint8_t* data, std::size_t size);
int FuzzObj(const std::uint8_t* data, std::size_t size);
int FuzzPc2(const std::uint8_t* data, std::size_t size);
int FuzzPly(const std::uint8_t* data, std::size_t size);
int FuzzRosCsv(const std::uint8_t* data, std::size_t size);
int FuzzScene(const std::uint8_t* data, std::size_t size);
int FuzzSensor(const std::uint8_t* data, std::size_t size);
int FuzzTracksCsv(const std::uint8_t* data, std::size_t size);
int FuzzTrc(const std::uint8_t* data, std::size_t size);

// Ends the process unless `condition` holds.
inline void Check(bool condition, const std::string& expected) {
  if (condition) return;
  std::fprintf(stderr, "finding: expected %s\n", expected.c_str());
  std::abort();
}

// Whether `use` ends without an `Error`. The message of one must be a line that holds `source`, the file or flag.
template <typename Function>
bool Accepts(const Function& use, const std::string& source) {
  constexpr std::size_t kLongestMessage = 4096;
  try {
    use();
    return true;
  } catch (const Error& error) {
    const std::string message = error.what();
    for (const char c : message) Check(static_cast<unsigned char>(c) >= 0x20, "one line, found '" + message + "'");
    Check(message.size() <= kLongestMessage, "a shorter message than '" + message + "'");
    Check(message.find(source) != std::string::npos, "'" + source + "' in the message '" + message + "'");
    return false;
  }
}

inline std::string_view AsText(const std::uint8_t* data, std::size_t size) {
  return {reinterpret_cast<const char*>(data), size};
}

// A file without a disk, for readers that take a path.
class MemoryFile {
 public:
  MemoryFile() : descriptor_(::memfd_create("input", MFD_CLOEXEC)) {
    Check(descriptor_ >= 0, "a file in memory");
    path_ = "/proc/self/fd/" + std::to_string(descriptor_);
  }
  ~MemoryFile() { ::close(descriptor_); }
  MemoryFile(const MemoryFile&) = delete;
  MemoryFile& operator=(const MemoryFile&) = delete;

  const std::string& path() const { return path_; }

  void Write(std::string_view bytes) const {
    const bool written = ::ftruncate(descriptor_, 0) == 0 &&
                         ::pwrite(descriptor_, bytes.data(), bytes.size(), 0) == static_cast<ssize_t>(bytes.size());
    Check(written, "to write a file in memory");
  }

 private:
  int descriptor_;
  std::string path_;
};

// Puts `digest` in place of the value of `key` in a JSON text, where that value is as long: no input would get past a
// checksum otherwise. Blanks around the colon keep the input's own.
inline void SetDigest(const std::string& key, const std::string& digest, std::string* text) {
  for (const char* colon : {"\":\"", "\": \""}) {
    const std::string start = "\"" + key + colon;
    const std::size_t value = text->find(start) + start.size();
    if (value < start.size() || text->find('"', value) != value + digest.size()) continue;
    text->replace(value, digest.size(), digest);
  }
}

}  // namespace clothid

#endif  // CLOTHID_TESTS_FUZZ_FUZZ_TARGET_H_

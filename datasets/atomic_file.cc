#include "datasets/atomic_file.h"

#include <fcntl.h>
#include <unistd.h>

#include <cerrno>
#include <cstdio>
#include <cstring>
#include <utility>

#include "sim/error.h"

namespace clothid {
namespace {

// A file under a temporary name that disappears unless it is published.
class TemporaryFile {
 public:
  explicit TemporaryFile(const std::string& path)
      : path_(path), temporary_(path + ".tmp" + std::to_string(::getpid())) {
    descriptor_ = ::open(temporary_.c_str(), O_WRONLY | O_CREAT | O_TRUNC | O_CLOEXEC, 0666);
    if (descriptor_ < 0) Fail();
  }
  TemporaryFile(const TemporaryFile&) = delete;
  TemporaryFile& operator=(const TemporaryFile&) = delete;
  ~TemporaryFile() {
    if (descriptor_ >= 0) ::close(descriptor_);
    if (!published_) ::unlink(temporary_.c_str());
  }

  void Write(std::string_view bytes) {
    while (!bytes.empty()) {
      const ssize_t count = ::write(descriptor_, bytes.data(), bytes.size());
      if (count < 0 && errno == EINTR) continue;
      if (count < 0) Fail();
      bytes.remove_prefix(static_cast<std::size_t>(count));
    }
  }

  void Publish() {
    if (::fsync(descriptor_) != 0) Fail();
    if (::close(std::exchange(descriptor_, -1)) != 0) Fail();
    if (std::rename(temporary_.c_str(), path_.c_str()) != 0) Fail();
    published_ = true;
  }

 private:
  [[noreturn]] void Fail() const {
    throw Error(ErrorKind::kIo, path_ + ": cannot be written: " + std::strerror(errno));
  }

  const std::string& path_;
  const std::string temporary_;
  int descriptor_ = -1;
  bool published_ = false;
};

}  // namespace

void WriteFileAtomically(const std::string& path, std::initializer_list<std::string_view> parts) {
  TemporaryFile file(path);
  for (const std::string_view part : parts) file.Write(part);
  file.Publish();
}

}  // namespace clothid

#include "datasets/files/atomic_file.h"

#include <fcntl.h>
#include <sys/file.h>
#include <sys/stat.h>
#include <unistd.h>

#include <cerrno>
#include <cstdio>
#include <cstring>
#include <filesystem>
#include <system_error>

#include "sim/base/error.h"

namespace clothid {
namespace {

namespace fs = std::filesystem;

[[noreturn]] void Fail(const std::string& path, const std::string& reason) {
  throw Error(ErrorKind::kIo, path + ": cannot be written: " + reason);
}
[[noreturn]] void Fail(const std::string& path) { Fail(path, std::strerror(errno)); }

void WriteAll(int descriptor, const std::string& path, std::initializer_list<std::string_view> parts) {
  for (std::string_view bytes : parts) {
    while (!bytes.empty()) {
      const ssize_t count = ::write(descriptor, bytes.data(), bytes.size());
      if (count < 0 && errno == EINTR) continue;
      if (count < 0) Fail(path);
      bytes.remove_prefix(static_cast<std::size_t>(count));
    }
  }
}

// The file that a name leads to, which need not be there. What is still a link leads nowhere.
fs::path BehindLinks(const fs::path& path) {
  constexpr int kMostLinks = 40;
  std::error_code error;
  const fs::path present = fs::canonical(path, error);
  if (!error) return present;
  fs::path target = path;
  for (int i = 0; i < kMostLinks && fs::is_symlink(target, error); ++i) {
    target = target.parent_path() / fs::read_symlink(target, error);
  }
  return target;
}

// The file that disappears unless it is published, while this process holds its lock.
class HiddenFile {
 public:
  explicit HiddenFile(const std::string& path) : path_(path) {
    target_ = BehindLinks(path);
    hidden_ = target_;
    hidden_.replace_filename("." + target_.filename().string() + ".part");
  }
  HiddenFile(const HiddenFile&) = delete;
  HiddenFile& operator=(const HiddenFile&) = delete;
  ~HiddenFile() {
    if (is_mine_) ::unlink(hidden_.c_str());
    if (descriptor_ >= 0) ::close(descriptor_);
  }

  void Open() {
    std::error_code ignored;
    if (fs::is_directory(target_, ignored)) Fail(path_, std::strerror(EISDIR));
    if (fs::is_symlink(target_, ignored)) Fail(path_, std::strerror(ELOOP));
    while (!is_mine_) {
      if (descriptor_ >= 0) ::close(descriptor_);
      descriptor_ = ::open(hidden_.c_str(), O_WRONLY | O_CREAT | O_CLOEXEC | O_NOFOLLOW, 0666);
      if (descriptor_ < 0) Fail(path_);
      // The lock ends with its process, however that ends. Not every file system has locks.
      if (::flock(descriptor_, LOCK_EX | LOCK_NB) != 0 && errno == EWOULDBLOCK) {
        Fail(path_, "another process is writing it");
      }
      is_mine_ = HasItsName();
    }
    if (::ftruncate(descriptor_, 0) != 0) Fail(path_);
  }

  void Write(std::initializer_list<std::string_view> parts) { WriteAll(descriptor_, path_, parts); }

  void Publish() {
    if (::fsync(descriptor_) != 0) Fail(path_);
    if (std::rename(hidden_.c_str(), target_.c_str()) != 0) Fail(path_);
    is_mine_ = false;
    // Best effort: the file is whole and in its place, and not every file system can flush a folder.
    FlushToDisk(target_.has_parent_path() ? target_.parent_path().string() : ".");
  }

 private:
  // Whether what was opened still stands there: its last owner may have published or removed it in between.
  bool HasItsName() const {
    struct stat opened = {}, named = {};
    return ::fstat(descriptor_, &opened) == 0 && ::stat(hidden_.c_str(), &named) == 0 &&
           opened.st_dev == named.st_dev && opened.st_ino == named.st_ino;
  }

  const std::string path_;
  fs::path target_, hidden_;
  int descriptor_ = -1;
  bool is_mine_ = false;
};

void WriteToStream(const std::string& path, std::initializer_list<std::string_view> parts) {
  const int descriptor = ::open(path.c_str(), O_WRONLY | O_CLOEXEC);
  if (descriptor < 0) Fail(path);
  try {
    WriteAll(descriptor, path, parts);
  } catch (...) {
    ::close(descriptor);
    throw;
  }
  if (::close(descriptor) != 0) Fail(path);
}

}  // namespace

void WriteFileAtomically(const std::string& path, std::initializer_list<std::string_view> parts) {
  if (IsStream(path)) return WriteToStream(path, parts);
  HiddenFile file(path);
  file.Open();
  file.Write(parts);
  file.Publish();
}

void CheckFileCanBeWritten(const std::string& path) {
  if (!IsStream(path)) HiddenFile(path).Open();
}

bool IsStream(const std::string& path) {
  std::error_code ignored;
  const fs::file_status status = fs::status(path, ignored);
  return fs::exists(status) && !fs::is_regular_file(status) && !fs::is_directory(status);
}

bool FlushToDisk(const std::string& path) {
  const int descriptor = ::open(path.c_str(), O_RDONLY | O_CLOEXEC);
  if (descriptor < 0) return false;
  const bool is_flushed = ::fsync(descriptor) == 0;
  const int reason = errno;
  ::close(descriptor);
  errno = reason;
  return is_flushed;
}

}  // namespace clothid

#include "datasets/files/file_group.h"

#include <fcntl.h>
#include <sys/file.h>
#include <sys/stat.h>
#include <unistd.h>

#include <cerrno>
#include <cstring>
#include <system_error>
#include <utility>

#include "datasets/files/atomic_file.h"
#include "sim/base/error.h"

namespace clothid {
namespace {

namespace fs = std::filesystem;

[[noreturn]] void FailOnGroup(const fs::path& path, const std::string& reason) {
  throw Error(ErrorKind::kIo, path.string() + ": cannot be written: " + reason);
}

bool IsSameFile(int descriptor, const fs::path& path) {
  struct stat opened = {}, named = {};
  return ::fstat(descriptor, &opened) == 0 && ::stat(path.c_str(), &named) == 0 && opened.st_dev == named.st_dev &&
         opened.st_ino == named.st_ino;
}

}  // namespace

FileGroup::FileGroup(const std::string& path) {
  folder_ = fs::path(path).parent_path();
  hidden_ = folder_ / ("." + fs::path(path).filename().string() + ".part");
  Lock(path);
  std::error_code error;
  for (fs::directory_iterator entry(hidden_, error); !error && entry != fs::directory_iterator();
       entry.increment(error)) {
    fs::remove_all(entry->path(), error);
    if (error) break;
  }
  if (error) {
    Clear();
    FailOnGroup(path, error.message());
  }
}

FileGroup::~FileGroup() { Clear(); }

// The lock ends with its process, however that ends. Not every file system has locks.
void FileGroup::Lock(const std::string& path) {
  do {
    if (lock_ >= 0) ::close(std::exchange(lock_, -1));
    if (::mkdir(hidden_.c_str(), 0777) != 0 && errno != EEXIST) FailOnGroup(path, std::strerror(errno));
    lock_ = ::open(hidden_.c_str(), O_RDONLY | O_DIRECTORY | O_CLOEXEC | O_NOFOLLOW);
    if (lock_ < 0 && errno == ENOENT) continue;  // its last owner has just removed it
    if (lock_ < 0) FailOnGroup(path, std::strerror(errno));
    if (::flock(lock_, LOCK_EX | LOCK_NB) != 0 && errno == EWOULDBLOCK) {
      ::close(std::exchange(lock_, -1));
      FailOnGroup(path, "another process is writing it");
    }
  } while (lock_ < 0 || !IsSameFile(lock_, hidden_));
}

void FileGroup::Write(const std::string& name, std::string_view bytes) {
  WriteFileAtomically((hidden_ / name).string(), {bytes});
  written_.push_back(name);
}

void FileGroup::Remove(const std::string& name) { removed_.push_back(name); }

void FileGroup::CheckPlaces() const {
  std::error_code ignored;
  for (const std::vector<std::string>* names : {&removed_, &written_}) {
    for (const std::string& name : *names) {
      if (fs::is_directory(folder_ / name, ignored)) FailOnGroup(folder_ / name, std::strerror(EISDIR));
    }
  }
}

void FileGroup::Commit() {
  CheckPlaces();
  std::error_code error;
  for (const std::string& name : removed_) {
    fs::remove(folder_ / name, error);
    if (error) FailOnGroup(folder_ / name, error.message());
  }
  for (const std::string& name : written_) {
    fs::rename(hidden_ / name, folder_ / name, error);
    if (error) FailOnGroup(folder_ / name, error.message());
  }
  FlushToDisk(folder_.empty() ? "." : folder_.string());  // best effort: not every file system can
}

void FileGroup::Clear() noexcept {
  if (lock_ < 0) return;
  std::error_code ignored;
  fs::remove_all(hidden_, ignored);
  ::close(std::exchange(lock_, -1));
}

}  // namespace clothid

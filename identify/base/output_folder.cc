#include "identify/base/output_folder.h"

#include <fcntl.h>
#include <sys/file.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <cstring>
#include <system_error>
#include <utility>

#include "datasets/files/atomic_file.h"
#include "identify/base/options.h"
#include "sim/base/error.h"

namespace clothid {
namespace {

namespace fs = std::filesystem;

[[noreturn]] void FailOnFolder(const fs::path& path, const std::string& problem) {
  throw Error(ErrorKind::kIo, "--output: " + path.string() + ": " + problem);
}

// What is in `folder`, as far as it can be read.
std::vector<fs::path> EntriesOf(const fs::path& folder) {
  std::vector<fs::path> entries;
  std::error_code error;
  for (fs::directory_iterator entry(folder, error); !error && entry != fs::directory_iterator();
       entry.increment(error)) {
    entries.push_back(entry->path());
  }
  return entries;
}

// The missing folders of `path`, the outermost first.
std::vector<fs::path> MissingFolders(const fs::path& path) {
  std::vector<fs::path> missing;
  std::error_code error;
  for (fs::path folder = path; !folder.empty() && !fs::exists(folder, error); folder = folder.parent_path()) {
    missing.push_back(folder);
  }
  std::reverse(missing.begin(), missing.end());
  return missing;
}

}  // namespace

void ExpectNotReplaced(const std::string& flag, const std::string& input, const std::string& folder,
                       const IsResult& is_result) {
  for (const fs::path& entry : EntriesOf(folder)) {
    std::error_code ignored;
    if (!is_result(entry.filename().string()) || !fs::equivalent(entry, input, ignored)) continue;
    throw Error(ErrorKind::kUsage, flag + ": " + input + ": the results in --output " + folder +
                                       " would replace it; choose another folder");
  }
}

OutputFolder::OutputFolder(const std::string& path) {
  if (path.empty()) throw Error(ErrorKind::kUsage, "--output: expected a folder");
  path_ = fs::absolute(path).lexically_normal();
  if (!path_.has_filename()) path_ = path_.parent_path();
  hidden_ = path_ / ".clothid_part";
  try {
    MakeFolders();
    Lock();
    old_journals_ = Journals();
    std::error_code error;
    fs::remove_all(hidden_, error);
    if (!error) fs::create_directory(hidden_, error);
    if (!error) fs::remove(hidden_, error);
    if (error) FailOnFolder(path_, "cannot be written to: " + error.message());
  } catch (...) {
    RemoveAll();
    throw;
  }
}

OutputFolder::~OutputFolder() { RemoveAll(); }

void OutputFolder::MakeFolders() {
  for (const fs::path& folder : MissingFolders(path_)) {
    std::error_code error;
    const bool is_made = fs::create_directory(folder, error);  // not where another process was faster
    if (error) FailOnFolder(folder, "cannot make the folder: " + error.message());
    if (is_made) made_.push_back(folder);
  }
  std::error_code ignored;
  if (!fs::is_directory(path_, ignored)) FailOnFolder(path_, "is not a folder");
}

void OutputFolder::Lock() {
  lock_ = ::open(path_.c_str(), O_RDONLY | O_DIRECTORY | O_CLOEXEC);
  if (lock_ < 0) FailOnFolder(path_, std::string("cannot be opened: ") + std::strerror(errno));
  // The lock ends with its process, however that ends, and leaves no file. Not every file system has locks.
  if (::flock(lock_, LOCK_EX | LOCK_NB) == 0 || errno != EWOULDBLOCK) return;
  ::close(std::exchange(lock_, -1));
  made_.clear();  // the process that has the lock writes there
  FailOnFolder(path_, "another process is writing its results there");
}

// Its lock went with it.
void OutputFolder::MakeAgain() {
  if (lock_ >= 0) ::close(std::exchange(lock_, -1));
  MakeFolders();
  Lock();
}

std::string OutputFolder::TemporaryPath(const std::string& name) {
  std::error_code error;
  if (!fs::exists(path_, error)) MakeAgain();
  if (fs::create_directory(hidden_, error)) old_journals_ = Journals();
  if (error) FailOnFolder(hidden_, "cannot make the folder: " + error.message());
  if (std::find(names_.begin(), names_.end(), name) == names_.end()) names_.push_back(name);
  return (hidden_ / name).string();
}

void OutputFolder::Write(const std::string& name, const std::string& content) {
  WriteFileAtomically(TemporaryPath(name), {content});
}

void OutputFolder::Drop(const std::string& name) {
  std::error_code ignored;
  fs::remove(hidden_ / name, ignored);
  names_.erase(std::remove(names_.begin(), names_.end(), name), names_.end());
}

void OutputFolder::CheckPlaces() const {
  std::error_code ignored;
  for (const std::string& name : names_) {
    if (!FlushToDisk((hidden_ / name).string())) {
      FailOnFolder(path_ / name, std::string("cannot be written: ") + std::strerror(errno));
    }
    if (fs::is_directory(path_ / name, ignored)) FailOnFolder(path_ / name, "cannot be written: is a folder");
  }
}

// Best effort: what cannot be removed stays.
void OutputFolder::RemoveEarlier() const {
  if (!is_result_) return;
  for (const fs::path& entry : EntriesOf(path_)) {
    const std::string name = entry.filename().string();
    std::error_code ignored;
    const bool is_written = std::find(names_.begin(), names_.end(), name) != names_.end();
    if (is_result_(name) && !is_written && !fs::is_directory(entry, ignored)) fs::remove(entry, ignored);
  }
}

void OutputFolder::Commit() {
  CheckPlaces();
  RemoveEarlier();
  for (const std::string& name : names_) {
    std::error_code error;
    fs::rename(hidden_ / name, path_ / name, error);
    if (error) FailOnFolder(path_ / name, "cannot be written: " + error.message());
  }
  FlushToDisk(path_.string());  // best effort: not every file system can
  std::error_code ignored;
  fs::remove_all(hidden_, ignored);
  old_journals_ = Journals();
  if (!keep_journals_) {
    for (const fs::path& journal : old_journals_) fs::remove(journal, ignored);
  }
  names_.clear();
  made_.clear();
}

std::vector<fs::path> OutputFolder::Journals() const {
  std::vector<fs::path> found;
  for (const fs::path& entry : EntriesOf(path_)) {
    if (entry.filename().string().rfind(kJournalPrefix, 0) == 0) found.push_back(entry);
  }
  return found;
}

void OutputFolder::RemoveAll() noexcept {
  std::error_code ignored;
  if (lock_ >= 0) {
    fs::remove_all(hidden_, ignored);
    for (const fs::path& journal : Journals()) {
      const bool is_old = std::find(old_journals_.begin(), old_journals_.end(), journal) != old_journals_.end();
      if (!is_old) fs::remove(journal, ignored);
    }
  }
  for (auto folder = made_.rbegin(); folder != made_.rend(); ++folder) fs::remove(*folder, ignored);
  if (lock_ >= 0) ::close(lock_);
}

}  // namespace clothid

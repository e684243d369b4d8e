#include "identify/output_folder.h"

#include <algorithm>
#include <fstream>
#include <system_error>

#include "identify/options.h"
#include "sim/error.h"

namespace clothid {
namespace {

namespace fs = std::filesystem;

[[noreturn]] void Fail(const fs::path& path, const std::string& problem) {
  throw Error(ErrorKind::kIo, "--output: " + path.string() + ": " + problem);
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

OutputFolder::OutputFolder(const std::string& path) {
  if (path.empty()) throw Error(ErrorKind::kUsage, "--output: expected a folder");
  path_ = fs::absolute(path).lexically_normal();
  if (!path_.has_filename()) path_ = path_.parent_path();
  old_journals_ = Find(kJournalPrefix);
  const char probe[] = "probe";
  try {
    for (const fs::path& folder : MissingFolders(path_)) {
      std::error_code error;
      if (!fs::create_directory(folder, error)) Fail(folder, "cannot make the folder: " + error.message());
      made_.push_back(folder);
    }
    if (!fs::is_directory(path_)) Fail(path_, "is not a folder");
    Write(probe, "");
  } catch (...) {
    RemoveAll();
    throw;
  }
  std::error_code ignored;
  fs::remove(TemporaryPath(probe), ignored);
  names_.clear();
}

OutputFolder::~OutputFolder() { RemoveAll(); }

std::string OutputFolder::TemporaryPath(const std::string& name) {
  if (std::find(names_.begin(), names_.end(), name) == names_.end()) names_.push_back(name);
  return (path_ / ("." + name + ".part")).string();
}

void OutputFolder::Write(const std::string& name, const std::string& content) {
  const std::string temporary = TemporaryPath(name);
  std::ofstream file(temporary, std::ios::binary | std::ios::trunc);
  file << content;
  file.close();
  if (!file) Fail(path_ / name, "cannot be written");
}

void OutputFolder::Commit() {
  for (const std::string& name : names_) {
    std::error_code error;
    fs::rename(TemporaryPath(name), path_ / name, error);
    if (error) Fail(path_ / name, "cannot be written: " + error.message());
  }
  std::error_code ignored;
  for (const std::string& name : names_) {
    for (const fs::path& leftover : Find("." + name + ".part")) fs::remove(leftover, ignored);
  }
  old_journals_ = Find(kJournalPrefix);
  if (!keep_journals_) {
    for (const fs::path& journal : old_journals_) fs::remove(journal, ignored);
  }
  names_.clear();
  made_.clear();
}

std::vector<fs::path> OutputFolder::Find(const std::string& prefix) const {
  std::vector<fs::path> found;
  std::error_code error;
  for (fs::directory_iterator entry(path_, error); !error && entry != fs::directory_iterator();
       entry.increment(error)) {
    if (entry->path().filename().string().rfind(prefix, 0) == 0) found.push_back(entry->path());
  }
  return found;
}

void OutputFolder::RemoveAll() noexcept {
  std::error_code ignored;
  for (const std::string& name : names_) fs::remove(path_ / ("." + name + ".part"), ignored);
  for (const fs::path& journal : Find(kJournalPrefix)) {
    const bool is_old = std::find(old_journals_.begin(), old_journals_.end(), journal) != old_journals_.end();
    if (!is_old) fs::remove(journal, ignored);
  }
  for (auto folder = made_.rbegin(); folder != made_.rend(); ++folder) fs::remove(*folder, ignored);
}

}  // namespace clothid

// The folder that a run writes its results to: all files or none.
#ifndef CLOTHID_IDENTIFY_OUTPUT_FOLDER_H_
#define CLOTHID_IDENTIFY_OUTPUT_FOLDER_H_

#include <filesystem>
#include <string>
#include <vector>

namespace clothid {

// Files get temporary names until `Commit` renames them. Without it the destructor removes them, every journal that was
// not there before (identify/options.h), and every folder that the constructor made. One process at a time.
class OutputFolder {
 public:
  // Makes the folder where it is missing and tries that it can be written to, so that a fit is not run in vain. Throws
  // `Error` (kIo), leaving nothing behind.
  explicit OutputFolder(const std::string& path);
  ~OutputFolder();
  OutputFolder(const OutputFolder&) = delete;
  OutputFolder& operator=(const OutputFolder&) = delete;

  // Where to write the file that will be called `name`.
  std::string TemporaryPath(const std::string& name);
  // Writes the whole file `name` under its temporary name. Throws `Error` (kIo).
  void Write(const std::string& name, const std::string& content);
  // Keeps the journals of a fit that can be resumed.
  void KeepJournals() { keep_journals_ = true; }
  // Gives every file its name, removes what a killed process left under their temporary names, and all journals unless
  // they are to be kept. Throws `Error` (kIo).
  void Commit();

  std::string path() const { return path_.string(); }

 private:
  // The files whose names start with `prefix`.
  std::vector<std::filesystem::path> Find(const std::string& prefix) const;
  void RemoveAll() noexcept;

  std::filesystem::path path_;
  std::vector<std::filesystem::path> made_;  // folders, the outermost first
  std::vector<std::string> names_;
  std::vector<std::filesystem::path> old_journals_;
  bool keep_journals_ = false;
};

}  // namespace clothid

#endif  // CLOTHID_IDENTIFY_OUTPUT_FOLDER_H_

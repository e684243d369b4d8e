// The folder that a run writes its results to: all files or none.
#ifndef CLOTHID_IDENTIFY_OUTPUT_FOLDER_H_
#define CLOTHID_IDENTIFY_OUTPUT_FOLDER_H_

#include <filesystem>
#include <string>
#include <vector>

namespace clothid {

// Files get temporary names until `Commit` renames them. Without it the destructor removes them, and every folder that
// the constructor made. One process at a time.
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
  // Gives every file its name. Throws `Error` (kIo).
  void Commit();

 private:
  void RemoveAll() noexcept;

  std::filesystem::path path_;
  std::vector<std::filesystem::path> made_;  // folders, the outermost first
  std::vector<std::string> names_;
};

}  // namespace clothid

#endif  // CLOTHID_IDENTIFY_OUTPUT_FOLDER_H_

// The folder that a run writes its results to: all files or none.
#ifndef CLOTHID_IDENTIFY_BASE_OUTPUT_FOLDER_H_
#define CLOTHID_IDENTIFY_BASE_OUTPUT_FOLDER_H_

#include <filesystem>
#include <string>
#include <vector>

namespace clothid {

// Files are written to a hidden folder inside until `Commit` moves them out. Without it the destructor removes them and
// every folder that the constructor made, and, unless a first file was begun, every journal that was not there before
// (identify/base/options.h): a fit that came to its end is not lost where its results cannot be written. One at a time:
// the folder is locked for other processes of the same machine, and for other objects, until the destructor.
class OutputFolder {
 public:
  // Makes the folder where it is missing, removes what a killed process left in the hidden one, and tries that the
  // folder can be written to, so that a fit is not run in vain. Throws `Error` (kIo), leaving nothing behind, also
  // where the folder is locked.
  explicit OutputFolder(const std::string& path);
  ~OutputFolder();
  OutputFolder(const OutputFolder&) = delete;
  OutputFolder& operator=(const OutputFolder&) = delete;

  // Where to write the file that will be called `name`.
  std::string TemporaryPath(const std::string& name);
  // Writes the whole file `name` there. Throws `Error` (kIo).
  void Write(const std::string& name, const std::string& content);
  // Keeps the journals of a fit that can be resumed.
  void KeepJournals() { keep_journals_ = true; }
  // Flushes every file to the disk, then puts them in their places, in the order in which they were asked for, each
  // replacing one that stood there, and removes all journals unless they are to be kept. Throws `Error` (kIo), as far
  // as can be told before the first is in its place.
  void Commit();

  std::string path() const { return path_.string(); }

 private:
  void MakeFolders();
  void Lock();
  void CheckPlaces() const;
  std::vector<std::filesystem::path> Journals() const;
  void RemoveAll() noexcept;

  std::filesystem::path path_, hidden_;
  int lock_ = -1;                            // a descriptor of the folder
  std::vector<std::filesystem::path> made_;  // folders, the outermost first
  std::vector<std::string> names_;
  std::vector<std::filesystem::path> old_journals_;
  bool keep_journals_ = false;
};

}  // namespace clothid

#endif  // CLOTHID_IDENTIFY_BASE_OUTPUT_FOLDER_H_

// The folder that a run writes its results to: all files or none, and none of an earlier run beside them.
#ifndef CLOTHID_IDENTIFY_BASE_OUTPUT_FOLDER_H_
#define CLOTHID_IDENTIFY_BASE_OUTPUT_FOLDER_H_

#include <filesystem>
#include <functional>
#include <string>
#include <vector>

namespace clothid {

// Whether a file of this name, without its folder, is one that a program writes as a result.
using IsResult = std::function<bool(const std::string& name)>;

// Throws `Error` (kUsage), led by `flag`, where `input` is a file of `folder` of such a name, by whatever path: the
// results would take the place of what they are made of.
void ExpectNotReplaced(const std::string& flag, const std::string& input, const std::string& folder,
                       const IsResult& is_result);

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

  // Where to write the file that will be called `name`. A folder that was removed since is made again.
  std::string TemporaryPath(const std::string& name);
  // Writes the whole file `name` there. Throws `Error` (kIo).
  void Write(const std::string& name, const std::string& content);
  // What was to become the file `name` is removed.
  void Drop(const std::string& name);
  // Has `Commit` remove the results that are not written again: they are of an earlier run.
  void RemoveOthers(const IsResult& is_result) { is_result_ = is_result; }
  // Keeps the journals of a fit that can be resumed.
  void KeepJournals() { keep_journals_ = true; }
  // Flushes every file to the disk, removes the results of an earlier run, then puts the files in their places, in the
  // order in which they were asked for, each replacing one that stood there, and removes all journals unless they are
  // to be kept. Throws `Error` (kIo), as far as can be told before anything is changed.
  void Commit();

  std::string path() const { return path_.string(); }

 private:
  void MakeFolders();
  void Lock();
  void MakeAgain();
  void CheckPlaces() const;
  void RemoveEarlier() const;
  std::vector<std::filesystem::path> Journals() const;
  void RemoveAll() noexcept;

  std::filesystem::path path_, hidden_;
  int lock_ = -1;                            // a descriptor of the folder
  std::vector<std::filesystem::path> made_;  // folders, the outermost first
  std::vector<std::string> names_;
  IsResult is_result_;  // may be empty
  std::vector<std::filesystem::path> old_journals_;
  bool keep_journals_ = false;
};

}  // namespace clothid

#endif  // CLOTHID_IDENTIFY_BASE_OUTPUT_FOLDER_H_

// Several output files that belong together: the frames of a sequence, an array and what stands beside it. Internal to
// datasets/.
#ifndef CLOTHID_DATASETS_FILES_FILE_GROUP_H_
#define CLOTHID_DATASETS_FILES_FILE_GROUP_H_

#include <filesystem>
#include <string>
#include <string_view>
#include <vector>

namespace clothid {

// Files are written to a hidden folder beside their places until `Commit` moves them there. Without it the destructor
// removes them, and what stood at their places is untouched. One writer at a time: the hidden folder is locked until
// the destructor; what a killed process left in it is removed by the next one.
class FileGroup {
 public:
  // `path` gives the group its folder, which must exist, and its name. Throws `Error` (kIo), leaving nothing behind,
  // also where another process writes the same group.
  explicit FileGroup(const std::string& path);
  ~FileGroup();
  FileGroup(const FileGroup&) = delete;
  FileGroup& operator=(const FileGroup&) = delete;

  // Writes the file that will be called `name`. Throws `Error` (kIo).
  void Write(const std::string& name, std::string_view bytes);
  // Has `Commit` remove the file `name`, if it is there: it belongs to the group that is replaced.
  void Remove(const std::string& name);
  // Removes what is to be removed and puts the files in their places, in the order in which they were written, each
  // replacing one that stood there. Throws `Error` (kIo): of what can be told beforehand, nothing is changed; should
  // the file system fail in between, the message names the first file that is not in its place.
  void Commit();

 private:
  void Lock(const std::string& path);
  void CheckPlaces() const;
  void Clear() noexcept;

  std::filesystem::path folder_, hidden_;
  int lock_ = -1;  // a descriptor of the hidden folder
  std::vector<std::string> written_, removed_;
};

}  // namespace clothid

#endif  // CLOTHID_DATASETS_FILES_FILE_GROUP_H_

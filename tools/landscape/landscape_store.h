// The cells of a scan under way, on disk.
#ifndef CLOTHID_TOOLS_LANDSCAPE_LANDSCAPE_STORE_H_
#define CLOTHID_TOOLS_LANDSCAPE_LANDSCAPE_STORE_H_

#include <string>
#include <vector>

#include "datasets/files/record_file.h"
#include "identify/landscape/landscape_folder.h"

namespace clothid {

// A hidden file in the output folder (see datasets/files/record_file.h), a record per cell: its number, seconds and
// row.
class LandscapeStore {
 public:
  static bool ExistsIn(const std::string& folder);

  // Opens or makes the store of one shard of a scan. Throws `Error` where `RecordFile` does: kUsage where it is of
  // another scan or shard. Keeps a reference to `plan`.
  LandscapeStore(const std::string& folder, const LandscapePlan& plan, const LandscapeOrigin& origin);

  // Puts the cells of the store into `landscape` and returns their numbers; to be called before `Append`. A record that
  // was torn by the end of its process is dropped. Throws `Error`: kBadData where a record is damaged or of a cell that
  // it cannot be of, kIo.
  std::vector<int> Replay(Landscape* landscape);

  // On disk, as far as the end of this process is concerned, when this returns. Throws `Error` (kIo).
  void Append(int cell, const LandscapeCell& result);

  // Removes the file: its cells stand elsewhere. Throws `Error` (kIo).
  void Remove();

 private:
  const LandscapePlan& plan_;
  LandscapeShard shard_;
  RecordFile file_;
};

}  // namespace clothid

#endif  // CLOTHID_TOOLS_LANDSCAPE_LANDSCAPE_STORE_H_

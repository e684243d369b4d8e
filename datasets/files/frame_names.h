// The files of a sequence, one per frame. Internal to datasets/.
#ifndef CLOTHID_DATASETS_FILES_FRAME_NAMES_H_
#define CLOTHID_DATASETS_FILES_FRAME_NAMES_H_

#include <string>
#include <string_view>
#include <vector>

namespace clothid {

// Whether `a` stands before `b` in natural order: runs of digits count as numbers, "frame_9" before "frame_10".
bool NaturalLess(std::string_view a, std::string_view b);

// Whether the file name of `path` has a run of '#', which stands for the number of the frame: "cloth_####.obj".
bool IsFramePattern(const std::string& path);

// The files of the sequence `path`, in natural order: a pattern, whose '#' match digits, however many; a folder, of
// which every file that ends in `extension` (".obj", in any letter case) belongs to it and files with a leading dot do
// not; else the file itself. Throws `Error`: kIo where a folder cannot be read, kUsage where there is no such file or a
// pattern has more than one run of '#', kBadData where two files have the same number.
std::vector<std::string> FramePaths(const std::string& path, const std::string& extension);

// The name of frame `number` of a pattern: the number with zeros in front up to as many digits as there are '#'.
// Without the folder.
std::string FrameName(const std::string& pattern, int number);

}  // namespace clothid

#endif  // CLOTHID_DATASETS_FILES_FRAME_NAMES_H_

// The files of a sequence, one per frame.
#ifndef CLOTHID_SIM_BASE_FRAME_NAMES_H_
#define CLOTHID_SIM_BASE_FRAME_NAMES_H_

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
// not; else the file itself. Throws `Error`: kIo where a folder cannot be read, kUsage where there is no such file, a
// pattern has more than one run of '#' or ExpectOneSequence throws, kBadData where two files have the same number.
std::vector<std::string> FramePaths(const std::string& path, const std::string& extension);

// Throws `Error` (kUsage), naming two of them, where some of the files `names` of a folder are numbered alike and
// another one is named otherwise: a second sequence, or the rest shape beside one, is no frame of it.
void ExpectOneSequence(const std::string& folder, std::vector<std::string> names);

// The numbers of the frames that the files of a sequence, in natural order, have by their names, from 0 on and in units
// of their common step: 0, 1, 3 for f10, f20 and f40. Empty where none is left out, and where names do not differ in
// one run of digits alone, or one of more than 18, which is no number of a frame.
std::vector<long long> FrameNumbers(const std::vector<std::string>& paths);

// The name of frame `number` of a pattern: the number with zeros in front up to as many digits as there are '#'.
// Without the folder.
std::string FrameName(const std::string& pattern, long long number);

}  // namespace clothid

#endif  // CLOTHID_SIM_BASE_FRAME_NAMES_H_

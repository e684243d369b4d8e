// Programs read first and write afterwards: an output under the name of an input would replace it.
#ifndef CLOTHID_DATASETS_FILES_OVERWRITE_H_
#define CLOTHID_DATASETS_FILES_OVERWRITE_H_

#include <string>
#include <vector>

namespace clothid {

// Whether both names lead to one file, through other spellings, symbolic and hard links, whether it is there yet or
// not. Devices and pipes are no files: what is written to them replaces nothing.
bool IsSameFile(const std::string& a, const std::string& b);

// Throws `Error` (kUsage), naming both, where `output` is one of the files `inputs`. Empty names stand for no file.
void RefuseOverwrite(const std::string& output, const std::vector<std::string>& inputs);

}  // namespace clothid

#endif  // CLOTHID_DATASETS_FILES_OVERWRITE_H_

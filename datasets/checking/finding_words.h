// Numbers in the words of findings. Internal to datasets/checking.
#ifndef CLOTHID_DATASETS_CHECKING_FINDING_WORDS_H_
#define CLOTHID_DATASETS_CHECKING_FINDING_WORDS_H_

#include <string>
#include <vector>

namespace clothid {

// Three digits; a length in mm; "frames 3, 7, .. (12 of them)", with "frame" for one.
std::string Rounded(double value);
std::string Millimetres(double length);
std::string Named(const std::string& what, const std::vector<int>& numbers);

}  // namespace clothid

#endif  // CLOTHID_DATASETS_CHECKING_FINDING_WORDS_H_

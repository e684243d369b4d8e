// Which clothid this is.
#ifndef CLOTHID_IDENTIFY_BASE_VERSION_H_
#define CLOTHID_IDENTIFY_BASE_VERSION_H_

#include <string>

namespace clothid {

std::string Version();  // "0.1.0"
std::string GitHash();  // of the sources at build time, with "-dirty" where they were changed; "unknown" outside of git

}  // namespace clothid

#endif  // CLOTHID_IDENTIFY_BASE_VERSION_H_

#include "identify/base/version.h"

#include "identify/base/git_hash.h"  // written by identify/base/git_hash.cmake

namespace clothid {

std::string Version() { return CLOTHID_VERSION; }

std::string GitHash() { return CLOTHID_GIT_HASH; }

}  // namespace clothid

#include "identify/version.h"

#include "identify/git_hash.h"  // written by identify/git_hash.cmake

namespace clothid {

std::string Version() { return CLOTHID_VERSION; }

std::string GitHash() { return CLOTHID_GIT_HASH; }

}  // namespace clothid

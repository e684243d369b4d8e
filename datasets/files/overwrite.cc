#include "datasets/files/overwrite.h"

#include <filesystem>
#include <system_error>

#include "datasets/files/atomic_file.h"
#include "sim/base/error.h"

namespace clothid {
namespace {

namespace fs = std::filesystem;

// Of a file that need not be there, behind the links of those folders that are.
fs::path PlaceOf(const fs::path& path) {
  std::error_code error;
  const fs::path absolute = fs::absolute(path, error);
  const fs::path place = fs::weakly_canonical(absolute, error);
  return error ? absolute : place;
}

}  // namespace

bool IsSameFile(const std::string& a, const std::string& b) {
  if (a.empty() || b.empty() || IsStream(a) || IsStream(b)) return false;
  std::error_code ignored;
  if (fs::equivalent(a, b, ignored)) return true;
  return PlaceOf(a) == PlaceOf(b);
}

void RefuseOverwrite(const std::string& output, const std::vector<std::string>& inputs) {
  for (const std::string& input : inputs) {
    if (!IsSameFile(output, input)) continue;
    throw Error(ErrorKind::kUsage, output + ": would replace " + (output == input ? "an input" : "the input " + input) +
                                       "; expected another name for the output");
  }
}

}  // namespace clothid

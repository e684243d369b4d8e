#include "identify/base/knot_names.h"

#include <cstddef>

#include "costs/prediction/parameter_block.h"

namespace clothid {
namespace {

// Whether `next` is the knot after `name`, of the same recording.
bool AreSuccessive(const std::string& name, const std::string& next) {
  const std::optional<ParameterId> id = FindKnot(name), next_id = FindKnot(next);
  return id && next_id && id->axis == next_id->axis && next_id->part == id->part + 1 &&
         name.substr(BaseName(name).size()) == next.substr(BaseName(next).size());
}

}  // namespace

std::optional<ParameterId> FindKnot(const std::string& name) {
  const std::optional<ParameterId> id = FindParameter(BaseName(name));
  return id && IsWindKnot(*id) ? id : std::nullopt;
}

std::vector<std::string> WithKnotRuns(const std::vector<std::string>& names) {
  std::vector<std::string> shorter;
  for (std::size_t first = 0, end = 0; first < names.size(); first = end) {
    for (end = first + 1; end < names.size() && AreSuccessive(names[end - 1], names[end]);) ++end;
    if (end - first < 3) {
      shorter.insert(shorter.end(), names.begin() + static_cast<std::ptrdiff_t>(first),
                     names.begin() + static_cast<std::ptrdiff_t>(end));
    } else {
      shorter.push_back(names[first] + " to " + names[end - 1]);
    }
  }
  return shorter;
}

}  // namespace clothid

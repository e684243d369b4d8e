#include "identify/prediction/prediction_options.h"

#include <map>
#include <string_view>

#include "sim/base/error.h"
#include "sim/base/text_file.h"

namespace clothid {

void SetSources(const std::string& list, const std::string& flag, PredictionOptions* options) {
  const std::map<std::string_view, bool*> sources = {{"force", &options->with_force},
                                                     {"step", &options->with_step},
                                                     {"mesh", &options->with_mesh},
                                                     {"start", &options->with_start},
                                                     {"handles", &options->with_handles}};
  for (const auto& [name, with] : sources) *with = false;
  for (const std::string& source : Split(list, ',')) {
    const auto found = sources.find(Trimmed(source));
    if (found != sources.end()) {
      *found->second = true;
    } else if (Trimmed(source) != "parameters") {
      throw Error(
          ErrorKind::kUsage,
          flag + ": expected some of parameters, force, step, mesh, start and handles, got '" + Printable(list) + "'");
    }
  }
}

}  // namespace clothid

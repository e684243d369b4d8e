#include "tools/landscape/landscape_setup.h"

#include <cstddef>

namespace clothid {

LandscapeScanOptions SetUpLandscape(const LandscapeFlags& flags, const MotionReader& read,
                                    const ReadMotionOptions& reading) {
  LandscapeScanOptions scan;
  const Scene own = read(reading).scene;
  scan.plan = MakeLandscapePlan(flags, own);
  for (std::size_t i = 0; i < scan.plan.settings.size(); ++i) {
    const LandscapeSetting& setting = scan.plan.settings[i];
    const bool is_as_before = i > 0 && scan.plan.settings[i - 1].name == setting.name;
    scan.motions.push_back(is_as_before ? scan.motions.back()
                                        : ReadMotionVariant(read, reading, ParseSweep(setting.name).front()));
    scan.motions.back().scene.contact_mode = setting.contact_mode;
  }
  CheckSweep(scan.plan, own, scan.motions);
  return scan;
}

}  // namespace clothid

// Small landscapes.
#ifndef CLOTHID_TESTS_TOOLS_LANDSCAPE_LANDSCAPE_MOTION_H_
#define CLOTHID_TESTS_TOOLS_LANDSCAPE_LANDSCAPE_MOTION_H_

#include "tests/costs/synthetic_motion.h"
#include "tools/landscape/landscape_plan.h"
#include "tools/landscape/landscape_scan.h"

namespace clothid {

// 4 x 3 cells of friction and stiffness in gap mode, and a zoom around mu = 0.3, k_stretch = 60; the recording is that
// of mu = 0.2, k_stretch = 80.
inline LandscapeScanOptions SmallScan(const std::string& contact = "gap") {
  LandscapeFlags flags;
  flags.x = "mu=0:0.6:4";
  flags.y = "k_stretch=20:180:3:log";
  flags.zoom_around = "mu=0.3,k_stretch=60";
  flags.zoom = "0.1";
  flags.contact = contact;
  RecordedMotion motion = MakeMotion(SphereScene(), {{{"mu", 0.2}, {"k_stretch", 80.0}}, 0.0, 0.03, 0.0});
  LandscapeScanOptions options;
  options.plan = MakeLandscapePlan(flags, motion.scene);
  for (const LandscapeSetting& setting : options.plan.settings) {
    motion.scene.contact_mode = setting.contact_mode;
    options.motions.push_back(motion);
  }
  return options;
}

}  // namespace clothid

#endif  // CLOTHID_TESTS_TOOLS_LANDSCAPE_LANDSCAPE_MOTION_H_

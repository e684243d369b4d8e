// The flags of simulate that are about forces at handles.
#ifndef CLOTHID_TOOLS_SIMULATE_FORCE_FLAGS_H_
#define CLOTHID_TOOLS_SIMULATE_FORCE_FLAGS_H_

#include <optional>

#include "datasets/synthetic/force_sensor.h"

namespace clothid {

// Nothing without --forces. Throws `Error` (kUsage), naming the flag.
std::optional<ForceSensor> ForceSensorFromFlags();

}  // namespace clothid

#endif  // CLOTHID_TOOLS_SIMULATE_FORCE_FLAGS_H_

// What `identify --wind_profile 8:xy` asks for: a wind that changes over the time of every recording, piecewise linear
// between knots that are fitted (sim/air/wind.h).
#ifndef CLOTHID_IDENTIFY_WIND_WIND_REQUEST_H_
#define CLOTHID_IDENTIFY_WIND_WIND_REQUEST_H_

#include <array>
#include <string>
#include <vector>

#include "datasets/motion/recorded_motion.h"
#include "identify/base/options.h"

namespace clothid {

struct WindRequest {
  int num_knots = 0;  // 0: nothing is asked for
  std::array<bool, 3> axes = {true, true, true};

  bool is_given() const { return num_knots > 0; }
};

inline constexpr double kFirstWindSmoothness = 0.3;  // m/s in a second, where it is chosen
inline constexpr int kMaxFittedKnots = 200;          // of one component

// "8", or "8:xy" for some components alone; empty: nothing. Throws `Error` (kUsage).
WindRequest ParseWindRequest(const std::string& text);

// Gives the scene of every recording a profile with knots evenly over its frames, where the wind is what it was; the
// mean of the asked components becomes part of it, so that its knots are the wind itself. Where the scene had a
// profile already, it is sampled at the knots.
void SetWindProfile(const WindRequest& request, std::vector<RecordedMotion>* motions);

// Has every recording fit knots of its own. Throws `Error` (kUsage) for parameters beside which they are not told.
void AddKnots(const WindRequest& request, FitOptions* options);

}  // namespace clothid

#endif  // CLOTHID_IDENTIFY_WIND_WIND_REQUEST_H_

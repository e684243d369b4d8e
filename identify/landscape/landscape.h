// The cost over two parameters: what is scanned, and what was found.
//
// A scan has settings (variants of the scene, in one contact mode each), windows (the whole of both axes and zooms into
// it) and a grid of cells in every window of every setting. Cells are numbered in this order, x fastest:
//   cell = ((setting * windows + window) * y.num_cells + iy) * x.num_cells + ix.
#ifndef CLOTHID_IDENTIFY_LANDSCAPE_LANDSCAPE_H_
#define CLOTHID_IDENTIFY_LANDSCAPE_LANDSCAPE_H_

#include <limits>
#include <map>
#include <string>
#include <vector>

#include "costs/assimilation/assimilation.h"
#include "costs/prediction/parameter_block.h"
#include "datasets/motion/recorded_motion.h"
#include "datasets/observation/model_error.h"
#include "sim/rollout/rollout.h"
#include "sim/scene/scene.h"

namespace clothid {

// More cells than a scan may have are a slip of the hand. In memory they take half a gigabyte.
inline constexpr int kMaxLandscapeCells = 4'000'000;

// Values of one parameter, evenly spaced in its own scale, from `lower` to `upper`, both included.
struct LandscapeAxis {
  std::string parameter;  // as `ParseParameter` reads it
  ParameterScale scale = ParameterScale::kLinear;
  double lower = 0.0, upper = 0.0;  // in the parameter's own unit
  int num_cells = 0;                // at least 2

  double Value(int index) const;  // index 0: exactly `lower`; num_cells - 1: exactly `upper`
};

// A part of the plane of both parameters.
struct LandscapeWindow {
  double zoom = 1.0;  // its share of either axis; 1: the whole
  LandscapeAxis x, y;
};

// A variant of the scene.
struct LandscapeSetting {
  std::string name;  // "ball.center.x=0.05" or "ball.center.x=0.05;touch=1e-05"; empty: the scene as it is
  ContactMode contact_mode = ContactMode::kGap;
};

// "gap" or "velocity".
std::string ContactModeName(ContactMode mode);

// Where a cell stands.
struct LandscapePlace {
  int setting = 0, window = 0, ix = 0, iy = 0;
};

struct LandscapePlan {
  std::vector<LandscapeSetting> settings;
  std::vector<LandscapeWindow> windows;  // the whole first, then by falling zoom; all of the same numbers of cells
  bool has_gradients = false;

  int cells_per_window() const { return windows.front().x.num_cells * windows.front().y.num_cells; }
  int num_cells() const;
  LandscapePlace PlaceOf(int cell) const;
  int FirstCell(int setting, int window) const;
};

// The part of a scan that one process does: the cells `index`, `index` + `count`, ..
struct LandscapeShard {
  int index = 0;
  int count = 1;

  bool is_whole() const { return count == 1; }
  std::vector<int> Cells(const LandscapePlan& plan) const;  // in their order
};

struct LandscapeCell {
  double cost = std::numeric_limits<double>::quiet_NaN();  // L; NaN: the rollout failed
  std::string failure;                                     // why, one line; empty: it did not
  RolloutCounts counts;
  // dL/dx and dL/dy by the adjoint, each in the scale of its axis (d/d log value on a log axis); NaN where not asked
  // for or failed.
  double gradient_x = std::numeric_limits<double>::quiet_NaN();
  double gradient_y = std::numeric_limits<double>::quiet_NaN();
  double seconds = 0.0;  // of this cell; no part of the result
};

struct Landscape {
  LandscapePlan plan;
  std::vector<LandscapeCell> cells;  // [plan.num_cells()]
};

// One recording of the fit whose cost was scanned (`landscape --result`). A scan of no fit holds nothing and weighs all
// frames alike.
struct ScannedFit {
  std::map<std::string, double> held;  // estimates, "drag" that of "drag@2" in the second recording of the fit
  ModelError model_error;              // that frames are weighed by (datasets/observation/model_error.h)
  Assimilation assimilation;           // how the recording corrects the rollouts
};

// The standard deviation by which the costs of a scan were weighed, and what they say of the error in metres.
struct LandscapeSigma {
  SigmaSource source = SigmaSource::kUnknown;
  // m, of a coordinate; where nobody knows it, what `Observation` takes for it. NaN: points differ.
  double value = std::numeric_limits<double>::quiet_NaN();
  double rmse_of_root_cost = std::numeric_limits<double>::quiet_NaN();  // m, see `RmseOfRootCost`
};

// That of the residuals of `motion`. Throws `Error` where `Observation` does.
LandscapeSigma SigmaOf(const RecordedMotion& motion);

// Whether both weigh the residuals of the same recording alike.
bool IsSameSigma(const LandscapeSigma& a, const LandscapeSigma& b);

// m: the factor between the root mean square distance of seen points and the square root of the cost without a loss,
//   rmse = sigma sqrt(2 L/n),   n the seen coordinates over 3, and the points of clouds; NaN unless all have
//   one sigma, and where forces, or distances to the border, are part of the cost.
double RmseOfRootCost(const RecordedMotion& motion);

}  // namespace clothid

#endif  // CLOTHID_IDENTIFY_LANDSCAPE_LANDSCAPE_H_

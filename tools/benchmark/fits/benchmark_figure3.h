// benchmark figure3: how the rate of contact events and the contact mode shape the landscape of a fit.
//
// The experiment of Figure 3 of the DiffCloth paper (section 5.1): a cloth hung by one edge falls on a static sphere,
// and friction and stiffness are to be found from its motion. The sphere stands at several horizontal offsets, so that
// contacts begin and end more or less often. Each offset is scanned in gap mode and, for each of several values of
// `touch`, in velocity mode, over the whole range of both parameters and in zooms around the truth; and both parameters
// are fitted from a grid of starts, as in benchmark jacobian, which says when a fit counts. Truth and model are of the
// same setting, so the lowest cost is 0 at the truth.
#ifndef CLOTHID_TOOLS_BENCHMARK_FITS_BENCHMARK_FIGURE3_H_
#define CLOTHID_TOOLS_BENCHMARK_FITS_BENCHMARK_FIGURE3_H_

#include <cstdint>
#include <functional>
#include <string>
#include <vector>

#include "sim/scene/scene.h"
#include "tools/benchmark/derivatives/benchmark_jacobian.h"
#include "tools/landscape/landscape_summary.h"

namespace clothid {

inline constexpr double kFigure3Friction = 0.25, kFigure3Stiffness = 70.0;  // 1, N/m: the truth
// The whole of both axes; the starts of the fits lie in it, on an even grid without its edges.
inline constexpr double kFigure3LowestFriction = 0.0, kFigure3HighestFriction = 0.6;        // 1
inline constexpr double kFigure3LowestStiffness = 10.0, kFigure3HighestStiffness = 1000.0;  // N/m, logarithmic

struct Figure3Options {
  std::vector<double> offsets = {0.0, 0.05, 0.1, 0.15, 0.2, 0.25, 0.3, 0.35};  // m, of the sphere, along the held edge
  std::vector<double> touches = {1e-5, 1e-3};       // of velocity mode; gap mode has no such thing
  std::vector<double> zooms = {0.03, 0.01, 0.003};  // shares of both axes, falling
  int cells = 33;                                   // per axis of a window
  std::string integrator = "euler";                 // of truth and model
  int starts_per_axis = 5;                          // of the fits; 0: none
  double noise = 0.01;     // of the recordings of further fits, relative to the cloth's size; 0: none of these
  std::uint64_t seed = 1;  // of the noise
  // For the files of the landscape, see tools/landscape/landscape_files.h. Cells are kept there as they are done, and
  // those that an earlier run of the same scan has kept are taken over. Empty: none.
  std::string folder;
  int num_threads = 1;  // results do not depend on it
  // After every cell and every fit. May be empty.
  std::function<void(const std::string& what, int num_done, int num_items)> on_progress;

  // Throws `Error` (kUsage) naming the first flag out of range.
  void Validate() const;
};

// One offset in one mode.
struct Figure3Setting {
  double offset = 0.0;  // m
  ContactMode contact_mode = ContactMode::kGap;
  double touch = 0.0;  // relative to the cloth's size; 0 in gap mode

  std::string Name() const;  // "ball.center.x=0.05;touch=1e-05"
};

struct Figure3 {
  std::vector<Figure3Setting> settings;  // by offset, then gap mode, then velocity mode by touch
  LandscapeSummary summary;              // the whole and the zooms of every setting
  std::vector<double> noises;            // 0 and, where there is one, that of the options
  std::vector<JacobianFit> fits;         // of (mu, k_stretch), by setting, noise, start
};

Figure3 RunFigure3(const Figure3Options& options);

}  // namespace clothid

#endif  // CLOTHID_TOOLS_BENCHMARK_FITS_BENCHMARK_FIGURE3_H_

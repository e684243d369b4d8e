#include <gflags/gflags.h>

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <iostream>
#include <string>
#include <vector>

#include "datasets/curves/cantilever.h"
#include "datasets/curves/heavy_elastica.h"
#include "datasets/files/atomic_file.h"
#include "datasets/files/overwrite.h"
#include "datasets/motion/motion_file.h"
#include "datasets/motion/motion_name.h"
#include "sim/base/error.h"
#include "sim/base/text_file.h"
#include "tools/motion/curve_flags.h"
#include "tools/motion/motion_commands.h"
#include "tools/motion/repeated_value.h"
#include "tools/motion/track_flags.h"

DECLARE_double(sigma);
DECLARE_string(direction);
DEFINE_double(density, 0.0, "convert_cantilever: mass per area, kg/m^2");

DEFINE_double(overhang, 0.0, "convert_cantilever: length of the strip of a profile from the edge to the tip, mm");

namespace clothid {
namespace {

constexpr double kGravity = 9.81;      // m/s^2, of scenes
constexpr double kMostDensity = 10.0;  // kg/m^2: who gives more, gives g/m^2
constexpr double kSlenderness = 0.125;
constexpr double kSigmaOfRuler = 1e-3, kLeastSigma = 1e-4;  // m, of a place that was measured

// What a table of overhangs and angles tells, of the logarithm of the rigidity.
struct Rigidity {
  RepeatedValue logarithm;
  double value() const { return std::exp(logarithm.mean); }  // N m
};

Rigidity RigidityOf(const Eigen::VectorXd& bending_lengths, double density) {
  return {MeanOfRepetitions((density * kGravity * bending_lengths.array().cube()).log())};
}

Eigen::Vector2d TipAt(double log_rigidity, const CantileverStrip& strip) {
  const double length = std::cbrt(std::exp(log_rigidity) / (strip.density * kGravity));
  const SaggingStrip sag = SagOfBendingLength(length / strip.overhang);
  return strip.overhang * Eigen::Vector2d(sag.tip_x, sag.tip_z);
}

// m, so that a fit of the tip has the interval of the repetitions.
double SigmaOfTip(const Rigidity& rigidity, const CantileverStrip& strip) {
  if (FLAGS_sigma > 0.0) return FLAGS_sigma;
  if (!rigidity.logarithm.is_repeated()) return kSigmaOfRuler;
  constexpr double kDifference = 1e-3;
  const double mean = rigidity.logarithm.mean;
  const double way = (TipAt(mean + kDifference, strip) - TipAt(mean - kDifference, strip)).norm() / (2.0 * kDifference);
  return std::max(way * rigidity.logarithm.mean_std, kLeastSigma);
}

CantileverStrip StripFromFlags(const Rigidity& rigidity, double overhang) {
  CantileverStrip strip;
  strip.overhang = overhang;
  strip.density = FLAGS_density;
  strip.nominal = std::pow(10.0, std::round(std::log10(rigidity.value())));
  strip.has_warp = IsGivenFlag("direction");
  if (strip.has_warp) strip.direction = PullDirectionFromFlag();
  return strip;
}

// A bias strip has a rigidity of its own, to which all three constants of the scene add.
bool IsBias(const CantileverStrip& strip) { return strip.has_warp && strip.direction == PullDirection::kBias; }

void PrintRigidity(const CantileverTable& table, const Rigidity& rigidity, const CantileverStrip& strip) {
  const std::string name = IsBias(strip) ? "rigidity along the bias" : ParameterOfCantilever(strip);
  const RepeatedValue& logarithm = rigidity.logarithm;
  const double length = std::cbrt(rigidity.value() / (FLAGS_density * kGravity));
  std::cout << "bending length " << 1e3 * length << " mm" << (table.is_profile() ? ", by the tip alone" : "")
            << (table.is_bench_angle ? " at 41.5 degrees, as the table has no angles" : "") << "; " << name << " "
            << rigidity.value() << " N m";
  if (logarithm.is_repeated()) {
    std::cout << ", 95 % interval " << std::exp(logarithm.mean - logarithm.half95) << " .. "
              << std::exp(logarithm.mean + logarithm.half95) << ", of " << logarithm.count << " tests";
    if (!IsBias(strip)) {
      std::cout << "\nas what is believed of the next specimen: identify --prior " << name << "=" << rigidity.value()
                << ":" << std::exp(logarithm.next_std);
    }
  }
  std::cout << "\n";
}

}  // namespace

int MotionConvertCantilever(const std::vector<std::string>& arguments) {
  const std::string &input = arguments[0], &output = arguments[1];
  ExpectMotionName(output);
  RefuseOverwrite(output, {input});
  CheckFileCanBeWritten(output);
  if (!(FLAGS_density > 0.0 && FLAGS_density <= kMostDensity)) {
    FailFlag("density", "expected the mass per area, kg/m^2, > 0 and at most 10: 0.15 is 150 g/m^2");
  }
  if (IsGivenFlag("sigma") && !(FLAGS_sigma > 0.0)) FailFlag("sigma", "expected a number > 0 (m)");
  if (IsGivenFlag("overhang") && !(FLAGS_overhang > 0.0)) FailFlag("overhang", "expected a number > 0 (mm)");
  CantileverTable table = ReadCantileverTable(input);
  if (IsGivenFlag("overhang")) {
    if (!table.is_profile()) FailFlag("overhang", "expected with a profile alone: " + input + " has overhangs");
    table.overhangs[0] = 1e-3 * FLAGS_overhang;
  }
  const Rigidity rigidity = RigidityOf(table.BendingLengths(), FLAGS_density);
  CantileverStrip strip = StripFromFlags(rigidity, table.overhangs.mean());
  const std::string provenance =
      "cantilever test of " + std::filesystem::path(input).filename().string() + ", " + table.columns;
  if (table.is_profile()) {
    strip.sigma = FLAGS_sigma > 0.0 ? FLAGS_sigma : kSigmaOfRuler;
    // The width of a strip that does not twist changes nothing; all of its clamp should lie near the profile.
    if (!IsBias(strip)) strip.width = kSlenderness * strip.overhang;
    WriteMotion(RecordProfile(table.profile, strip, provenance), output);
  } else {
    strip.sigma = SigmaOfTip(rigidity, strip);
    WriteMotion(RecordCantilever(TipAt(rigidity.logarithm.mean, strip), strip, provenance), output);
  }
  std::cout << output << ": "
            << (table.is_profile() ? std::to_string(table.profile.cols()) + " points" : std::string("the tip"))
            << " of a strip at rest that overhangs by " << 1e3 * strip.overhang << " mm, sigma " << 1e3 * strip.sigma
            << " mm\n"
            << "columns " << table.columns << (table.is_turned ? ", taken downwards" : "") << "\n";
  PrintRigidity(table, rigidity, strip);
  if (IsBias(strip)) {
    std::cout << "fit it beside strips along warp and weft: identify --target WARP,WEFT," << output
              << " --fit bend_warp,bend_weft,bend_twist\n";
  } else {
    std::cout << "fit it: identify --target " << output << " --fit " << ParameterOfCantilever(strip) << "\n";
  }
  return kExitSuccess;
}

}  // namespace clothid

#include "sim/fabric/fabric.h"

#include <algorithm>

#include "sim/base/error.h"
#include "sim/base/json_document.h"
#include "sim/base/text_file.h"

namespace clothid {
namespace {

constexpr MeasuredConstant kUnknown;

// How far beyond what was measured any other cloth is taken to lie at most. Every tenth fabric lies beyond quantiles,
// a coated one of 2 mN m 18 times; the extremes are of ten fabrics.
constexpr double kReachOfQuantiles = 30.0, kReachOfExtremes = 5.0;
constexpr char kDensityUnit[] = "kg/m^2", kStretchUnit[] = "N/m", kRigidityUnit[] = "N m";

// 618 fabrics, measured with the DrapeTester: 5 %, 50 % and 95 % of them lie below. The rigidity is that along the
// warp.
constexpr MeasuredConstant kDensityOf618 = {0.197, 0.031, 0.488, kReachOfQuantiles, kDensityUnit};
constexpr MeasuredConstant kRigidityOf618 = {1.4e-5, 1.1e-6, 1.1e-4, kReachOfQuantiles, kRigidityUnit};

// The others are of Wang, O'Brien and Ramamoorthi, "Data-driven elastic models for cloth", ACM Transactions on Graphics
// 30(4), 2011, from their files of ten fabrics, named here as there. Stretch: geometric mean of C11 and C22 at small
// strain; the range is from the lesser of the two to the largest entry at 17 % strain. The entries of the files belong
// to the strain F^T F - I, which is twice Green's: ARCSim, the simulator of that group, doubles each before it
// multiplies it by (F^T F - I)/2 (evaluate_stretching_sample in src/dde.cpp). So are they here: k_stretch is tension
// over strain. Bending: mean, least and largest of 15 measurements, in 3 directions at 5 curvatures.
//   gray-interlock:    0.187 kg/m^2;  47.8 (33.2 .. 827) N/m;   2.18e-5 (7.1e-6 .. 3.9e-5) N m
//   ivory-rib-knit:    0.276 kg/m^2;  106 (85.8 .. 510) N/m;    4.63e-5 (2.5e-5 .. 9.8e-5) N m
//   camel-ponte-roma:  0.284 kg/m^2;  74.0 (62.2 .. 538) N/m;   3.31e-5 (1.0e-5 .. 5.0e-5) N m
//   11oz-black-denim:  0.324 kg/m^2;  912 (410 .. 2120) N/m;    7.23e-5 (2.0e-5 .. 1.2e-4) N m
// The first three are knits: geometric means, and the range of all of them.
constexpr MeasuredConstant kDensityOfKnits = {0.245, 0.187, 0.284, kReachOfExtremes, kDensityUnit};
constexpr MeasuredConstant kStretchOfKnits = {72.0, 33.2, 827.0, kReachOfExtremes, kStretchUnit};
constexpr MeasuredConstant kRigidityOfKnits = {3.2e-5, 7.1e-6, 9.8e-5, kReachOfExtremes, kRigidityUnit};
constexpr MeasuredConstant kDensityOfDenim = {0.324, 0.324, 0.324, kReachOfExtremes, kDensityUnit};
constexpr MeasuredConstant kStretchOfDenim = {912.0, 410.0, 2120.0, kReachOfExtremes, kStretchUnit};
constexpr MeasuredConstant kRigidityOfDenim = {7.23e-5, 2.0e-5, 1.2e-4, kReachOfExtremes, kRigidityUnit};

// Along warp and weft, of the same files: entries at small strain, twice those of the files. Their shear is a product
// of a single entry of Green's strain, so k_shear is half of it. A yarn stiffens as the entry at 16.7 % along it says:
// its tension there is lambda 2 C E, E Green's strain, and stiffening beta is such that k (exp(beta e) - 1)/beta is the
// same at e = 1/6. k_warp, k_weft, k_shear, N/m; stiffening along warp and weft:
//   gray-interlock:    33.2, 69.0, 18.4;  12.9, 24.8
//   ivory-rib-knit:    85.7, 130, 41.6;   4.89, 15.9
//   camel-ponte-roma:  62.3, 88.1, 15.9;  12.0, 16.8
//   11oz-black-denim:  411, 2030, 26.7;   4.05, 3.11
// The entries that couple warp and weft are below zero for the three knits at small strain, and left out.
constexpr MeasuredConstant kWarpOfKnits = {56.2, 33.2, 85.7, kReachOfExtremes, kStretchUnit};
constexpr MeasuredConstant kWeftOfKnits = {92.5, 69.0, 130.0, kReachOfExtremes, kStretchUnit};
constexpr MeasuredConstant kShearOfKnits = {23.0, 15.9, 41.6, kReachOfExtremes, kStretchUnit};
constexpr MeasuredConstant kWarpStiffeningOfKnits = {9.12, 4.89, 12.9, kReachOfExtremes, ""};
constexpr MeasuredConstant kWeftStiffeningOfKnits = {18.8, 15.9, 24.8, kReachOfExtremes, ""};
constexpr MeasuredConstant OfDenim(double value, const char* unit) {
  return {value, value, value, kReachOfExtremes, unit};
}

// Of the ten at small strain: navy-sparkle-sweat 6.54 N/m across, royal-target 4070 N/m across.
constexpr MeasuredConstant kStretchOfTen = {kUnknown.typical, 6.54, 4070.0, kReachOfExtremes, kStretchUnit};

// A fabric that is light is taken to be soft, too: the quantiles are of density and rigidity each.
constexpr MeasuredConstant At(const MeasuredConstant& range, double typical) {
  return {typical, range.lowest, range.highest, range.reach, range.unit};
}

}  // namespace

const std::vector<Fabric>& Fabrics() {
  static const std::vector<Fabric> fabrics = {
      {"light", "of 618 fabrics 5 % are lighter, and 5 % softer in bending", At(kDensityOf618, kDensityOf618.lowest),
       kUnknown, At(kRigidityOf618, kRigidityOf618.lowest)},
      {"medium", "of 618 fabrics half are lighter, and half softer in bending", kDensityOf618, kUnknown,
       kRigidityOf618},
      {"heavy", "of 618 fabrics 5 % are heavier, and 5 % stiffer in bending", At(kDensityOf618, kDensityOf618.highest),
       kUnknown, At(kRigidityOf618, kRigidityOf618.highest)},
      {"knit", "the mean of an interlock, a rib knit and a ponte roma", kDensityOfKnits, kStretchOfKnits,
       kRigidityOfKnits, kWarpOfKnits, kWeftOfKnits, kShearOfKnits, kWarpStiffeningOfKnits, kWeftStiffeningOfKnits},
      {"denim", "black denim of 11 oz", kDensityOfDenim, kStretchOfDenim, kRigidityOfDenim,
       OfDenim(411.0, kStretchUnit), OfDenim(2030.0, kStretchUnit), OfDenim(26.7, kStretchUnit), OfDenim(4.05, ""),
       OfDenim(3.11, "")}};
  return fabrics;
}

const Fabric* FindFabric(const std::string& name) {
  const auto found =
      std::find_if(Fabrics().begin(), Fabrics().end(), [&](const Fabric& fabric) { return name == fabric.name; });
  return found == Fabrics().end() ? nullptr : &*found;
}

std::string FabricNames() {
  std::string names;
  for (const Fabric& fabric : Fabrics()) names += (names.empty() ? "" : ", ") + std::string(fabric.name);
  return names;
}

const Fabric& AnyFabric() {
  static const Fabric any = {"any",          "all that was measured", kDensityOf618, kStretchOfTen,
                             kRigidityOf618, kStretchOfTen,           kStretchOfTen, kStretchOfTen};
  return any;
}

std::string WithFabric(const std::string& scene_text, const std::string& name, const std::string& flag,
                       const std::string& source) {
  if (FindFabric(name) == nullptr) {
    throw Error(ErrorKind::kUsage, flag + ": expected one of " + FabricNames() + ", got '" + Printable(name) + "'");
  }
  const JsonValue root = ParseJson(scene_text, source);
  const std::size_t begin = scene_text.find('{');
  if (root.kind != JsonValue::Kind::kObject || begin == std::string::npos) return scene_text;  // its reader complains
  const auto own = std::find(root.keys.begin(), root.keys.end(), "fabric");
  if (own != root.keys.end()) {
    const std::string& of_scene = root.items[static_cast<std::size_t>(own - root.keys.begin())].text;
    if (of_scene == name) return scene_text;
    throw Error(ErrorKind::kUsage,
                flag + ": expected none, as " + source + " has \"fabric\": \"" + Printable(of_scene) + "\" of its own");
  }
  const std::string member = "\"fabric\": \"" + name + (root.keys.empty() ? "\"" : "\", ");
  return scene_text.substr(0, begin + 1) + member + scene_text.substr(begin + 1);
}

}  // namespace clothid

// What cloth is made of, as far as somebody has measured it: constants that stand in for those that nobody gives, and
// the ranges in which those of any cloth lie. Every number has its source beside it in fabric.cc.
#ifndef CLOTHID_SIM_FABRIC_FABRIC_H_
#define CLOTHID_SIM_FABRIC_FABRIC_H_

#include <limits>
#include <string>
#include <vector>

namespace clothid {

// One constant of a kind of cloth. NaN: not measured.
struct MeasuredConstant {
  double typical = std::numeric_limits<double>::quiet_NaN();
  double lowest = std::numeric_limits<double>::quiet_NaN(), highest = std::numeric_limits<double>::quiet_NaN();
  double reach =
      std::numeric_limits<double>::quiet_NaN();  // a factor: cloth that was not measured may lie so far beyond
  const char* unit = "";

  // Whether `value` lies farther beyond than that; false where nothing was measured.
  bool IsFarFrom(double value) const { return value < lowest / reach || value > highest * reach; }
};

struct Fabric {
  const char* name;
  const char* what;            // one line
  MeasuredConstant density;    // kg/m^2
  MeasuredConstant k_stretch;  // N/m
  MeasuredConstant k_bend;     // flexural rigidity, N m
  // N/m, of a membrane with warp and weft, and with what factor yarns stiffen.
  MeasuredConstant k_warp = {}, k_weft = {}, k_shear = {}, stiffening_warp = {}, stiffening_weft = {};
};

const std::vector<Fabric>& Fabrics();
// Null where there is none of that name.
const Fabric* FindFabric(const std::string& name);
std::string FabricNames();  // "light, medium, .."

// All kinds of cloth together; `typical` is the median or, of k_stretch, not told.
const Fabric& AnyFabric();

// The text of a scene with "fabric": "NAME" in its first line. Throws `Error` (kUsage), naming `flag`, where there is
// no such fabric or the scene names another, and kBadData for a text that is no JSON object, named `source`.
std::string WithFabric(const std::string& scene_text, const std::string& name, const std::string& flag,
                       const std::string& source);

}  // namespace clothid

#endif  // CLOTHID_SIM_FABRIC_FABRIC_H_

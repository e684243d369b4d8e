// Curves of testing machines, and the recordings that are made of them.
#include "datasets/curves/cantilever.h"
#include "datasets/curves/curve_table.h"
#include "datasets/curves/tensile_curve.h"
#include "datasets/curves/tensile_recording.h"
#include "tests/fuzz/fuzz_target.h"

namespace clothid {
namespace {

void FuzzCantilever(const std::string& path) {
  CantileverTable table;
  if (!Accepts([&] { table = ReadCantileverTable(path); }, path)) return;
  Check(table.BendingLengths().allFinite() && table.BendingLengths().minCoeff() > 0.0, "bending lengths");
  CantileverStrip strip;
  strip.overhang = table.overhangs.mean();
  strip.density = 0.15;
  strip.sigma = 1e-3;
  strip.nominal = 1e-4;
  if (table.is_profile()) Accepts([&] { RecordProfile(table.profile, strip, path); }, path);
}

}  // namespace
}  // namespace clothid

int clothid::FuzzCurve(const std::uint8_t* data, std::size_t size) {
  static const MemoryFile file;
  file.Write(AsText(data, size));
  FuzzCantilever(file.path());
  CurveTable table;
  if (!Accepts([&] { table = ReadCurveTable(file.path()); }, file.path())) return 0;
  Check(table.forces.size() > 0 && table.forces.size() == table.elongations.size(), "readings");
  Check(table.forces.allFinite() && table.elongations.allFinite(), "finite readings");
  TensileCurveOptions options;
  if (!table.width) options.width = 0.05;
  if (!table.gauge_length) options.length = 0.2;
  TensileCurve curve;
  if (!Accepts([&] { curve = MakeTensileCurve(table, options); }, file.path())) return 0;
  Check(curve.strains.size() <= options.max_readings && curve.strains.minCoeff() >= 0.0, "strains of a loading");
  Check(curve.num_outside >= 0, "no reading counted twice");
  Check(curve.num_slack + curve.num_after + curve.num_outside + curve.num_thinned == table.forces.size(),
        "an account of every reading");
  TensileStrip strip;
  strip.nodes = {2, 3};
  Accepts([&] { RecordTensileTest(curve, strip, file.path()); }, file.path());
  return 0;
}

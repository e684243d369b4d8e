#include <gflags/gflags.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <filesystem>
#include <iostream>
#include <optional>
#include <string>
#include <vector>

#include "datasets/checking/motion_check.h"
#include "datasets/curves/curve_findings.h"
#include "datasets/curves/tensile_recording.h"
#include "datasets/files/atomic_file.h"
#include "datasets/files/overwrite.h"
#include "datasets/motion/motion_file.h"
#include "datasets/motion/motion_name.h"
#include "sim/base/error.h"
#include "sim/base/text_file.h"
#include "tools/motion/curve_flags.h"
#include "tools/motion/motion_commands.h"
#include "tools/motion/track_flags.h"

DECLARE_double(force_sigma);
DEFINE_string(specimen, "", "convert_curve: WIDTHxLENGTH of the specimen between the clamps, mm");
DECLARE_string(direction);
DEFINE_double(gauge, 0.0, "convert_curve: length over which the elongation was measured, mm; 0: that of the specimen");
DEFINE_string(strain, "", "convert_curve: FROM:TO, the strains that are kept");
DEFINE_double(preload, 0.0, "convert_curve: force that ends the slack, N; 0: a share of the largest");
DEFINE_string(membrane, "yarn", "convert_curve: yarn or orthotropic");
DEFINE_string(nodes, "", "convert_curve: nodes of the strip, across x along the pull");

namespace clothid {
namespace {

constexpr double kMillimetre = 1e-3;  // m

// "95.9x45.2" or "0.02:0.25".
std::array<double, 2> ParsePair(const std::string& flag, const std::string& text, char separator,
                                const std::string& expected) {
  const std::vector<std::string> words = Split(text, separator);
  const std::optional<double> first = ParseNumber(words.front()), last = ParseNumber(words.back());
  if (words.size() != 2 || !first || !last) {
    FailFlag(flag, "expected " + expected + ", got '" + Printable(text) + "'");
  }
  return {*first, *last};
}

void ExpectPositiveFlag(const char* flag, double value, const char* unit) {
  if (IsGivenFlag(flag) && !(value > 0.0)) FailFlag(flag, std::string("expected a number > 0 (") + unit + ")");
}

TensileCurveOptions CurveOptionsFromFlags() {
  TensileCurveOptions options;
  if (IsGivenFlag("specimen")) {
    const char* const expected = "WIDTHxLENGTH in mm, as in 50x200";
    const std::array<double, 2> size = ParsePair("specimen", FLAGS_specimen, 'x', expected);
    if (!(size[0] > 0.0) || !(size[1] > 0.0)) {
      FailFlag("specimen", std::string("expected ") + expected + ", got '" + Printable(FLAGS_specimen) + "'");
    }
    options.width = kMillimetre * size[0];
    options.length = kMillimetre * size[1];
  }
  ExpectPositiveFlag("gauge", FLAGS_gauge, "mm");
  ExpectPositiveFlag("preload", FLAGS_preload, "N");
  ExpectPositiveFlag("force_sigma", FLAGS_force_sigma, "N");
  options.gauge_length = kMillimetre * FLAGS_gauge;
  options.preload = FLAGS_preload;
  options.force_sigma = FLAGS_force_sigma;
  if (IsGivenFlag("strain")) {
    const char* const expected = "FROM:TO with 0 <= FROM < TO, as in 0.02:0.25";
    const std::array<double, 2> range = ParsePair("strain", FLAGS_strain, ':', expected);
    if (!(range[0] >= 0.0 && range[0] < range[1])) {
      FailFlag("strain", std::string("expected ") + expected + ", got '" + Printable(FLAGS_strain) + "'");
    }
    options.least_strain = range[0];
    options.most_strain = range[1];
  }
  return options;
}

std::optional<std::array<int, 2>> NodesFromFlag() {
  if (!IsGivenFlag("nodes")) return std::nullopt;
  const std::vector<std::string> counts = Split(FLAGS_nodes, 'x');
  const std::optional<long long> across = ParseInteger(counts.front()), along = ParseInteger(counts.back());
  constexpr long long kMostNodes = 1000;
  if (counts.size() != 2 || !across || !along || *across < 2 || *along < 3 || *across > kMostNodes ||
      *along > kMostNodes) {
    FailFlag("nodes",
             "expected NXxNY with at least 2 nodes across and 3 along the pull, at most 1000, as in 9x9, got '" +
                 Printable(FLAGS_nodes) + "'");
  }
  return std::array<int, 2>{static_cast<int>(*across), static_cast<int>(*along)};
}

TensileStrip StripFromFlags() {
  TensileStrip strip;
  strip.direction = PullDirectionFromFlag();
  if (FLAGS_membrane != "yarn" && FLAGS_membrane != "orthotropic") {
    FailFlag("membrane", "expected yarn or orthotropic, got '" + Printable(FLAGS_membrane) + "'");
  }
  strip.membrane = FLAGS_membrane == "yarn" ? MembraneLaw::kYarn : MembraneLaw::kOrthotropic;
  return strip;
}

// To a nanometre, so that rounding does not show; never "-0".
double InMillimetres(double metres) { return std::round(1e9 * metres) / 1e6 + 0.0; }

std::string CurveProvenance(const std::string& input, const CurveTable& table) {
  return "curve of " + std::filesystem::path(input).filename().string() + ", " + table.columns + ", along " +
         FLAGS_direction;
}

void PrintCurve(const std::string& output, const CurveTable& table, const TensileCurve& curve,
                const TensileStrip& strip) {
  const auto readings = [](int count) { return std::to_string(count) + (count == 1 ? " reading" : " readings"); };
  const Eigen::Index last = curve.strains.size() - 1;
  std::cout << output << ": " << last + 1 << " forces, the means of " << readings(curve.num_thinned) << ", "
            << curve.forces[0] << " to " << curve.forces[last] << " N at strains of " << 100.0 * curve.strains[0]
            << " to " << 100.0 * curve.strains[last] << " %, sigma " << curve.force_sigma << " N"
            << (curve.is_sigma_estimated ? " (their scatter)" : "") << "\n"
            << "columns " << table.columns << "\n"
            << "strip " << 1e3 * curve.width << " x " << 1e3 * curve.length << " mm at rest, " << strip.nodes[0]
            << " x " << strip.nodes[1] << " nodes, pulled along the " << FLAGS_direction << "; inertia at most "
            << InertiaAtClamp(curve) << " N\n";
  if (curve.widths.size() > 0) {
    std::cout << "width " << 1e3 * curve.rest_width << " mm between the marks at rest, " << 1e3 * curve.widths[last]
              << " mm at the end, sigma " << 1e3 * curve.width_sigma << " mm (its scatter)\n";
  }
  if (curve.has_slack) {
    std::cout << "left out: " << readings(curve.num_slack) << " of slack, before a preload of " << curve.preload
              << " N; strain counts from an elongation of " << InMillimetres(curve.slack) << " mm\n";
  } else {
    std::cout << "no slack: the first force is above the preload of " << curve.preload
              << " N; strain counts from an elongation of 0\n";
  }
  if (curve.num_after > 0) {
    std::cout << "left out: " << readings(curve.num_after) << " after the end of the loading"
              << (curve.returns_to_more ? ", among them larger elongations, of a later loading" : "") << "\n";
  }
  if (curve.num_outside > 0) {
    std::cout << "left out: " << readings(curve.num_outside) << " at strains outside of " << FLAGS_strain << "\n";
  }
  std::vector<Finding> findings = CheckCurve(table, curve);
  const auto is_ok = [](const Finding& finding) { return finding.severity == Severity::kOk; };
  findings.erase(std::remove_if(findings.begin(), findings.end(), is_ok), findings.end());
  std::cout << FindingsTable(findings);
  // With the offset of the gauge, as the place where the slack ends is told by noisy readings.
  if (strip.direction == PullDirection::kBias) {
    std::cout << "fit it beside curves along warp and weft: identify --target WARP,WEFT," << output << " --fit ..,"
              << ParametersOfPull(strip, curve.widths.size() > 0) << " --each force_bias.z\n";
  } else {
    std::cout << "fit it: identify --target " << output << " --fit " << ParametersOfPull(strip, curve.widths.size() > 0)
              << ",force_bias.z\n";
  }
}

}  // namespace

int MotionConvertCurve(const std::vector<std::string>& arguments) {
  const std::string &input = arguments[0], &output = arguments[1];
  ExpectMotionName(output);
  RefuseOverwrite(output, {input});
  CheckFileCanBeWritten(output);
  const TensileCurveOptions options = CurveOptionsFromFlags();
  TensileStrip strip = StripFromFlags();
  const std::optional<std::array<int, 2>> nodes = NodesFromFlag();
  const CurveTable table = ReadCurveTable(input);
  const TensileCurve curve = MakeTensileCurve(table, options);
  strip.nodes = nodes.value_or(UsualNodes(curve, strip.direction));
  WriteMotion(RecordTensileTest(curve, strip, CurveProvenance(input, table)), output);
  PrintCurve(output, table, curve, strip);
  return kExitSuccess;
}

}  // namespace clothid

#include "datasets/checking/check_edges.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <vector>

#include "datasets/checking/finding_words.h"
#include "datasets/checking/grid_orders.h"
#include "sim/rollout/self_contact_audit.h"

namespace clothid {
namespace {

constexpr double kSameLength = 0.05;  // of the edges, by share
constexpr double kWrongLength = 0.2;
constexpr double kUnitTolerance = 0.2;
constexpr double kCommon = 0.5;      // share of the lengths that a unit has to explain
constexpr double kMisplaced = 2.0;   // a pair, as it usually is, over the others: one of them is elsewhere
constexpr double kOftenSeen = 0.2;   // share of the frames: a pair that is seen less tells nothing about its points
constexpr double kManyPoints = 0.1;  // share of the points: so many are not mistaken for each other one by one

// A unit that a length ratio may give away.
struct Unit {
  double ratio;      // recorded over rest
  const char* text;  // the hint
};
constexpr Unit kUnits[] = {
    {1000.0, "the points seem to be in mm: motion convert --scale 0.001"},
    {100.0, "the points seem to be in cm: motion convert --scale 0.01"},
    {1.0 / 0.0254, "the points seem to be in inches: motion convert --scale 0.0254"},
    {1.0 / 0.3048, "the points seem to be in feet: motion convert --scale 0.3048"},
    {10.0, "the points seem to be in dm: motion convert --scale 0.1"},
    {0.001, "the mesh seems to be in mm and the points in m: give the mesh in m"},
    {0.01, "the mesh seems to be in cm and the points in m: give the mesh in m"},
    {0.0254, "the mesh seems to be in inches and the points in m: give the mesh in m"},
};

// How the lengths would be if the other axis of a grid ran fastest; NaN where the points are no such grid.
double TransposedRatio(const CheckedMotion& checked) {
  const std::vector<std::vector<int>> orders = GridOrders(checked.rest_points);
  double least = std::numeric_limits<double>::quiet_NaN();
  for (std::size_t k = 1; k < orders.size(); ++k) {
    std::vector<PointPair> pairs = checked.pairs;
    for (PointPair& pair : pairs) pair = {orders[k][pair.first], orders[k][pair.second], pair.rest_length};
    const Eigen::MatrixXd ratios = LengthRatios(pairs, checked.motion.positions);
    const double ratio = Median(ratios.reshaped());
    if (!(ratio >= least)) least = ratio;
  }
  return least;
}

// Whether most pairs agree on a ratio. Points in a wrong order do not.
bool IsCommon(const Eigen::MatrixXd& ratios, double ratio) {
  const double num_near = static_cast<double>(((ratios / ratio).array().log().abs() < 2.0 * kUnitTolerance).count());
  return num_near > kCommon * static_cast<double>(ratios.size() - ratios.array().isNaN().count());
}

void JudgeLengths(const CheckedMotion& checked, const Eigen::MatrixXd& ratios, double start_ratio, Finding* finding) {
  const double ratio = Median(ratios.reshaped());
  for (const Unit& unit : kUnits) {
    if (std::abs(std::log(ratio / unit.ratio)) > kUnitTolerance || !IsCommon(ratios, unit.ratio)) continue;
    finding->severity = Severity::kProblem;
    finding->hint = unit.text;
    return;
  }
  // A soft cloth that swings is stretched most of the time, but seldom where it starts.
  const double off = std::min(std::abs(std::log(ratio)), std::abs(std::log(start_ratio)));
  if (!(off > kSameLength)) return;
  finding->severity = off > kWrongLength ? Severity::kWarning : Severity::kNote;
  finding->hint =
      "the mesh at rest is of another size than the recorded cloth, or the cloth is stretched or folded at "
      "the start; the fit takes the difference for strain";
  if (off <= kWrongLength) return;
  if (!IsCommon(ratios, ratio)) {
    finding->hint =
        "neighbours of the mesh are no neighbours in the recording: are the points in the order of the nodes?";
  }
  if (checked.rest_points.cols() > kMaxOrderPoints) return;
  if (std::abs(std::log(TransposedRatio(checked))) < 0.5 * off) {
    finding->hint =
        "neighbours of the mesh are no neighbours in the recording; with the other axis of the grid running "
        "fastest they are: motion convert --transpose";
  }
}

// Of the thickness: noise above the first tells nothing of it, and contacts hold the cloth apart to less than the
// second.
constexpr double kHiddenByNoise = 0.5;
constexpr double kTooNear = 0.5;

bool EveryNodeIsSeen(const RecordedMotion& motion) {
  if (motion.num_points() != motion.scene.mesh.num_nodes()) return false;
  for (std::size_t p = 0; p < motion.points.size(); ++p) {
    if (motion.points[p].num_nodes != 1 || motion.points[p].nodes[0] != static_cast<int>(p)) return false;
  }
  return true;
}

}  // namespace

Finding CheckEdges(const CheckedMotion& checked) {
  Finding finding;
  finding.what = "edge lengths";
  if (checked.pairs.empty()) {
    finding.value = "not compared: no neighbouring points";
    return finding;
  }
  const Eigen::MatrixXd ratios = LengthRatios(checked.pairs, checked.motion.positions);
  const double ratio = Median(ratios.reshaped());
  if (std::isnan(ratio)) {
    finding.value = "not compared: no neighbours are seen together";
    return finding;
  }
  double start_ratio = std::numeric_limits<double>::quiet_NaN();
  for (Eigen::Index frame = 0; frame < ratios.cols() && std::isnan(start_ratio); ++frame) {
    start_ratio = Median(ratios.col(frame));
  }
  finding.value = Rounded(ratio) + " of the mesh at rest (median), " + Rounded(start_ratio) + " at the start";
  JudgeLengths(checked, ratios, start_ratio, &finding);
  return finding;
}

// Points that are not where the mesh has them: most pairs with them are far too long most of the time.
std::vector<Finding> CheckPlaces(const CheckedMotion& checked) {
  const int num_points = checked.motion.num_points();
  const Eigen::MatrixXd ratios = LengthRatios(checked.pairs, checked.motion.positions);
  std::vector<double> of_pair;
  const auto fewest =
      std::max<Eigen::Index>(2, static_cast<Eigen::Index>(kOftenSeen * static_cast<double>(ratios.cols())));
  for (Eigen::Index i = 0; i < ratios.rows(); ++i) {
    const bool is_often_seen = ratios.cols() - ratios.row(i).array().isNaN().count() >= fewest;
    of_pair.push_back(is_often_seen ? Median(ratios.row(i).transpose()) : std::numeric_limits<double>::quiet_NaN());
  }
  const double usual = std::max(1.0, Median(of_pair));
  std::vector<int> num_pairs(static_cast<std::size_t>(num_points), 0), num_long = num_pairs;
  for (std::size_t i = 0; i < of_pair.size(); ++i) {
    if (std::isnan(of_pair[i])) continue;
    for (const int point : {checked.pairs[i].first, checked.pairs[i].second}) {
      ++num_pairs[point];
      num_long[point] += of_pair[i] > kMisplaced * usual;
    }
  }
  Finding finding;
  finding.what = "places of points";
  for (int p = 0; p < num_points; ++p) {
    if (num_pairs[p] > 1 && 5 * num_long[p] > 3 * num_pairs[p]) finding.points.push_back(p);
  }
  if (finding.points.empty()) return {};
  finding.severity = Severity::kWarning;
  finding.value = Named("point", finding.points) + " far from their neighbours on the mesh all the time";
  finding.hint = "points that were taken for others, or are no part of the cloth: correct their order, or remove them";
  if (static_cast<double>(finding.points.size()) > kManyPoints * num_points) {
    finding.hint = "the points are in another order than the nodes of the mesh";
  }
  return {finding};
}

std::vector<Finding> CheckSelfContact(const CheckedMotion& checked) {
  const RecordedMotion& motion = checked.motion;
  if (!motion.scene.self_contact || !EveryNodeIsSeen(motion)) return {};
  const double thickness = motion.scene.self_contact->thickness;
  if (checked.noise_floor > kHiddenByNoise * thickness) return {};
  SelfContactAuditor auditor(motion.scene);
  std::vector<int> frames;  // that are seen as a whole
  for (int frame = 0; frame < motion.num_frames(); ++frame) {
    if (!motion.positions.col(frame).allFinite()) continue;
    auditor.Add(motion.positions.col(frame));
    frames.push_back(frame);
  }
  if (frames.empty()) return {};
  const SelfContactAudit& audit = auditor.audit();
  Finding finding;
  finding.what = "self-contact";
  if (audit.num_cut > 0) {
    finding.severity = Severity::kWarning;
    finding.frames = {frames[static_cast<std::size_t>(audit.first_cut)]};
    finding.value = std::to_string(audit.intersections) + " pairs of triangles cut each other, in " +
                    std::to_string(audit.num_cut) + " of " + std::to_string(frames.size()) + " frames, from frame " +
                    std::to_string(finding.frames[0]) + " on";
    finding.hint = "of a simulation: take shorter steps (time_step); else thickness, unit and order of the points?";
    return {finding};
  }
  finding.value = "no triangles cut each other; parts of the cloth come nearer than its thickness of " +
                  Millimetres(thickness) + " by " + Millimetres(audit.violation) + " at most";
  if (audit.violation <= kTooNear * thickness + checked.noise_floor) return {finding};
  finding.severity = Severity::kWarning;
  finding.frames = {frames[static_cast<std::size_t>(audit.deepest)]};
  finding.hint = "the thickness of self_contact, or of a simulation its time_step";
  return {finding};
}

}  // namespace clothid

#include "datasets/checking/check_fall.h"

#include <Eigen/LU>
#include <algorithm>
#include <cmath>
#include <iterator>
#include <limits>
#include <optional>
#include <utility>
#include <vector>

#include "datasets/checking/finding_words.h"
#include "sim/matrix/dense.h"
#include "sim/scene/pieces.h"

namespace clothid {
namespace {

constexpr int kFewestPoints = 8;
constexpr double kOffCentre = 0.1;     // of the cloth's size: the points stand for the cloth if their mean is so near
constexpr double kGain = 0.3;          // of the larger of both energies
constexpr double kLeastFall = 0.01;    // of the cloth's size: a smaller drop tells nothing
constexpr double kLeastDrop = 0.02;    // of the cloth's size: likewise of energy
constexpr double kQuietEnergy = 0.05;  // noise of the kinetic energy, relative to the largest energy
constexpr int kFewestFrames = 5, kMostFrames = 12;
constexpr int kFewestFastFrames = 3;  // where it falls much faster than it can
constexpr double kShortFall = 0.15;   // of the cloth's size: as far as it falls it is taken to keep its shape
constexpr double kWrongFall = 0.3;    // of gravity
constexpr double kSlowFall = 0.4;     // likewise: the air holds no cloth back that much at once
constexpr double kClear = 3.0;        // of what gravity makes: no error of measuring, but another clock or unit
constexpr double kStretched = 1.1;    // of the lengths at rest: what starts so is pulled, too
constexpr double kHeld = 0.2;         // likewise: a point that falls so little is held
constexpr double kNoiseFall = 4.0;    // standard deviations
constexpr double kStill = 0.003;      // of the cloth's size: handles that move no more stand
constexpr double kHandleNoise = 1.2;  // standard deviations of a measured path: likewise
constexpr double kHangs = 0.2;        // of the cloth's size: its mean below the handles
constexpr double kLeastSwing = 0.05;  // of the cloth's size, from one side to the other
constexpr std::size_t kFewestTurns = 3;
constexpr double kFewestInHalf = 3.0;  // frames of half a period
constexpr double kEven = 1.5;          // longest half of a period over the shortest
constexpr double kPlatePeriod = 5.2;   // times sqrt(l/g)
constexpr double kFastSwing = 2.5;     // of the period over the one measured: faster than its second mode
constexpr double kSlowSwing = 3.0;     // likewise: the mass of the air and its drag hold back no more
constexpr double kNear = 0.1;          // of the cloth's size: handles all around pull nowhere

// A path of handles that stand still has the noise of the points that it was taken from.
bool HandlesMove(const CheckedMotion& checked) {
  const Eigen::MatrixXd& path = checked.motion.scene.handles.path.positions();
  if (path.size() == 0) return false;
  const Eigen::VectorXd& sigma = checked.motion.sigma;
  const double noise = sigma.size() > 0 ? Median(sigma) : checked.noise.rms();
  const Eigen::MatrixXd moved = path.colwise() - path.rowwise().mean();
  const double size = moved.norm() / std::sqrt(static_cast<double>(moved.size()));
  return size > kStill * checked.cloth_size + kHandleNoise * noise;
}

bool HasOtherForces(const CheckedMotion& checked) {
  const Scene& scene = checked.motion.scene;
  return HandlesMove(checked) || !scene.node_force.isZero(0.0) || scene.gravity.isZero(0.0) || scene.has_wind();
}

// What explains accelerations that are `factor` of those by gravity.
std::string RateHint(double factor) {
  const double clock = std::sqrt(factor);
  return "a frame rate of " + Rounded(1.0 / clock) + " of what it is said to be would explain it (motion convert " +
         "--frame_rate, or --time_scale " + Rounded(clock) + "), or points and mesh that are " + Rounded(factor) +
         " of their size (--scale)";
}

// m/s^2, of cloth that nothing but its weight moves: that moves the mass of the air along. Energies per mass are those
// of this pull, too.
Eigen::Vector3d FreeFall(const Scene& scene) {
  const Material material = MeanMaterial(scene.nominal_parameters(), scene.mesh);
  return scene.gravity * (material.density / material.areal_inertia());
}

bool StandForCloth(const CheckedMotion& checked) {
  const Eigen::Vector3d off =
      checked.rest_points.rowwise().mean() - checked.motion.scene.mesh.rest_positions.rowwise().mean();
  return checked.motion.num_points() >= kFewestPoints && off.norm() < kOffCentre * checked.cloth_size;
}

// The mean of how far points went from one frame to another, over those that are seen in both.
Eigen::Vector3d MeanStep(const Eigen::MatrixXd& positions, Eigen::Index from, Eigen::Index to) {
  const Eigen::Matrix3Xd step = (positions.col(to) - positions.col(from)).reshaped(3, positions.rows() / 3);
  Eigen::Vector3d sum = Eigen::Vector3d::Zero();
  int count = 0;
  for (Eigen::Index p = 0; p < step.cols(); ++p) {
    if (!step.col(p).allFinite()) continue;
    sum += step.col(p);
    ++count;
  }
  return sum / count;
}

// 1/2 mean |v_0|^2, m^2/s^2, without what noise makes of it, but at least that of the mean.
double StartEnergy(const CheckedMotion& checked) {
  const RecordedMotion& motion = checked.motion;
  const double interval = motion.times[1] - motion.times[0];
  const Eigen::Matrix3Xd velocities =
      (motion.positions.col(1) - motion.positions.col(0)).reshaped(3, motion.num_points()) / interval;
  double sum = 0.0;
  int count = 0;
  for (Eigen::Index p = 0; p < velocities.cols(); ++p) {
    if (!velocities.col(p).allFinite()) continue;
    sum += 0.5 * velocities.col(p).squaredNorm();
    ++count;
  }
  const double noise = 3.0 * checked.noise.sigma.squaredNorm() / 3.0 / (interval * interval);
  const double of_mean = 0.5 * MeanStep(motion.positions, 0, 1).squaredNorm() / (interval * interval);
  const double of_points = count > 0 ? sum / count - noise : std::numeric_limits<double>::quiet_NaN();
  return std::max(of_mean, of_points);
}

// That of a drop that tells nothing, m^2/s^2.
double LeastEnergy(const CheckedMotion& checked) {
  return kLeastDrop * checked.cloth_size * FreeFall(checked.motion.scene).norm();
}

// What the cloth has more than at the start, per mass, m^2/s^2.
struct EnergyGain {
  double most = 0.0;   // kinetic energy and that of gravity together
  double scale = 0.0;  // the larger of both alone
  double ratio = 0.0;  // at the frame: of the kinetic energy that came to what gravity gave; 0: it gave none
  int frame = 0;       // of the most
};

// Nothing where noise hides the kinetic energy.
std::optional<EnergyGain> FindGain(const CheckedMotion& checked) {
  const RecordedMotion& motion = checked.motion;
  const int num_frames = motion.num_frames();
  Eigen::VectorXd potential(num_frames);
  for (int frame = 0; frame < num_frames; ++frame) {
    potential[frame] = -FreeFall(motion.scene).dot(MeanStep(motion.positions, 0, frame));
  }
  if (!potential.allFinite()) return std::nullopt;
  EnergyGain gain;
  gain.scale = potential.cwiseAbs().maxCoeff();
  // Velocities over so many frames that noise does not count.
  const double variance = 3.0 * checked.noise.rms() * checked.noise.rms() / motion.num_points();
  const double least_time = std::sqrt(variance / std::max(kQuietEnergy * gain.scale, 1e-300));
  const double num_intervals = std::max(1.0, std::ceil(least_time / checked.median_interval));
  if (!(4.0 * num_intervals < num_frames)) return std::nullopt;
  const int stride = static_cast<int>(num_intervals);
  const double start = StartEnergy(checked), least = LeastEnergy(checked);
  for (int frame = 0; frame + stride < num_frames; ++frame) {
    const double interval = motion.times[frame + stride] - motion.times[frame];
    const double speed = MeanStep(motion.positions, frame, frame + stride).norm() / interval;
    const double kinetic = 0.5 * speed * speed;
    gain.scale = std::max(gain.scale, kinetic);
    const double fallen = -0.5 * (potential[frame] + potential[frame + stride]);
    const double more = kinetic - fallen - start;
    if (!(more > gain.most)) continue;
    gain.most = more;
    gain.ratio = fallen > least ? (kinetic - start) / fallen : 0.0;
    gain.frame = frame;
  }
  return gain;
}

std::vector<Finding> CheckEnergy(const CheckedMotion& checked) {
  const std::optional<EnergyGain> gain = FindGain(checked);
  if (!gain || !(gain->most > kGain * gain->scale) || !(gain->scale > LeastEnergy(checked))) return {};
  Finding finding;
  finding.what = "energy";
  finding.severity = Severity::kWarning;
  finding.frames = {gain->frame};
  finding.value = "the cloth gains " + Rounded(gain->most) + " J per kg by frame " + std::to_string(gain->frame) +
                  ", with nothing but gravity to move it";
  finding.hint =
      "size and direction of gravity, frame rate (motion convert --frame_rate, --time_scale), order of the frames in "
      "time? Or it started stretched";
  if (gain->ratio < kClear) return {finding};
  finding.value += ": " + Rounded(gain->ratio) + " times what that can give";
  finding.hint = RateHint(gain->ratio) + "; or it started stretched, or something pulls it";
  return {finding};
}

// The frames over which the cloth falls but little, from the first one.
int NumFallingFrames(const CheckedMotion& checked, int num_free) {
  const RecordedMotion& motion = checked.motion;
  int count = std::min({num_free, motion.num_frames(), kMostFrames});
  while (count > 1 && MeanStep(motion.positions, 0, count - 1).norm() > kShortFall * checked.cloth_size) --count;
  return count;
}

// The direction in which handles at rest can pull; zero without handles, nothing where it is not one direction: around
// the cloth, or clamped so that a stiff cloth stands out.
bool PullDirection(const CheckedMotion& checked, Eigen::Vector3d* direction) {
  const Scene& scene = checked.motion.scene;
  direction->setZero();
  if (scene.handles.nodes.empty()) return true;
  if (checked.stands_out) return false;
  const Eigen::Matrix3Xd held =
      scene.initial_positions.reshaped(3, scene.mesh.num_nodes())(Eigen::all, scene.handles.nodes);
  const Eigen::Vector3d centre = held.rowwise().mean();
  const Eigen::Matrix3Xd around = held.colwise() - centre;
  const Eigen::Vector3d along = around.col(around.cols() - 1).normalized();
  const Eigen::Matrix3Xd across = around - along * (along.transpose() * around);
  if (around.cols() > 2 && across.colwise().norm().maxCoeff() > 0.5 * checked.spacing) return false;
  const Eigen::Vector3d pull = centre - scene.initial_positions.reshaped(3, scene.mesh.num_nodes()).rowwise().mean();
  if (pull.norm() < kNear * checked.cloth_size) return false;
  *direction = pull.normalized();
  return true;
}

// A parabola through the means of the points in the first frames.
struct MeanFall {
  Eigen::Vector3d acceleration = Eigen::Vector3d::Zero();  // m/s^2
  double noise_factor = 0.0;                               // 1/s^2: its standard deviation over that of a mean
  double length = 0.0;                                     // m: how far the mean comes
};

MeanFall FitFall(const CheckedMotion& checked, int num_frames) {
  const RecordedMotion& motion = checked.motion;
  Eigen::MatrixXd powers(num_frames, 3), means(num_frames, 3);
  for (int frame = 0; frame < num_frames; ++frame) {
    const double time = motion.times[frame] - motion.times[0];
    powers.row(frame) << 1.0, time, 0.5 * time * time;
    means.row(frame) = MeanStep(motion.positions, 0, frame).transpose();
  }
  const Eigen::Matrix3d covariance = (powers.transpose() * powers).inverse();
  MeanFall fall;
  fall.acceleration = (covariance * powers.transpose() * means).row(2).transpose();
  fall.noise_factor = std::sqrt(covariance(2, 2));
  fall.length = means.rowwise().norm().maxCoeff();
  return fall;
}

// [P] m: how far points fell until a frame, beyond what their first velocities make; NaN where they are not seen.
Eigen::VectorXd FallOfPoints(const CheckedMotion& checked, int frame) {
  const RecordedMotion& motion = checked.motion;
  const Eigen::Vector3d down = motion.scene.gravity.normalized();
  const double time = motion.times[frame] - motion.times[0];
  Eigen::VectorXd fallen(motion.num_points());
  for (int p = 0; p < motion.num_points(); ++p) {
    const Eigen::Vector3d velocity =
        motion.scene.initial_velocities.segment<3>(3 * static_cast<Eigen::Index>(motion.points[p].nodes[0]));
    const Eigen::Vector3d moved =
        (motion.positions.col(frame) - motion.positions.col(0)).segment<3>(3 * static_cast<Eigen::Index>(p));
    fallen[p] = (moved - velocity * time).dot(down);
  }
  return fallen;
}

double MedianOfSeen(const Eigen::VectorXd& values) {
  std::vector<double> seen;
  std::copy_if(values.begin(), values.end(), std::back_inserter(seen), [](double x) { return std::isfinite(x); });
  return seen.empty() ? 0.0 : Median(std::move(seen));
}

// Points that do not fall although nothing is touched and the scene has no handles. In air they fall by a fifth
// of what gravity alone would make, at least; where most fall more slowly, for the clock is another, by a fifth of
// what those do.
std::vector<Finding> CheckHeldPoints(const CheckedMotion& checked, int num_free) {
  const RecordedMotion& motion = checked.motion;
  const int last = std::min(num_free, motion.num_frames()) - 1;
  if (!motion.scene.handles.nodes.empty() || last < 1) return {};
  const double noise = kNoiseFall * std::sqrt(2.0) * checked.noise.rms();
  const double needed = noise / kHeld + kLeastFall * checked.cloth_size;
  int frame = 1;
  const auto fall = [&] {
    return 0.5 * FreeFall(motion.scene).norm() * std::pow(motion.times[frame] - motion.times[0], 2);
  };
  while (frame < last && fall() < needed) ++frame;
  if (fall() < needed) return {};
  double yardstick = fall();
  for (int later = frame; later <= last; ++later) {
    const double of_most = MedianOfSeen(FallOfPoints(checked, later));
    if (of_most < needed) continue;
    frame = later;
    yardstick = std::min(fall(), of_most);
    break;
  }
  const Eigen::VectorXd fallen = FallOfPoints(checked, frame);
  Finding finding;
  finding.what = "held points";
  for (int p = 0; p < motion.num_points(); ++p) {
    if (std::abs(fallen[p]) < kHeld * yardstick) finding.points.push_back(p);
  }
  if (finding.points.empty()) return {};
  finding.severity = Severity::kWarning;
  finding.value = Named("point", finding.points) + " in the air until frame " + std::to_string(frame) +
                  ", and the scene has no handles";
  finding.hint = "what holds them? `handles` in the scene, or motion convert --handle_nodes";
  return {finding};
}

bool StartsStretched(const CheckedMotion& checked) {
  return !(Median(LengthRatios(checked.pairs, checked.motion.positions.leftCols(1)).col(0)) < kStretched);
}

std::vector<Finding> CheckFreeFall(const CheckedMotion& checked, int num_free) {
  const RecordedMotion& motion = checked.motion;
  const int count = NumFallingFrames(checked, num_free);
  Eigen::Vector3d pull;
  const double num_nodes = motion.scene.mesh.num_nodes();
  const double num_free_nodes = num_nodes - static_cast<double>(motion.scene.handles.nodes.size());
  if (count < kFewestFastFrames || num_free_nodes < 1.0 || !PullDirection(checked, &pull)) return {};
  const MeanFall fall = FitFall(checked, count);
  const Eigen::Vector3d acceleration = fall.acceleration * (num_nodes / num_free_nodes);
  const auto across = [&](const Eigen::Vector3d& v) -> Eigen::Vector3d { return v - pull * pull.dot(v); };
  const Eigen::Vector3d measured = across(acceleration), given = across(FreeFall(motion.scene));
  const double size = FreeFall(motion.scene).norm();
  const double of_mean = kNoiseFall * checked.noise.rms() / std::sqrt(1.0 * motion.num_points());
  const double noise = of_mean * fall.noise_factor, room = kWrongFall * size + noise;
  const Eigen::Vector3d down = given.normalized();
  const double along = measured.dot(down);
  const bool is_straight = (measured - along * down).norm() <= std::max(room, kWrongFall * along);
  const bool is_clear = is_straight && along - noise > kClear * size && !StartsStretched(checked);
  const bool is_known = count >= kFewestFrames && noise <= kWrongFall * size;
  if (fall.length < kLeastFall * checked.cloth_size + of_mean || !(is_known || is_clear)) return {};
  Finding finding;
  finding.what = "fall";
  finding.value = "by " + Rounded(measured.norm()) + " m/s^2 in the first " + std::to_string(count) +
                  " frames; gravity alone: " + Rounded(given.norm());
  // The air holds a light cloth back.
  const bool is_slow = along<kSlowFall * given.norm() - noise, is_fast = along> given.norm() + room;
  if (!is_slow && !is_fast && (measured - along * down).norm() <= room) return {finding};
  finding.severity = is_clear ? Severity::kProblem : Severity::kWarning;
  finding.hint = "size and direction of gravity, frame rate: motion convert --frame_rate, --time_scale";
  if (!is_straight || along <= noise) return {finding};
  finding.value += ": points that are let go start with " + Rounded(along / given.norm()) + " times gravity";
  finding.hint = RateHint(along / given.norm());
  if (is_slow) finding.hint += "; or the air, or a hand, held it back";
  return {finding};
}

// Where the mean of the points is beside the middle of the handles, across gravity in the direction in which it swings
// most, and how far it hangs below them at most.
struct Swing {
  Eigen::VectorXd aside;  // [T] m
  double length = 0.0;    // m
};

Swing FindSwing(const CheckedMotion& checked) {
  const RecordedMotion& motion = checked.motion;
  const Scene& scene = motion.scene;
  const auto nodes = scene.initial_positions.reshaped(3, scene.mesh.num_nodes());
  const Eigen::Vector3d held = nodes(Eigen::all, scene.handles.nodes).rowwise().mean();
  const Eigen::Vector3d down = scene.gravity.normalized(), start = nodes.rowwise().mean() - held;
  Eigen::Matrix3Xd places(3, motion.num_frames());
  for (int frame = 0; frame < motion.num_frames(); ++frame) {
    places.col(frame) = start + MeanStep(motion.positions, 0, frame);
  }
  Swing swing;
  swing.length = (down.transpose() * places).maxCoeff();
  places -= down * (down.transpose() * places);
  places.colwise() -= places.rowwise().mean().eval();
  swing.aside = places.transpose() * SymmetricSpectrum(Eigen::Matrix3d(places * places.transpose())).vectors.col(2);
  return swing;
}

// The times at which values turn back by more than `least`; those of the first and the last frame are none.
std::vector<double> TurningTimes(const Eigen::VectorXd& times, const Eigen::VectorXd& values, double least) {
  std::vector<double> turns;
  Eigen::Index low = 0, high = 0;
  int direction = 0;
  for (Eigen::Index i = 0; i < values.size(); ++i) {
    if (values[i] < values[low]) low = i;
    if (values[i] > values[high]) high = i;
    const bool rises = direction <= 0 && values[i] > values[low] + least;
    const bool falls = direction >= 0 && values[i] < values[high] - least;
    if (!rises && !falls) continue;
    const Eigen::Index turn = rises ? low : high;
    if (turn > 0) turns.push_back(times[turn]);
    direction = rises ? 1 : -1;
    low = high = i;
  }
  return turns;
}

// The period of a cloth that swings from handles at rest. A rigid plate and a chain of length l swing in 5.1 and
// 5.2 sqrt(l/g), their means l/2 below. One that is clamped swings as stiff as it is.
std::vector<Finding> CheckSwing(const CheckedMotion& checked, int num_free) {
  const RecordedMotion& motion = checked.motion;
  const Handles& handles = motion.scene.handles;
  const bool hangs = !handles.nodes.empty() && handles.clamped.empty();
  if (!hangs || checked.stands_out || num_free < motion.num_frames()) return {};
  const Swing swing = FindSwing(checked);
  if (!swing.aside.allFinite() || swing.length < kHangs * checked.cloth_size) return {};
  const double noise = kNoiseFall * checked.noise.rms() / std::sqrt(1.0 * motion.num_points());
  const std::vector<double> turns = TurningTimes(motion.times, swing.aside, kLeastSwing * checked.cloth_size + noise);
  if (turns.size() < kFewestTurns) return {};
  std::vector<double> halves;
  for (std::size_t i = 1; i < turns.size(); ++i) halves.push_back(turns[i] - turns[i - 1]);
  const auto [shortest, longest] = std::minmax_element(halves.begin(), halves.end());
  if (*shortest < kFewestInHalf * checked.median_interval || *longest > kEven * *shortest) return {};
  const double period = 2.0 * Median(halves);
  const double expected = kPlatePeriod * std::sqrt(2.0 * swing.length / FreeFall(motion.scene).norm());
  const double ratio = expected / period;
  Finding finding;
  finding.what = "swing";
  finding.value = "a period of " + Rounded(period) + " s; of a cloth that hangs " + Rounded(2.0 * swing.length) +
                  " m down: " + Rounded(expected) + " s";
  if (ratio < kFastSwing && ratio > 1.0 / kSlowSwing) return {finding};
  finding.severity = Severity::kWarning;
  finding.hint = RateHint(ratio * ratio) + "; or something drives it";
  return {finding};
}

}  // namespace

std::vector<Finding> CheckFall(const CheckedMotion& checked, int num_free) {
  if (HasOtherForces(checked) || !StandForCloth(checked) || checked.motion.num_frames() < kFewestFrames) {
    return {};
  }
  std::vector<Finding> findings = CheckHeldPoints(checked, num_free);
  const auto add = [&](const std::vector<Finding>& more) { findings.insert(findings.end(), more.begin(), more.end()); };
  if (findings.empty()) add(CheckFreeFall(checked, num_free));
  add(CheckSwing(checked, num_free));
  add(CheckEnergy(checked));
  return findings;
}

}  // namespace clothid

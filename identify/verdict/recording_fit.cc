#include "identify/verdict/recording_fit.h"

#include <algorithm>
#include <cmath>

#include "sim/mesh/mesh.h"

namespace clothid {
namespace {

// A point has three coordinates, of a cloud only the distance to the surface.
double Noise(const Observation& observation) {
  double squares = 0.0, count = 0.0;
  for (const SeenCoordinate& seen : observation.coordinates()) {
    squares += std::pow(observation.sigma(seen), 2);
    count += seen.point < observation.num_points() ? 1.0 / 3.0 : 1.0;
  }
  return std::sqrt(squares / count);
}

// A point of a frame by its first row, and how far it is from the prediction, in sigma.
struct FarPoint {
  int row = 0;
  double squared = 0.0;
};

// What counts for less than this share is discounted.
constexpr double kDiscounted = 0.5;
// An error that is larger by this than without what was discounted is that of gross errors. Without the worst fifth any
// error is smaller by a half.
constexpr double kClearlyLarger = 1.2, kFarLarger = 2.0;

std::vector<FarPoint> PointsOf(const Observation& observation, const Eigen::VectorXd& residuals) {
  const Eigen::VectorXd& weights = observation.error_weights();
  std::vector<FarPoint> points;
  for (int row = 0; row < observation.first_force_row(); ++row) {
    const SeenCoordinate& seen = observation.coordinates()[row];
    const SeenCoordinate& last = observation.coordinates()[points.empty() ? row : points.back().row];
    if (points.empty() || seen.frame != last.frame || seen.point != last.point) points.push_back({row, 0.0});
    points.back().squared += std::pow((weights.size() > 0 ? weights[row] : 1.0) * residuals[row], 2);
  }
  return points;
}

// `motion` as if the point of a row had not been seen. Points of a cloud go when all rows are known: they are appended
// to `of_clouds`, their places in the clouds.
void Hide(const Observation& observation, int row, RecordedMotion* motion,
          std::vector<std::vector<Eigen::Index>>* of_clouds) {
  const SeenCoordinate& seen = observation.coordinates()[row];
  int tracked = seen.point;
  if (seen.point >= observation.num_points()) {
    const SeenSurfacePoint& point = observation.clouds().point(seen.frame, seen.point - observation.num_points());
    tracked = point.tracked;
    if (tracked < 0) (*of_clouds)[seen.frame].push_back(&point - observation.clouds().points(seen.frame).data());
  }
  if (tracked >= 0) motion->positions.col(seen.frame).segment<3>(3 * tracked).setConstant(std::nan(""));
}

void RemoveColumns(const std::vector<Eigen::Index>& removed, Eigen::Matrix3Xd* cloud) {
  std::vector<Eigen::Index> kept;
  for (Eigen::Index i = 0; i < cloud->cols(); ++i) {
    if (std::find(removed.begin(), removed.end(), i) == removed.end()) kept.push_back(i);
  }
  *cloud = (*cloud)(Eigen::all, kept).eval();
}

// Nothing where the loss discounts nothing, or hardly any of the error; else `motion` becomes what is left.
std::optional<Discounted> FindDiscounted(const RobustLoss& loss, const Observation& observation,
                                         const Eigen::MatrixXd& predicted, const Eigen::MatrixXd& forces,
                                         const PredictionError& error, RecordedMotion* motion) {
  if (!loss.is_robust()) return std::nullopt;
  std::vector<FarPoint> points = PointsOf(observation, observation.Residuals(predicted, forces));
  const auto num_points = static_cast<double>(points.size());
  const auto counts = [&](const FarPoint& point) {
    return !(point.squared > kFarFromSurface * kFarFromSurface) ||
           InfluenceOn(loss, point.squared).factor >= kDiscounted;
  };
  points.erase(std::remove_if(points.begin(), points.end(), counts), points.end());
  if (points.empty()) return std::nullopt;
  Discounted discounted;
  discounted.share = static_cast<double>(points.size()) / num_points;
  std::stable_sort(points.begin(), points.end(),
                   [](const FarPoint& a, const FarPoint& b) { return a.squared > b.squared; });
  if (discounted.is_many()) points.resize(static_cast<std::size_t>(Discounted::kMostGross * num_points));
  RecordedMotion kept = *motion;
  std::vector<std::vector<Eigen::Index>> of_clouds(static_cast<std::size_t>(kept.num_frames()));
  for (const FarPoint& point : points) Hide(observation, point.row, &kept, &of_clouds);
  for (std::size_t i = 0; i < kept.clouds.size(); ++i) RemoveColumns(of_clouds[i], &kept.clouds[i]);
  discounted.error = Observation(kept).Compare(predicted, forces);
  const double larger = discounted.is_many() ? kFarLarger : kClearlyLarger;
  if (!(error.rmse() > larger * discounted.error.rmse())) return std::nullopt;
  *motion = std::move(kept);
  return discounted;
}

// Where most points of the first frame are discounted, it is the start that is wrong, and no few points.
bool KeepsFirstFrame(const RecordedMotion& motion, const RecordedMotion& kept) {
  const auto num_seen = [](const RecordedMotion& of) { return (!of.positions.col(0).array().isNaN()).count(); };
  return 2 * num_seen(kept) >= num_seen(motion);
}

}  // namespace

double RecordingFit::motion() const { return std::sqrt(3.0 * judged().squared_motion / judged().num_coordinates); }

std::vector<RecordingFit> DescribeRecordings(const std::vector<RecordedMotion>& motions, const FitSummary& summary,
                                             const RobustLoss& loss) {
  // A fitted frame of reference corrects what is predicted, and the start with it.
  const bool is_aligned =
      std::any_of(summary.parameters.begin(), summary.parameters.end(), [](const FittedParameter& parameter) {
        return parameter.name.rfind("shift", 0) == 0 || parameter.name.rfind("turn", 0) == 0;
      });
  std::vector<RecordingFit> recordings;
  for (std::size_t r = 0; r < motions.size(); ++r) {
    Observation observation(motions[r]);
    const Eigen::MatrixXd& predicted = summary.predicted[r];
    RecordingFit recording;
    recording.name = motions[r].name;
    const Eigen::MatrixXd forces = r < summary.forces.size() ? summary.forces[r] : Eigen::MatrixXd();
    recording.error = observation.Compare(predicted, forces);
    recording.cloth_size = ClothSize(motions[r].scene.mesh);
    if (observation.sigma_is_known()) recording.noise = Noise(observation);
    if (r < summary.model_errors.size()) recording.model_error = summary.model_errors[r];
    observation.SetModelError(recording.model_error);
    RecordedMotion kept = motions[r];
    recording.discounted = FindDiscounted(loss, observation, predicted, forces, recording.error, &kept);
    if (!KeepsFirstFrame(motions[r], kept)) kept = motions[r];
    recording.start = is_aligned ? DifferenceAtStart(kept, predicted.col(0)) : DifferenceAtStart(kept);
    const StartSource source = motions[r].start_source;
    recording.starts_at_noise =
        observation.sigma_is_known() && (source == StartSource::kFirstFrame || source == StartSource::kSmoothed);
    recordings.push_back(recording);
  }
  return recordings;
}

}  // namespace clothid

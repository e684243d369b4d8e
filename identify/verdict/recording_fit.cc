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

}  // namespace

double RecordingFit::motion() const { return std::sqrt(3.0 * error.squared_motion / error.num_coordinates); }

std::vector<RecordingFit> DescribeRecordings(const std::vector<RecordedMotion>& motions, const FitSummary& summary) {
  // A fitted frame of reference corrects what is predicted, and the start with it.
  const bool is_aligned =
      std::any_of(summary.parameters.begin(), summary.parameters.end(), [](const FittedParameter& parameter) {
        return parameter.name.rfind("shift", 0) == 0 || parameter.name.rfind("turn", 0) == 0;
      });
  std::vector<RecordingFit> recordings;
  for (std::size_t r = 0; r < motions.size(); ++r) {
    const Observation observation(motions[r]);
    const Eigen::MatrixXd& predicted = summary.predicted[r];
    RecordingFit recording;
    recording.name = motions[r].name;
    const bool has_forces = r < summary.forces.size();
    recording.error = observation.Compare(predicted, has_forces ? summary.forces[r] : Eigen::MatrixXd());
    recording.cloth_size = ClothSize(motions[r].scene.mesh);
    if (observation.sigma_is_known()) recording.noise = Noise(observation);
    if (r < summary.model_errors.size()) recording.model_error = summary.model_errors[r];
    recording.start = is_aligned ? DifferenceAtStart(motions[r], predicted.col(0)) : DifferenceAtStart(motions[r]);
    const StartSource source = motions[r].start_source;
    recording.starts_at_noise =
        observation.sigma_is_known() && (source == StartSource::kFirstFrame || source == StartSource::kSmoothed);
    recordings.push_back(recording);
  }
  return recordings;
}

}  // namespace clothid

// A fit from a smoothed start explains more where the first frame is no start: markers on a cloth that is not flat, and
// a first frame that was found the wrong way round. (Noise alone a simulation forgets: see datasets/motion_bin.md.)
#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <vector>

#include "datasets/motion/start_state.h"
#include "identify/fit/fit.h"
#include "tests/costs/synthetic_motion.h"

namespace clothid::smoothed_start_test {
namespace {

constexpr double kNoise = 2e-3;
constexpr int kSide = 8;

// 8 x 8 nodes hung by an edge, falling on a sphere; recorded from step `first` on.
struct NoisyDrape {
  RecordedMotion motion;
  Eigen::VectorXd start;  // the true one
};

NoisyDrape MakeDrape(int first, unsigned seed) {
  constexpr int kFrames = 60;
  Scene scene = ClothScene(kSide, first + kFrames);
  scene.bending.law = BendingLaw::kEdges;  // stiff enough for what a few markers tell of it
  scene.solver.step_tolerance = 1e-6;
  for (int i = 0; i < kSide; ++i) scene.handles.nodes.push_back(i);
  scene.obstacles = SphereScene().obstacles;
  MotionOptions truth;
  truth.true_values = {{"k_stretch", 25.0}, {"mu", 0.35}};
  truth.sigma = kNoise;
  NoisyDrape drape;
  drape.motion = MakeMotion(scene, truth);
  drape.start = drape.motion.positions.col(first);
  drape.motion.times = drape.motion.times.head(kFrames).eval();
  drape.motion.positions = drape.motion.positions.middleCols(first, kFrames).eval();
  AddLastingNoise(kNoise, 0.0, seed, &drape.motion);
  return drape;
}

// The start `positions`, but for handles, which stand where they do.
void StartAt(const Eigen::VectorXd& positions, const NoisyDrape& drape, RecordedMotion* motion) {
  motion->scene.initial_positions = positions;
  motion->scene.initial_positions.head(3 * kSide) = drape.start.head(3 * kSide);
}

RecordedMotion Smoothed(RecordedMotion motion) {
  const FrameTrend trend = FitFrameTrend(motion.times, motion.positions, motion.sigma);
  motion.scene.initial_velocities = SmoothStartVelocities(motion.scene, motion.points, trend);
  motion.scene.initial_positions = SmoothStartPositions(motion.scene, motion.points, trend);
  return motion;
}

double StartError(const RecordedMotion& motion, const NoisyDrape& drape) {
  return (motion.scene.initial_positions - drape.start).norm();
}

double FittedRmse(const RecordedMotion& motion) {
  FitOptions options;
  options.parameters = {"mu", "k_stretch"};
  options.jacobian = JacobianMethod::kSensitivity;
  options.estimate_uncertainty = false;
  FitProblem problem({motion}, options);
  const FitSummary summary = Fit(options, &problem);
  EXPECT_TRUE(summary.has_estimate()) << summary.message;
  return summary.error.rmse();
}

TEST(SmoothedStartTest, FollowsMarkersOnAClothThatIsNotFlat) {
  for (const unsigned seed : {1u, 2u, 3u}) {
    const NoisyDrape drape = MakeDrape(12, seed);
    RecordedMotion markers = drape.motion;
    markers.points.clear();
    std::vector<Eigen::Index> rows;
    Eigen::Matrix3Xd rest(3, 0);
    for (int node = kSide + 1; node < kSide * kSide; node += 3) {
      markers.points.push_back(drape.motion.points[node]);
      for (int axis = 0; axis < 3; ++axis) rows.push_back(3 * node + axis);
      rest.conservativeResize(3, rest.cols() + 1);
      rest.rightCols(1) = markers.scene.mesh.rest_positions.col(node);
    }
    markers.positions = drape.motion.positions(rows, Eigen::all);
    markers.sigma = Eigen::VectorXd::Constant(rest.cols(), kNoise);
    // As without smoothing: the rest shape as a rigid body.
    const Eigen::Matrix3Xd seen = markers.positions.col(0).reshaped(3, rest.cols());
    const Eigen::Isometry3d rigid(Eigen::umeyama(rest, seen, false));
    StartAt((rigid * markers.scene.mesh.rest_positions).reshaped(), drape, &markers);
    const RecordedMotion smoothed = Smoothed(markers);
    EXPECT_LT(StartError(smoothed, drape), 0.4 * StartError(markers, drape)) << seed;
    EXPECT_LT(FittedRmse(smoothed), FittedRmse(markers)) << seed;
  }
}

TEST(SmoothedStartTest, DoesNotStartAtAFrameThatWasFlipped) {
  NoisyDrape drape = MakeDrape(0, 1);
  RecordedMotion& motion = drape.motion;
  const Eigen::MatrixXd frame = motion.positions.col(0).reshaped(3, kSide * kSide);
  for (int node = 0; node < kSide * kSide; ++node) {
    motion.positions.col(0).segment<3>(3 * node) = frame.col(node - node % kSide + kSide - 1 - node % kSide);
  }
  StartAt(motion.positions.col(0), drape, &motion);
  const RecordedMotion smoothed = Smoothed(motion);
  EXPECT_LT(StartError(smoothed, drape), 0.05 * StartError(motion, drape));
  EXPECT_LT(FittedRmse(smoothed), 0.7 * FittedRmse(motion));
}

}  // namespace
}  // namespace clothid::smoothed_start_test

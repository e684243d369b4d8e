// A small case for the table of pairs: what a cloth was like and how it was seen, and what the fit of it is asked.
// Every feature of the table changes parts of one; recordings are made when all have.
#ifndef CLOTHID_TESTS_IDENTIFY_PAIRS_PAIR_CASE_H_
#define CLOTHID_TESTS_IDENTIFY_PAIRS_PAIR_CASE_H_

#include <Eigen/Core>
#include <string>
#include <utility>
#include <vector>

#include "costs/field/field_request.h"
#include "identify/run.h"
#include "tests/costs/start/forget_start.h"
#include "tests/costs/synthetic_clouds.h"
#include "tests/costs/synthetic_forces.h"
#include "tests/costs/synthetic_motion.h"

namespace clothid {

struct PairCase {
  static constexpr double kStretch = 90.0, kNominalStretch = 60.0;  // N/m
  static constexpr double kNoise = 5e-4, kHandleNoise = 1e-4;       // m
  static constexpr double kForceNoise = 5e-3;                       // N

  // The truth, and what is seen of it.
  Scene truth = TrueScene();
  Eigen::Vector3d handle_shift = Eigen::Vector3d::Zero();  // m: the handles are so far from where the scene has them
  bool has_gauge = false, has_clouds = false, has_outliers = false;
  bool slides = false;                             // points do, about their nodes
  std::vector<double> bends = {2e-3};              // J, true k_bend of every recording
  StartSource start_source = StartSource::kScene;  // what of the start the fit knows
  double handle_noise = 0.0;                       // m, where it does not know it

  RunOptions options;  // without the recordings

  // 5 x 5 nodes that swing by two corners, shaken, in a steady wind along x and y; no contact.
  static Scene TrueScene() {
    Scene scene = Shaken(SwingScene());
    scene.material.stretch_stiffness = kStretch;
    scene.material.drag = 0.2;
    scene.material.damping = 0.5;  // without, a start that is a bit off shakes the cloth for as long as it is seen
    scene.wind.mean = {0.3, 0.5, 0.0};
    scene.solver.step_tolerance = 1e-8;
    return scene;
  }

  std::vector<RecordedMotion> Recordings() const {
    std::vector<RecordedMotion> motions;
    for (std::size_t r = 0; r < bends.size(); ++r) motions.push_back(Record(static_cast<unsigned>(r), bends[r]));
    return motions;
  }

  // Of a field: the one place that knows where these options are.
  void FitFields(const std::vector<FieldRequest>& requests) { options.fit.fields = requests; }

 private:
  RecordedMotion Record(unsigned index, double bend) const {
    Scene scene = truth;
    scene.material.bending_stiffness = bend;
    RecordedMotion motion = MakeMotion(scene, {{}, 0.0, 0.0, kNoise});
    if (has_gauge) AddForces({{}, {}, 21, kForceNoise, kForceNoise}, &motion);
    if (has_clouds) {
      motion.cloud_sigma = kNoise;
      AddClouds(30, kNoise, /*keep_points=*/true, &motion);
    }
    if (slides) SlideAboutNodes(index, &motion);
    AddLastingNoise(kNoise, 0.0, index + 5, &motion);
    if (has_outliers) {
      for (const int frame : {4, 9, 17}) motion.positions.col(frame).segment<2>(4 * frame).array() += 10.0 * kNoise;
    }
    SetKnownScene(&motion.scene);
    return IsUnknown(start_source) ? ForgetMovingStart(start_source, handle_noise, index + 9, std::move(motion))
                                   : motion;
  }

  // Not all over their triangles: with a start that nobody knows they have to tell about where the nodes are.
  static void SlideAboutNodes(unsigned index, RecordedMotion* motion) {
    const Eigen::MatrixXd nodes = motion->positions;
    SlidePoints(/*borders=*/true, index + 21, motion);
    motion->positions = nodes + 0.3 * (motion->positions - nodes);
  }

  void SetKnownScene(Scene* scene) const {
    scene->fields.clear();
    scene->material.stretch_stiffness = kNominalStretch;
    scene->material.bending_stiffness = TrueScene().material.bending_stiffness;
    scene->wind = TrueScene().wind;
    const HandlePath& path = scene->handles.path;
    const auto shift = handle_shift.replicate(path.num_handles(), path.times().size());
    scene->handles.path = HandlePath(path.times(), path.positions() - shift);
    for (const int node : scene->handles.nodes) scene->initial_positions.segment<3>(3 * node) -= handle_shift;
  }
};

}  // namespace clothid

#endif  // CLOTHID_TESTS_IDENTIFY_PAIRS_PAIR_CASE_H_

// What k_bend means does not depend on the mesh: a motion of an irregular mesh is fitted on coarser ones of every kind.
#include <gtest/gtest.h>

#include <algorithm>
#include <utility>
#include <vector>

#include "datasets/synthetic/regrid.h"
#include "identify/fit/fit.h"
#include "tests/costs/synthetic_motion.h"
#include "tests/identify/sensitivity_fit.h"
#include "tests/sim/sheet_meshes.h"

namespace clothid::mesh_independence_test {
namespace {

constexpr double kSide = 0.2;   // m
constexpr double kBend = 1e-3;  // N m, the truth

GridOptions Square(int nodes) {
  GridOptions grid;
  grid.nodes = {nodes, nodes};
  grid.size = {kSide, kSide};
  return grid;
}

// The mesh seen in a mirror, so that its diagonals run the other way.
Mesh Mirrored(Mesh mesh) {
  mesh.rest_positions.row(0) = (kSide - mesh.rest_positions.row(0).array()).matrix().eval();
  mesh.faces.row(1).swap(mesh.faces.row(2));
  return mesh;
}

int NodeAt(const Mesh& mesh, double x, double y) {
  Eigen::Index node = 0;
  (mesh.rest_positions.colwise() - Eigen::Vector3d(x, y, 0.0)).colwise().norm().minCoeff(&node);
  return static_cast<int>(node);
}

// A square sheet held at two opposite corners: its other two swing down and up again. It bends about the line that
// joins the handles, across one of the two diagonals of its grid.
Scene SwingingSheet(Mesh mesh, BendingLaw law) {
  Scene scene;
  scene.time_step = 0.005;
  scene.duration = 0.3;
  scene.mesh = std::move(mesh);
  scene.initial_positions = scene.mesh.rest_positions.reshaped();
  scene.initial_velocities = Eigen::VectorXd::Zero(scene.initial_positions.size());
  scene.handles.nodes = {NodeAt(scene.mesh, 0.0, 0.0), NodeAt(scene.mesh, kSide, kSide)};
  scene.material.density = 0.2;
  scene.material.stretch_stiffness = 500.0;
  scene.material.bending_stiffness = kBend;
  scene.material.drag = 0.1;
  scene.bending.law = law;
  return scene;
}

// 9 x 9 points of the cloth, the same ones on every mesh.
std::vector<ObservedPoint> Markers(const Mesh& mesh) { return PlaceOnMesh(mesh, MakeGrid(Square(9)).rest_positions); }

RecordedMotion Record(const Scene& scene) {
  RecordedMotion motion = MakeMotion(scene, {});
  motion.positions = Interpolate(Markers(scene.mesh), motion.positions);
  return motion;
}

// From a start that is twice or half of the most likely value.
double FittedBend(RecordedMotion motion, const Mesh& mesh, BendingLaw law) {
  motion.scene = SwingingSheet(mesh, law);
  motion.points = Markers(mesh);
  FitOptions options = OptionsFor({"k_bend"});
  options.weighs_model_error = false;  // every frame tells of the mesh
  options.overrides.start = {{"k_bend", law == BendingLaw::kPatches ? 2.0 * kBend : 0.25 * kBend}};
  FitProblem problem({motion}, options);
  const FitSummary summary = Fit(options, &problem);
  EXPECT_EQ(summary.status, FitStatus::kConverged) << summary.message;
  return summary.parameters[0].value;
}

class MeshIndependenceTest : public ::testing::Test {
 protected:
  static constexpr int kNodes = 13;

  // Of a mesh of twice the density, of the fourth kind.
  const RecordedMotion motion_ =
      Record(SwingingSheet(MakeSheet(SheetKind::kIrregular, Square(2 * kNodes - 1)), BendingLaw::kPatches));
  const Mesh right_angled_ = MakeSheet(SheetKind::kRightAngled, Square(kNodes));
};

TEST_F(MeshIndependenceTest, PatchesFindTheStiffnessOfTheClothOnEveryMesh) {
  std::vector<double> found;
  for (const Mesh& mesh : {right_angled_, Mirrored(right_angled_), MakeSheet(SheetKind::kAlternating, Square(kNodes)),
                           MakeSheet(SheetKind::kIrregular, Square(kNodes))}) {
    found.push_back(FittedBend(motion_, mesh, BendingLaw::kPatches));
  }
  const auto [least, most] = std::minmax_element(found.begin(), found.end());
  EXPECT_LT(*most, 1.05 * *least);
  for (const double value : found) EXPECT_NEAR(value, kBend, 0.06 * kBend);
}

// By edges the same cloth has another constant where diagonals run the other way.
TEST_F(MeshIndependenceTest, EdgesDoNot) {
  const double along = FittedBend(motion_, right_angled_, BendingLaw::kEdges);
  const double across = FittedBend(motion_, Mirrored(right_angled_), BendingLaw::kEdges);
  EXPECT_GT(along, 2.0 * across);
}

}  // namespace
}  // namespace clothid::mesh_independence_test

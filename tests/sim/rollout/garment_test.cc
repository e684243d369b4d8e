// Cloth whose rest shape is a UV map, and cloth that is sewn, in rollouts: it moves as the same cloth in one piece.
#include <gtest/gtest.h>

#include <Eigen/Core>
#include <Eigen/Geometry>
#include <cmath>
#include <vector>

#include "sim/cloth/cloth_model.h"
#include "sim/rollout/energy_loss.h"
#include "sim/rollout/handle_forces.h"
#include "sim/rollout/sized_scene.h"
#include "tests/expect_error.h"
#include "tests/sim/forces_of.h"
#include "tests/sim/garments.h"
#include "tests/sim/order_of_convergence.h"
#include "tests/sim/plain_scenes.h"
#include "tests/sim/sheet_meshes.h"
#include "tests/sim/woven_scene.h"

namespace clothid::garment_test {
namespace {

// Swings by a corner and bends, in moving air.
Scene Swinging(const Mesh& mesh, Integrator integrator) {
  Scene scene = ClothScene(SquareGrid(6, 0.3), 0.01);
  scene.integrator = integrator;
  scene.handles.nodes = {0, 1};
  scene.material.bending_stiffness = 1e-4;
  scene.material.drag = 0.1;
  scene.wind.mean = {1.0, 0.5, 0.0};
  scene.material.damping = 0.02;
  return WithMesh(scene, mesh);
}

TEST(UvRestTest, IsTheSameSheetBitForBit) {
  const Mesh sheet = MakeSheet(SheetKind::kIrregular, SquareGrid(6, 0.3));
  for (const Integrator integrator : {Integrator::kEuler, Integrator::kSdirk2}) {
    for (const bool is_woven : {false, true}) {
      for (const BendingLaw law : {BendingLaw::kPatches, BendingLaw::kEdges}) {
        if (is_woven && law == BendingLaw::kEdges) continue;
        const auto scene_of = [&](const Mesh& mesh) {
          Scene scene = Swinging(mesh, integrator);
          scene.bending = {law};
          return is_woven ? Woven(scene) : scene;
        };
        const Rollout plain = SimulateNominal(scene_of(sheet), 15),
                      by_uv = SimulateNominal(scene_of(WithUvRest(sheet)), 15);
        for (int step = 1; step <= 15; ++step) ASSERT_EQ(plain.positions(step), by_uv.positions(step)) << step;
      }
    }
  }
}

// In the map a piece may lie anywhere, turned, as long as the warp is turned with it or does not matter.
TEST(UvRestTest, PiecesMayLieElsewhere) {
  const Mesh sheet = MakeGrid(SquareGrid(6, 0.3));
  CutMesh cut = Cut(WithUvRest(sheet), GridLine(6, 6, true, 3), [](const Eigen::Vector3d& x) { return x.x() > 0.18; });
  const Mesh straight = Sewn(cut.mesh, {SeamOf(cut)});
  ASSERT_EQ(straight.faces, sheet.faces);
  LayElsewhere(1.1, {2.0, -3.0}, &cut);
  const Mesh turned = Sewn(cut.mesh, {SeamOf(cut)});
  EXPECT_LT((TriangleAreas(turned) - TriangleAreas(sheet)).norm(), 1e-15);
  const Scene one = Swinging(straight, Integrator::kSdirk2), other = Swinging(turned, Integrator::kSdirk2);
  const Eigen::VectorXd x = 1.1 * SimulateNominal(one, 5).positions(5);
  Eigen::VectorXd force = Eigen::VectorXd::Zero(x.size()), turned_force = force;
  const Material material = one.material;
  const double energy = MembraneOf(ClothModel(one)).AddForce(material, x, &force);
  EXPECT_NEAR(MembraneOf(ClothModel(other)).AddForce(material, x, &turned_force), energy, 1e-12 * energy);
  EXPECT_LT((force - turned_force).norm(), 1e-12 * force.norm());
  const Eigen::MatrixXd q = ClothModel(one).bending()->matrix();
  EXPECT_LT((q - Eigen::MatrixXd(ClothModel(other).bending()->matrix())).norm(), 1e-9 * q.norm());
}

TEST(UvRestTest, HasTheSameForcesAtHandles) {
  const Mesh sheet = MakeSheet(SheetKind::kIrregular, SquareGrid(6, 0.3));
  Eigen::VectorXd forces[2];
  for (int i = 0; i < 2; ++i) {
    const Scene scene = Swinging(i == 0 ? sheet : WithUvRest(sheet), Integrator::kSdirk2);
    const Rollout rollout = SimulateNominal(scene, 5);
    const ClothModel model(scene);
    const HandleForces at_handles(model, scene.nominal_parameters(), 5, {{0}, {1}});
    forces[i] = at_handles.At(4, {at_handles.Gather(rollout.positions(3)), at_handles.Gather(rollout.positions(4)),
                                  at_handles.Gather(rollout.positions(5))});
  }
  EXPECT_GT(forces[0].norm(), 1e-3);
  EXPECT_EQ(forces[0], forces[1]);
}

// size.x and size.y stretch along u and v.
TEST(UvRestTest, HasASizeAlongUAndV) {
  const Mesh sheet = MakeSheet(SheetKind::kIrregular, SquareGrid(6, 0.3));
  const std::array<double, 2> size = {1.1, 0.9};
  const Scene plain = SizedScene(Swinging(sheet, Integrator::kEuler), size);
  const Scene by_uv = SizedScene(Swinging(WithUvRest(sheet), Integrator::kEuler), size);
  EXPECT_LT((TriangleAreas(plain.mesh) - TriangleAreas(by_uv.mesh)).norm(), 1e-15);
  EXPECT_EQ(by_uv.mesh.rest_positions, sheet.rest_positions);
  const Eigen::MatrixXd q = ClothModel(plain, sheet).bending()->matrix();
  const Mesh chosen_on = WithUvRest(sheet);
  EXPECT_LT((q - Eigen::MatrixXd(ClothModel(by_uv, chosen_on).bending()->matrix())).norm(), 1e-10 * q.norm());
}

// A sleeve of a flat panel bends and stretches as one whose mesh closes on itself and is bent flat.
TEST(SleeveTest, OfAPanelIsThatOfAClosedMesh) {
  constexpr int kAround = 12, kRows = 5;
  const CutMesh panel = SleevePanel(kAround + 1, kRows, 0.36, 0.12);
  Scene scene = Swinging(Sewn(panel.mesh, {SeamOf(panel)}), Integrator::kSdirk2);
  ASSERT_EQ(scene.mesh.num_nodes(), kAround * kRows);
  Scene closed = scene;
  closed.mesh.corner_rest.resize(2, 0);
  closed.bending.is_flat_at_rest = true;
  const ClothModel sewn_model(scene), closed_model(closed);
  const Eigen::MatrixXd q = closed_model.bending()->matrix();
  EXPECT_LT((q - Eigen::MatrixXd(sewn_model.bending()->matrix())).norm(), 1e-9 * q.norm());
  EXPECT_LT((sewn_model.node_areas() - closed_model.node_areas()).norm(), 1e-15);
  const Eigen::VectorXd x = SimulateNominal(closed, 3).positions(3);
  EXPECT_LT((x - SimulateNominal(scene, 3).positions(3)).norm(), 1e-9);
}

// Of a cylinder of the radius R about an axis, E = D/2 area/R^2, whose seam is like the rest of it.
TEST(SleeveTest, HasTheBendingEnergyOfACylinder) {
  constexpr int kAround = 40;
  const CutMesh panel = SleevePanel(kAround + 1, 9, 0.4, 0.08);
  const Scene scene = Swinging(Sewn(panel.mesh, {SeamOf(panel)}), Integrator::kEuler);
  const ClothModel model(scene);
  Eigen::VectorXd force = Eigen::VectorXd::Zero(scene.initial_positions.size());
  const double energy = model.bending()->AddForce(1.0, scene.initial_positions, &force);
  const double radius = 0.4 / (2.0 * kPi);
  EXPECT_NEAR(energy, 0.5 * 0.4 * 0.08 / (radius * radius), 0.01 * energy);
  for (int row = 0; row < 9; ++row) {  // every other node around is alike
    const double at_seam = force.segment<3>(3 * kAround * row).norm();
    EXPECT_NEAR(force.segment<3>(3 * (kAround * row + 6)).norm(), at_seam, 1e-9 * at_seam);
  }
}

constexpr int kColumns = 24, kRows = 5, kHeld = 4;
constexpr double kSpacing = 0.1 / 20.5;

Scene Strip(const Mesh& mesh) {
  Scene scene = ClothScene(SquareGrid(4, 0.1), 0.3);
  scene.material.density = 0.2;
  scene.material.stretch_stiffness = 1000.0;
  scene.material.bending_stiffness = 1e-4;
  scene.gravity = {0.0, 0.0, -4.0 * 1e-4 / (0.2 * std::pow(0.1, 3))};  // the tip sinks by 43 % of the length
  scene.solver.step_tolerance = 1e-10;
  scene = WithMesh(scene, mesh);
  for (int node = 0; node < mesh.num_nodes(); ++node) {
    if (mesh.rest_positions(0, node) < (kHeld - 0.5) * kSpacing) scene.handles.nodes.push_back(node);
  }
  return scene;
}

// How far the tip is below the clamp, at rest.
double Sag(const Mesh& mesh) {
  const Rollout rollout = SimulateNominal(Strip(mesh), 30);
  double sum = 0.0;
  for (int row = 0; row < kRows; ++row) sum -= rollout.positions(30)[3 * (row * kColumns + kColumns - 1) + 2];
  return sum / kRows;
}

Mesh StripMesh(SheetKind kind) {
  GridOptions grid;
  grid.nodes = {kColumns, kRows};
  grid.size = {(kColumns - 1) * kSpacing, (kRows - 1) * kSpacing};
  return MakeSheet(kind, grid, kHeld);
}

CutMesh CutAcross(const Mesh& strip) {
  return Cut(WithUvRest(strip), GridLine(kColumns, kRows, true, 12),
             [&](const Eigen::Vector3d& x) { return x.x() > 12.0 * kSpacing; });
}

class SewnStripTest : public ::testing::TestWithParam<SheetKind> {};

TEST_P(SewnStripTest, SagsAsTheStripDoes) {
  const Mesh strip = StripMesh(GetParam());
  const double sag = Sag(strip);
  EXPECT_GT(sag, 0.03);
  CutMesh cut = CutAcross(strip);
  EXPECT_EQ(Sag(Sewn(cut.mesh, {SeamOf(cut)})), sag);  // the map is the sheet: nothing is different
  LayElsewhere(0.9, {-1.0, 0.5}, &cut);
  EXPECT_NEAR(Sag(Sewn(cut.mesh, {SeamOf(cut)})), sag, 1e-6 * sag);
}

INSTANTIATE_TEST_SUITE_P(Sheets, SewnStripTest, ::testing::Values(SheetKind::kAlternating, SheetKind::kRightAngled),
                         [](const auto& test) { return SheetName(test.param); });

// Nothing bends across a fold: the half beyond it hangs down.
TEST(FoldTest, IsAHinge) {
  const CutMesh cut = CutAcross(StripMesh(SheetKind::kAlternating));
  Seam seam = SeamOf(cut);
  seam.is_fold = true;
  const Mesh folded = Sewn(cut.mesh, {seam});
  for (const BendingLaw law : {BendingLaw::kPatches, BendingLaw::kEdges}) {
    Scene scene = Strip(folded);
    scene.bending.law = law;
    Eigen::Matrix3Xd bent = folded.rest_positions;  // by a right angle
    for (auto x : bent.colwise())
      x = x.x() > 12.0 * kSpacing ? Eigen::Vector3d(12.0 * kSpacing, x.y(), 12.0 * kSpacing - x.x()) : x;
    Eigen::VectorXd force = Eigen::VectorXd::Zero(bent.size());
    const ClothModel model(scene);
    const double energy = model.bending()->AddForce(1.0, bent.reshaped(), &force);
    scene.mesh.folds.clear();
    Eigen::VectorXd unfolded_force = Eigen::VectorXd::Zero(bent.size());
    const double unfolded = ClothModel(scene).bending()->AddForce(1.0, bent.reshaped(), &unfolded_force);
    EXPECT_GT(unfolded, 1.0);
    EXPECT_LT(std::abs(energy), 1e-10 * unfolded);
    EXPECT_LT(force.norm(), 1e-10 * unfolded_force.norm());
  }
}

// Along the strip, by links that carry no bending themselves: the two halves sag as one within 0.1 %, and the seam is
// open by less than 0.1 mm.
TEST(DrawnSeamTest, AlongAStripItSagsAsTheStripDoes) {
  const Mesh strip = StripMesh(SheetKind::kAlternating);
  CutMesh cut =
      Cut(strip, GridLine(kColumns, kRows, false, 2), [](const Eigen::Vector3d& x) { return x.y() > 2.0 * kSpacing; });
  const double sag = Sag(strip);
  Seam seam = SeamOf(cut);
  seam.is_drawn = true;
  const Mesh at_once = Sewn(cut.mesh, {seam});
  EXPECT_NEAR(Sag(at_once), sag, 1e-3 * sag);
  seam.closing_time = 2.0;  // s, of 9
  EXPECT_NEAR(Sag(Sewn(cut.mesh, {seam})), sag, 1e-3 * sag);
  const Rollout rollout = SimulateNominal(Strip(Sewn(cut.mesh, {seam})), 30);
  for (std::size_t i = 0; i < cut.seam.size(); ++i) {
    const Eigen::VectorXd& x = rollout.positions(30);
    EXPECT_LT((x.segment<3>(3 * cut.seam[i]) - x.segment<3>(3 * cut.beyond[i])).norm(), 1e-4);
  }
}

// Two pieces in free fall, apart by 5 mm, are drawn together in 0.1 s; the gap is c(t) d_0 but for what the pieces'
// inertia needs.
TEST(DrawnSeamTest, ClosesInItsTime) {
  for (const Integrator integrator : {Integrator::kEuler, Integrator::kSdirk2}) {
    CutMesh cut = Cut(MakeGrid(SquareGrid(5, 0.2)), GridLine(5, 5, true, 2),
                      [](const Eigen::Vector3d& x) { return x.x() > 0.1; });
    for (int node = 0; node < cut.mesh.num_nodes(); ++node) {
      const bool is_beyond = node >= 25 || node % 5 > 2;
      if (is_beyond) cut.mesh.rest_positions(0, node) += 0.005;
    }
    Seam seam = SeamOf(cut);
    seam.is_drawn = true;
    seam.closing_time = 0.1;
    Scene scene = WithMesh(ClothScene(SquareGrid(5, 0.2), 0.01), Sewn(cut.mesh, {seam}));
    scene.integrator = integrator;
    const Rollout rollout = SimulateNominal(scene, 10);
    for (const int step : {3, 6, 10}) {
      for (int i = 0; i < 5; ++i) {
        const Eigen::VectorXd& x = rollout.positions(step);
        const double gap = (x.segment<3>(3 * cut.beyond[i]) - x.segment<3>(3 * cut.seam[i])).norm();
        EXPECT_NEAR(gap, 0.005 * (1.0 - 0.1 * step), 5e-4) << step;
      }
    }
  }
}

// Each stage draws the seam as far as it is at the stage's own time: without that the order would be 1.
TEST(DrawnSeamTest, IsOfTheOrderOfItsIntegrator) {
  CutMesh cut =
      Cut(MakeGrid(SquareGrid(4, 0.3)), GridLine(4, 4, true, 1), [](const Eigen::Vector3d& x) { return x.x() > 0.1; });
  for (const int node : cut.beyond) cut.mesh.rest_positions(2, node) += 0.05;
  Seam seam = SeamOf(cut);
  seam.is_drawn = true;
  seam.closing_time = 0.2;
  seam.stiffness = 100.0;
  Scene scene = WithMesh(ClothScene(SquareGrid(4, 0.3), 0.01), Sewn(cut.mesh, {seam}));
  scene.duration = 0.08;
  scene.handles.nodes = {0, 12};
  scene.material.stretch_stiffness = 20.0;
  EXPECT_NEAR(Order(scene, Integrator::kEuler, 4), 1.0, 0.2);
  EXPECT_NEAR(Order(scene, Integrator::kSdirk2, 4), 2.0, 0.2);
}

// Energy changes by the work of what draws the seam less the losses of the integrator.
TEST(DrawnSeamTest, BalancesEnergy) {
  for (const Integrator integrator : {Integrator::kEuler, Integrator::kSdirk2}) {
    const CutMesh cut = CutAcross(StripMesh(SheetKind::kAlternating));
    CutMesh apart = cut;
    for (const int node : cut.beyond) apart.mesh.rest_positions(2, node) += 0.002;
    Seam seam = SeamOf(cut);
    seam.is_drawn = true;
    seam.closing_time = 0.055;
    Scene scene = Strip(Sewn(apart.mesh, {seam}));
    scene.integrator = integrator;
    scene.time_step = 0.01;
    scene.duration = 0.1;
    scene.start_time = 0.005;
    Simulator simulator(scene);
    const Rollout rollout = Simulate(scene.nominal_parameters(), 10, &simulator);
    ASSERT_TRUE(rollout.ok());
    RecordReader reader(rollout, &simulator);
    double work = 0.0, lost = 0.0;
    for (int i = 0; i < static_cast<int>(rollout.records.size()); ++i) {
      if (!rollout.records[i].ends_step()) continue;
      work += SeamWork(rollout, i, &reader, simulator);
      const EnergyLoss loss = StepEnergyLoss(rollout, i, &reader, simulator);
      EXPECT_TRUE(integrator == Integrator::kSdirk2 || loss.total() > 0.0) << i;
      lost += loss.total();
    }
    const StepRecord& end = rollout.records.back();
    const double before = StateEnergy(rollout.parameters, rollout.initial_positions, rollout.initial_velocities,
                                      simulator, scene.start_time)
                              .total();
    const double after = StateEnergy(rollout.parameters, end.positions, end.velocities, simulator, end.time).total();
    EXPECT_NE(work, 0.0);
    EXPECT_NEAR(after - before, work - lost, 1e-9 * (std::abs(work) + std::abs(lost)));
  }
}

// A weight on a button: the link is longer by its force over the stiffness.
TEST(ButtonTest, CarriesWhatHangsOnIt) {
  Mesh mesh = MakeGrid(SquareGrid(3, 0.1));
  const Mesh one = mesh;
  mesh.rest_positions.conservativeResize(3, 18);
  mesh.rest_positions.rightCols<9>() = one.rest_positions;
  mesh.faces.conservativeResize(3, 16);
  mesh.faces.rightCols<8>() = one.faces.array() + 9;
  Sewing sewing(&mesh);
  for (const int node : {0, 2, 6, 8}) sewing.AddButton(node, 9 + node);
  sewing.Finish();
  Scene scene = WithMesh(ClothScene(SquareGrid(3, 0.1), 1.0), mesh);
  for (int node = 0; node < 9; ++node) scene.handles.nodes.push_back(node);
  scene.material.stretch_stiffness = 1e4;
  scene.material.bending_stiffness = 1.0;
  const Rollout rollout = SimulateNominal(scene, 60);
  const Eigen::VectorXd& x = rollout.positions(60);
  const double weight = scene.material.density * 0.01 * 9.81;
  double length = 0.0;
  for (const int node : {0, 2, 6, 8}) length -= x[3 * (9 + node) + 2] / 4.0;
  EXPECT_NEAR(length, weight / (4.0 * kButtonStiffness), 1e-3 * length);
  const ClothModel model(scene);
  const HandleForces forces(model, scene.nominal_parameters(), 60, {scene.handles.nodes});
  const Eigen::VectorXd held =
      forces.At(60, {forces.Gather(rollout.positions(58)), forces.Gather(rollout.positions(59)),
                     forces.Gather(rollout.positions(60))});
  EXPECT_LT((held - Eigen::Vector3d(0.0, 0.0, 2.0 * weight)).norm(), 1e-5 * weight);
}

}  // namespace
}  // namespace clothid::garment_test

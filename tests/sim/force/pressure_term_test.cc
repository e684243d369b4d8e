// A pressure on one side of a cloth: its formula, its derivatives, closed forms of rollouts. Its derivatives through
// rollouts: tests/sim/derivative/air_derivative_test.cc; forces at handles: tests/sim/rollout/handle_forces_test.cc.
#include "sim/force/pressure_term.h"

#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <cmath>
#include <random>

#include "sim/cloth/cloth_model.h"
#include "tests/sim/plain_scenes.h"

namespace clothid::pressure_term_test {
namespace {

constexpr double kPressure = 3.0;  // Pa

Eigen::VectorXd Random(Eigen::Index size, double scale, unsigned seed) {
  std::mt19937_64 generator(seed);
  std::normal_distribution<double> normal(0.0, scale);
  Eigen::VectorXd vector(size);
  for (double& value : vector) value = normal(generator);
  return vector;
}

// A crumpled sheet.
class PressureTermTest : public testing::Test {
 protected:
  PressureTermTest() : scene_(ClothScene(SquareGrid(4, 0.3), 0.01)), term_(scene_.mesh.faces) {
    parameters_.material.pressure = kPressure;
    positions_ = scene_.initial_positions + Random(scene_.initial_positions.size(), 0.02, 3);
  }

  ForcePoint Point() const { return {parameters_, 0.01, 0.0, positions_, positions_}; }

  Eigen::VectorXd ForceAt(const Eigen::VectorXd& predicted, double* potential = nullptr) const {
    ForceStart start;
    start.predicted = predicted;
    std::unique_ptr<HeldForce> held;
    term_.Hold(parameters_, 0.0, start, &held);
    Eigen::VectorXd force = Eigen::VectorXd::Zero(predicted.size());
    const double value = term_.AddForce(Point(), held.get(), &force);
    if (potential != nullptr) *potential = value;
    return force;
  }

  Scene scene_;
  PressureTerm term_;
  Parameters parameters_;
  Eigen::VectorXd positions_;
};

TEST_F(PressureTermTest, IsTheFormula) {
  Eigen::VectorXd expected = Eigen::VectorXd::Zero(positions_.size());
  for (const auto& face : scene_.mesh.faces.colwise()) {
    Eigen::Matrix3d corners;
    for (int k = 0; k < 3; ++k) corners.col(k) = positions_.segment<3>(3 * face[k]);
    const Eigen::Vector3d cross = (corners.col(1) - corners.col(0)).cross(corners.col(2) - corners.col(1));
    const double area = 0.5 * cross.norm();
    for (const int node : face) expected.segment<3>(3 * node) += kPressure * area / 3.0 * cross.normalized();
  }
  double potential = 0.0;
  EXPECT_LT((ForceAt(positions_, &potential) - expected).norm(), 1e-14 * expected.norm());
  EXPECT_NEAR(potential, -expected.dot(positions_), 1e-13 * std::abs(potential));
}

TEST_F(PressureTermTest, DerivativesByThePredictionAreDifferences) {
  const Eigen::VectorXd direction = Random(positions_.size(), 1.0, 4), other = Random(positions_.size(), 1.0, 5);
  Eigen::MatrixXd product = Eigen::MatrixXd::Zero(positions_.size(), 1), transposed = product;
  term_.AddPredictionProduct(2.0, Point(), nullptr, positions_, direction, &product);
  term_.AddPredictionProductTransposed(2.0, Point(), nullptr, positions_, other, &transposed);
  EXPECT_NEAR(other.dot(product.col(0)), direction.dot(transposed.col(0)), 1e-13 * other.norm() * product.norm());
  constexpr double kStep = 1e-4;  // the force is quadratic
  const Eigen::VectorXd difference =
      (ForceAt(positions_ + kStep * direction) - ForceAt(positions_ - kStep * direction)) / kStep;
  EXPECT_LT((product - difference).norm(), 1e-10 * difference.norm());
}

TEST_F(PressureTermTest, AddsUpToNothingOnAClosedCloth) {
  Mesh closed;  // a tetrahedron
  closed.rest_positions = Eigen::Matrix<double, 3, 4>{{0.0, 0.2, 0.0, 0.1}, {0.0, 0.0, 0.3, 0.1}, {0.0, 0.1, 0.0, 0.2}};
  closed.faces = Eigen::Matrix<int, 3, 4>{{0, 0, 0, 1}, {2, 1, 3, 2}, {1, 3, 2, 3}};
  term_ = PressureTerm(closed.faces);
  positions_ = closed.rest_positions.reshaped();
  const Eigen::VectorXd force = ForceAt(positions_);
  EXPECT_LT(force.reshaped(3, 4).rowwise().sum().norm(), 1e-15);
  // Outwards: the work of growing.
  const Eigen::Vector3d middle = closed.rest_positions.rowwise().mean();
  EXPECT_GT((force.reshaped(3, 4).array() * (closed.rest_positions.colwise() - middle).array()).sum(), 0.0);
}

TEST(PressureTest, IsThereWhereTheSceneHasIt) {
  Scene scene = ClothScene(SquareGrid(4, 0.3), 0.01);
  EXPECT_EQ(ClothModel(scene).forces().Find<PressureTerm>(), nullptr);
  scene.parameters["pressure"].nominal = -2.0;
  EXPECT_NE(ClothModel(scene).forces().Find<PressureTerm>(), nullptr);
}

// A flat sheet speeds up by p/rho along its normal.
TEST(PressureTest, PushesASheetThatIsFree) {
  for (const Integrator integrator : {Integrator::kEuler, Integrator::kSdirk2}) {
    Scene scene = ClothScene(SquareGrid(4, 0.3), 0.01);
    scene.integrator = integrator;
    scene.gravity.setZero();
    scene.material.pressure = -kPressure;
    scene.material.bending_stiffness = 1e-3;
    const Rollout rollout = SimulateNominal(scene, 20);
    const double speed = -kPressure / scene.material.density * 0.2;
    for (int node = 0; node < scene.mesh.num_nodes(); ++node) {
      EXPECT_NEAR(rollout.records.back().velocities[3 * node + 2], speed, 1e-9 * std::abs(speed));
    }
  }
}

// A strip that is held at both ends, D apart: an arc of radius T/p with the length D (1 + T/k), T = p R its tension.
TEST(PressureTest, BulgesAStripToAnArc) {
  constexpr double kDistance = 0.3, kStiffness = 20.0;
  GridOptions grid;
  grid.nodes = {41, 2};
  grid.size = {kDistance, kDistance / 40.0};
  Scene scene = ClothScene(grid, 0.02);
  scene.gravity.setZero();
  scene.material.pressure = 10.0;
  scene.material.stretch_stiffness = kStiffness;
  scene.material.drag = 2.0;
  scene.handles.nodes = {0, 41, 40, 81};
  const Eigen::VectorXd end = SimulateNominal(scene, 400).records.back().positions;
  double low = 0.5 * kDistance * (1.0 + 1e-9), high = 100.0 * kDistance;  // R
  for (int i = 0; i < 200; ++i) {
    const double radius = 0.5 * (low + high), angle = std::asin(0.5 * kDistance / radius);
    const bool is_too_long = 2.0 * radius * angle > kDistance * (1.0 + scene.material.pressure * radius / kStiffness);
    (is_too_long ? low : high) = radius;
  }
  const double height = low * (1.0 - std::cos(std::asin(0.5 * kDistance / low)));
  EXPECT_NEAR(end[3 * 20 + 2], height, 2e-3 * height);
}

}  // namespace
}  // namespace clothid::pressure_term_test

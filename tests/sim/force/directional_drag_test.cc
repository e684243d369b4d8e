// Drag by direction: the formula, and every derivative against central differences.
#include "sim/force/directional_drag.h"

#include <gtest/gtest.h>

#include <Eigen/Core>
#include <Eigen/Geometry>
#include <memory>
#include <random>
#include <string>

#include "sim/cloth/cloth_model.h"
#include "sim/matrix/dense.h"
#include "tests/sim/plain_scenes.h"

namespace clothid::directional_drag_test {
namespace {

constexpr double kTime = 0.3, kNormal = 0.7, kTangential = 0.2;

// A crumpled cloth of 18 triangles with a handle, whose nodes have velocities of their own.
class DirectionalDragTest : public ::testing::TestWithParam<AirLaw> {
 protected:
  DirectionalDragTest() : scene_(MakeScene()), model_(scene_), parameters_(scene_.nominal_parameters()) {
    x_ = scene_.initial_positions + Random(0.02);
    v_ = Random(1.0);
    Hold(x_);
  }

  static Scene MakeScene() {
    Scene scene = ClothScene(SquareGrid(4, 0.3), 0.01);
    scene.handles.nodes = {3};
    scene.material.normal_drag = kNormal;
    scene.material.tangential_drag = kTangential;
    scene.air_law = GetParam();
    scene.wind.mean = {1.0, -2.0, 0.5};
    scene.wind.gust = {0.0, 3.0, 1.0};
    scene.wind.frequency = 9.0;
    scene.wind.wave_vector = {2.0, 5.0, 0.0};
    scene.wind.shear = {1.0, -3.0, 0.0};
    return scene;
  }

  const DirectionalDrag& drag() const { return *model_.forces().Find<DirectionalDrag>(); }

  // In the wind of `parameters_`.
  void Hold(const Eigen::VectorXd& predicted) {
    ForceStart start;
    start.predicted = predicted;
    drag().Hold(parameters_, kTime, start, &held_);
  }

  // Of a solve of 1 s, so that potentials are D.
  ForcePoint At(const Eigen::VectorXd& velocities) const { return {parameters_, 1.0, kTime, x_, velocities}; }

  Eigen::VectorXd Random(double scale) {
    std::normal_distribution<double> normal(0.0, scale);
    Eigen::VectorXd vector(scene_.initial_positions.size());
    for (double& value : vector) value = normal(generator_);
    return vector;
  }

  Eigen::VectorXd Force(const Eigen::VectorXd& velocities) const {
    Eigen::VectorXd force = Eigen::VectorXd::Zero(velocities.size());
    drag().AddForce(At(velocities), held_.get(), &force);
    return force;
  }

  double Potential(const Eigen::VectorXd& velocities) const {
    Eigen::VectorXd unused = Eigen::VectorXd::Zero(velocities.size());
    return drag().AddForce(At(velocities), held_.get(), &unused);
  }

  std::mt19937_64 generator_{3};
  Scene scene_;
  ClothModel model_;
  Parameters parameters_;
  Eigen::VectorXd x_, v_;
  std::unique_ptr<HeldForce> held_;
};

TEST_P(DirectionalDragTest, TheForceIsTheFormula) {
  Eigen::VectorXd expected = Eigen::VectorXd::Zero(v_.size());
  const Eigen::VectorXd areas = TriangleAreas(scene_.mesh);
  const Eigen::Vector3d center(0.15, 0.15, 0.0);  // of the square
  for (int f = 0; f < scene_.mesh.num_faces(); ++f) {
    const Eigen::Vector3i nodes = scene_.mesh.faces.col(f);
    Eigen::Vector3d x[3], v = Eigen::Vector3d::Zero(), rest = Eigen::Vector3d::Zero();
    for (int i = 0; i < 3; ++i) {
      x[i] = x_.segment<3>(3 * nodes[i]);
      v += v_.segment<3>(3 * nodes[i]) / 3.0;
      rest += scene_.mesh.rest_positions.col(nodes[i]) / 3.0;
    }
    const Eigen::Vector3d n = (x[1] - x[0]).cross(x[2] - x[0]).normalized();
    const Eigen::Vector3d u = scene_.wind.At(kTime, {rest, rest - center}) - v;
    const Eigen::Vector3d u_n = u.dot(n) * n, u_t = u - u_n;
    const bool quadratic = GetParam() == AirLaw::kQuadratic;
    const Eigen::Vector3d force = areas[f] * (kNormal * (quadratic ? u_n.norm() : 1.0) * u_n +
                                              kTangential * (quadratic ? u_t.norm() : 1.0) * u_t);
    for (int i = 0; i < 3; ++i) expected.segment<3>(3 * nodes[i]) += force / 3.0;
  }
  EXPECT_LT((Force(v_) - expected).norm(), 1e-13 * expected.norm());
}

TEST_P(DirectionalDragTest, TheForceIsMinusTheGradientOfThePotential) {
  const Eigen::VectorXd direction = Random(1.0);
  const double step = 1e-5;
  const double difference = (Potential(v_ + step * direction) - Potential(v_ - step * direction)) / (2.0 * step);
  EXPECT_NEAR(-Force(v_).dot(direction), difference, 1e-8 * std::abs(difference));
}

TEST_P(DirectionalDragTest, TheHessianIsMinusTheDerivativeOfTheForce) {
  const Eigen::VectorXd free = model_.Gather(Random(1.0));
  const Eigen::VectorXd direction = model_.ScatterColumns(free);
  const double step = 1e-5;
  const Eigen::VectorXd difference = (Force(v_ - step * direction) - Force(v_ + step * direction)) / (2.0 * step);
  Eigen::MatrixXd product = Eigen::MatrixXd::Zero(v_.size(), 1);
  drag().AddVelocityProduct(1.0, At(v_), held_.get(), direction, &product);
  EXPECT_LT((product - difference).norm(), 1e-8 * difference.norm());
  BlockMatrix hessian(model_.pattern());
  drag().AddVelocityHessian(1.0, At(v_), held_.get(), &hessian);
  EXPECT_LT((hessian.view() * free - model_.Gather(product)).norm(), 1e-13 * product.norm());
  const Eigen::MatrixXd dense(hessian.view());
  EXPECT_EQ((dense - dense.transpose()).norm(), 0.0);
  EXPECT_GT(SymmetricEigenvalues(dense).minCoeff(), -1e-14 * dense.norm());
}

TEST_P(DirectionalDragTest, TheDerivativeByThePredictedPositionsIsADifference) {
  const Eigen::VectorXd direction = Random(1.0), other = Random(1.0);
  Eigen::MatrixXd product = Eigen::MatrixXd::Zero(x_.size(), 1), transposed = product;
  drag().AddPredictionProduct(2.0, At(v_), held_.get(), x_, direction, &product);
  drag().AddPredictionProductTransposed(2.0, At(v_), held_.get(), x_, other, &transposed);
  EXPECT_NEAR(other.dot(product.col(0)), direction.dot(transposed.col(0)), 1e-12 * other.norm() * product.norm());
  Eigen::VectorXd sides[2];
  const double step = 1e-7;
  for (const int side : {0, 1}) {
    Hold(x_ + (side == 0 ? -step : step) * direction);
    sides[side] = Force(v_);
  }
  const Eigen::VectorXd difference = (sides[1] - sides[0]) / step;
  EXPECT_LT((product - difference).norm(), 1e-6 * difference.norm());
}

TEST_P(DirectionalDragTest, TheDerivativeByTheWindIsADifference) {
  for (const ParameterId id : ParametersOf(ParameterTerm::kWind)) {
    Eigen::VectorXd derivative = Eigen::VectorXd::Zero(v_.size()), sides[2];
    Hold(x_);
    drag().AddDerivative(id, 1.0, At(v_), held_.get(), &derivative);
    const double value = GetParameter(parameters_, id), step = 1e-6;
    for (const int side : {0, 1}) {
      SetParameter(id, value + (side == 0 ? -step : step), &parameters_);
      Hold(x_);
      sides[side] = Force(v_);
    }
    SetParameter(id, value, &parameters_);
    const Eigen::VectorXd difference = (sides[1] - sides[0]) / (2.0 * step);
    EXPECT_LE((derivative - difference).norm(), 1e-7 * difference.norm()) << ParameterName(id, {});
  }
}

// Wind that meets the cloth squarely, or not at all, has no tangential direction.
TEST_P(DirectionalDragTest, AirAtRestHasFiniteDerivatives) {
  parameters_.wind = Wind();
  for (const double speed : {0.0, 1.0}) {
    parameters_.wind.mean.z() = speed;
    Hold(scene_.initial_positions);
    const Eigen::VectorXd still = Eigen::VectorXd::Zero(v_.size());
    BlockMatrix hessian(model_.pattern());
    drag().AddVelocityHessian(1.0, At(still), held_.get(), &hessian);
    EXPECT_TRUE(hessian.values.allFinite());
    Eigen::MatrixXd product = Eigen::MatrixXd::Zero(v_.size(), 1);
    drag().AddPredictionProduct(1.0, At(still), held_.get(), scene_.initial_positions, v_, &product);
    EXPECT_TRUE(product.allFinite());
    EXPECT_TRUE(Force(still).allFinite());
  }
}

INSTANTIATE_TEST_SUITE_P(Laws, DirectionalDragTest, ::testing::Values(AirLaw::kLinear, AirLaw::kQuadratic),
                         [](const auto& test) {
                           return std::string(test.param == AirLaw::kLinear ? "Linear" : "Quadratic");
                         });

}  // namespace
}  // namespace clothid::directional_drag_test

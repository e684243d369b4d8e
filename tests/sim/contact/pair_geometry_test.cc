// Closest points of two features and their derivatives, against brute force and differences.
#include "sim/contact/pair_geometry.h"

#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <algorithm>

#include "sim/contact/impact_share.h"
#include "tests/sim/random_numbers.h"

namespace clothid::pair_geometry_test {
namespace {

const PairFeatures kPairs[] = {{PairKind::kVertexVertex, {0, 1, -1, -1}},
                               {PairKind::kVertexEdge, {0, 1, 2, -1}},
                               {PairKind::kVertexFace, {0, 1, 2, 3}},
                               {PairKind::kEdgeEdge, {0, 1, 2, 3}}};

Eigen::VectorXd RandomNodes(int seed) {
  std::mt19937_64 generator(seed);
  std::normal_distribution<double> normal;
  Eigen::VectorXd positions(12);
  for (double& value : positions) value = normal(generator);
  return positions;
}

// The offset is normal to every direction in which its ends may move.
TEST(PairGeometryTest, ClosestPointsAreStationary) {
  for (const PairFeatures& pair : kPairs) {
    const Eigen::VectorXd x = RandomNodes(3);
    const PairGeometry geometry = EvaluatePair(pair, x);
    const auto node = [&](int i) -> Eigen::Vector3d { return x.segment<3>(3 * i); };
    Eigen::Vector3d offset = Eigen::Vector3d::Zero();
    for (int i = 0; i < pair.num_nodes(); ++i) offset += geometry.weights[i] * node(i);
    EXPECT_NEAR((offset - geometry.distance * geometry.normal).norm(), 0.0, 1e-14);
    EXPECT_NEAR(geometry.weights.sum(), 0.0, 1e-14);  // a translation does not count
    const int first = pair.kind == PairKind::kEdgeEdge ? 0 : 1;
    for (int i = first; i + 1 < pair.num_nodes(); ++i) {
      if (pair.kind == PairKind::kEdgeEdge && i == 1) continue;
      EXPECT_NEAR(geometry.normal.dot(node(i + 1) - node(i)), 0.0, 1e-13) << i;
    }
  }
}

TEST(PairGeometryTest, GradientIsThatOfDifferences) {
  for (const PairFeatures& pair : kPairs) {
    for (int seed = 1; seed < 6; ++seed) {
      const Eigen::VectorXd x = RandomNodes(seed);
      const PairGeometryGradient gradient = DifferentiatePair(pair, x);
      for (int column = 0; column < 3 * pair.num_nodes(); ++column) {
        constexpr double kStep = 1e-6;
        Eigen::VectorXd plus = x, minus = x;
        plus[column] += kStep;
        minus[column] -= kStep;
        const PairGeometry a = EvaluatePair(pair, plus), b = EvaluatePair(pair, minus);
        const double scale = 1.0 + gradient.weights.norm() + gradient.normal.norm();
        EXPECT_NEAR(((a.weights - b.weights) / (2.0 * kStep) - gradient.weights.col(column)).norm(), 0.0, 1e-7 * scale);
        EXPECT_NEAR(((a.normal - b.normal) / (2.0 * kStep) - gradient.normal.col(column)).norm(), 0.0, 1e-7 * scale);
        EXPECT_NEAR((a.distance - b.distance) / (2.0 * kStep), gradient.distance(column), 1e-7 * scale);
      }
    }
  }
}

// A pair that slips, with velocities that change by `share` of what would make its impact a whole one.
PairContact SlippingPair(const PairFeatures& pair, const Eigen::VectorXd& x) {
  PairContact contact;
  contact.candidate.features = pair;
  contact.candidate.geometry = EvaluatePair(pair, x);
  const Eigen::Vector3d& n = contact.candidate.geometry.normal;
  contact.force = -2.0 * n + 3.0 * n.unitOrthogonal();
  contact.response = EvaluateContactLaw(contact.force, n, 0.3);
  return contact;
}

TEST(PairImpactTest, DerivativeIsThatOfDifferences) {
  const PairFeatures pair = kPairs[2];
  const Eigen::VectorXd x = RandomNodes(8);
  const PairContact contact = SlippingPair(pair, x);
  const PairGeometryGradient gradient = DifferentiatePair(pair, x);
  for (const double share : {0.5, 2.0}) {
    PairImpactNodes nodes;
    nodes.inverse_masses << 1.0, 2.0, 3.0, 0.5;
    const double mass = 1.0 / contact.candidate.geometry.weights.cwiseAbs2().dot(nodes.inverse_masses);
    nodes.velocity_changes.col(0) = share * 2.0 / mass * contact.candidate.geometry.normal;
    nodes.velocity_changes.col(1) << 0.01, 0.02, -0.01;
    const ImpactDerivative<4> derivative = DifferentiateImpact(contact, gradient, nodes);
    // Impulse and normal held as vectors of their own: r does not turn with n.
    const auto evaluate = [&](const Eigen::VectorXd& positions, const PairImpactNodes& at) {
      PairContact moved = contact;
      moved.candidate.geometry = EvaluatePair(pair, positions);
      moved.response.normal_force = -moved.candidate.geometry.normal.dot(contact.response.impulse);
      const PairImpact impact = EvaluatePairImpact(moved, at);
      return Eigen::Matrix<double, 3, 4>(impact.velocity * impact.portions.transpose());
    };
    constexpr double kStep = 1e-6;
    for (int column = 0; column < 12; ++column) {
      Eigen::VectorXd plus = x, minus = x;
      plus[column] += kStep;
      minus[column] -= kStep;
      const Eigen::Matrix<double, 3, 4> difference = (evaluate(plus, nodes) - evaluate(minus, nodes)) / (2.0 * kStep);
      EXPECT_NEAR((difference.reshaped() - derivative.position.col(column)).norm(), 0.0, 1e-6)
          << column << " share " << share;
    }
    for (int j = 0; j < 4; ++j) {
      PairImpactNodes plus = nodes, minus = nodes;
      plus.inverse_masses[j] = 1.0 / (1.0 / nodes.inverse_masses[j] + kStep);
      minus.inverse_masses[j] = 1.0 / (1.0 / nodes.inverse_masses[j] - kStep);
      const Eigen::Matrix<double, 3, 4> difference = (evaluate(x, plus) - evaluate(x, minus)) / (2.0 * kStep);
      EXPECT_NEAR((difference.reshaped() - derivative.masses.col(j)).norm(), 0.0, 1e-6);
    }
  }
}

}  // namespace
}  // namespace clothid::pair_geometry_test

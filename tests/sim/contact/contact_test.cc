// Which nodes may touch what, with which gap, and the derivative of a contact by where it starts.
#include "sim/contact/contact.h"

#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <memory>
#include <random>
#include <vector>

#include "sim/cloth/cloth_model.h"
#include "tests/sim/plain_scenes.h"

namespace clothid::contact_test {
namespace {

constexpr double kTimeStep = 0.01;  // s
constexpr double kRadius = 0.5;     // m

// A cloth above a floor at z = -0.1 m and beside a ball about (0, 0, 1), which is 0.02 m thicker than it looks.
Scene FloorAndBall() {
  Scene scene = ClothScene(SquareGrid(3, 0.2), kTimeStep);
  scene.handles.nodes = {4};
  SceneObstacle floor;
  floor.name = "floor";
  floor.shape = std::make_shared<Plane>(Eigen::Vector3d(0.0, 0.0, -0.1), Eigen::Vector3d::UnitZ());
  SceneObstacle ball;
  ball.name = "ball";
  ball.shape = std::make_shared<Sphere>(Eigen::Vector3d(0.0, 0.0, 1.0), kRadius);
  ball.contact_distance = 0.02;
  scene.obstacles = {floor, ball};
  scene.depenetration_speed = 0.4;
  return scene;
}

class ContactTest : public ::testing::Test {
 protected:
  explicit ContactTest(const Scene& scene = FloorAndBall()) : scene_(scene), model_(scene_) {}

  // The candidate of node 0 at `position`.
  ContactCandidate At(const Eigen::Vector3d& position) const {
    Eigen::VectorXd positions = scene_.initial_positions;
    positions.head<3>() = position;
    ContactCandidate candidate;
    FindCandidate(model_, 0, positions, kTimeStep, {}, &candidate);
    return candidate;
  }

  Scene scene_;
  ClothModel model_;
};

TEST_F(ContactTest, TheObstacleIsTheOneWithTheSmallestGap) {
  const ContactCandidate above_floor = At({0.0, 0.0, 0.1});
  EXPECT_EQ(above_floor.obstacle, 0);
  EXPECT_NEAR(above_floor.gap, 0.2, 1e-15);
  EXPECT_LT((above_floor.normal - Eigen::Vector3d::UnitZ()).norm(), 1e-15);
  EXPECT_EQ(above_floor.normal_gradient.norm(), 0.0);
  const ContactCandidate below_ball = At({0.0, 0.0, 0.4});
  EXPECT_EQ(below_ball.obstacle, 1);
  EXPECT_NEAR(below_ball.gap, 0.1 - 0.02, 1e-15);
  EXPECT_LT((below_ball.normal + Eigen::Vector3d::UnitZ()).norm(), 1e-15);
  EXPECT_NEAR(below_ball.normal_gradient.trace(), 2.0 / 0.6, 1e-13);  // of a sphere through the node
}

TEST_F(ContactTest, TheGapSpeedIsLimitedWhereANodeIsTooDeep) {
  const ContactCandidate above = At({0.0, 0.0, -0.07});
  EXPECT_NEAR(above.gap_speed, 0.03 / kTimeStep, 1e-12);
  EXPECT_EQ(above.gap_speed_slope, 1.0 / kTimeStep);
  const ContactCandidate shallow = At({0.0, 0.0, -0.103});
  EXPECT_NEAR(shallow.gap_speed, -0.003 / kTimeStep, 1e-12);
  EXPECT_EQ(shallow.gap_speed_slope, 1.0 / kTimeStep);
  const ContactCandidate deep = At({0.0, 0.0, -0.105});
  EXPECT_EQ(deep.gap_speed, -0.4);
  EXPECT_EQ(deep.gap_speed_slope, 0.0);
}

TEST_F(ContactTest, EveryFreeNodeIsACandidateInGapMode) {
  std::vector<ContactCandidate> candidates(1);
  FindCandidates(model_, scene_.initial_positions, kTimeStep, {}, &candidates);
  ASSERT_EQ(candidates.size(), 8u);
  for (std::size_t i = 0; i < candidates.size(); ++i)
    EXPECT_EQ(candidates[i].node, static_cast<int>(i < 4 ? i : i + 1));
}

class VelocityContactTest : public ContactTest {
 protected:
  static Scene InVelocityMode() {
    Scene scene = FloorAndBall();
    scene.contact_mode = ContactMode::kVelocity;
    return scene;
  }
  VelocityContactTest() : ContactTest(InVelocityMode()) {}
};

TEST_F(VelocityContactTest, OnlyWhoTouchesIsACandidate) {
  Eigen::VectorXd positions = scene_.initial_positions;
  positions[3 * 7 + 2] = -0.1 + 0.5 * model_.touch_gap();
  positions[3 * 2 + 2] = -0.1 + 1.5 * model_.touch_gap();
  std::vector<ContactCandidate> candidates;
  FindCandidates(model_, positions, kTimeStep, {}, &candidates);
  ASSERT_EQ(candidates.size(), 1u);
  EXPECT_EQ(candidates[0].node, 7);
  EXPECT_EQ(candidates[0].gap_speed, 0.0);
  EXPECT_EQ(candidates[0].gap_speed_slope, 0.0);
}

// X by differences of -r(F) with F = d v - g + d gap_speed n, at fixed v and g: on a curved surface, with the gap speed
// free and limited.
TEST_F(ContactTest, PositionJacobianIsTheDerivativeThroughNormalAndGap) {
  std::mt19937_64 generator(11);
  std::normal_distribution<double> normal;
  const auto random_vector = [&] {
    const double x = normal(generator), y = normal(generator), z = normal(generator);
    return Eigen::Vector3d(x, y, z);
  };
  constexpr double kMu = 0.5, kWeight = 0.3, kStep = 1e-7;
  int num_slip = 0, num_stick = 0;
  for (int i = 0; i < 400; ++i) {
    const double gap = i % 2 == 0 ? 1e-3 * normal(generator) : -0.01;  // -0.01 is too deep
    const Eigen::Vector3d down = (Eigen::Vector3d(0.0, 0.0, -2.0) + random_vector()).normalized();
    const Eigen::Vector3d x = Eigen::Vector3d::UnitZ() + (kRadius + 0.02 + gap) * down;
    if (At(x).obstacle != 1) continue;
    const Eigen::Vector3d push = random_vector(), direction = random_vector();  // push: d v - g
    const auto contact_at = [&](const Eigen::Vector3d& position) {
      const ContactCandidate candidate = At(position);
      const Eigen::Vector3d force = push + kWeight * candidate.gap_speed * candidate.normal;
      return Contact{candidate, EvaluateContactLaw(force, candidate.normal, kMu), force, kWeight, {0.0, 0.0, 0.0}, kMu};
    };
    const Contact contact = contact_at(x), plus = contact_at(x + kStep * direction),
                  minus = contact_at(x - kStep * direction);
    if (plus.response.branch != contact.response.branch || minus.response.branch != contact.response.branch) continue;
    if (contact.response.branch == ContactBranch::kTakeOff) continue;
    ++(contact.response.branch == ContactBranch::kSlip ? num_slip : num_stick);
    const Eigen::Vector3d difference = (minus.response.impulse - plus.response.impulse) / (2.0 * kStep);
    const Eigen::Vector3d derivative = ContactPositionJacobian(contact) * direction;
    EXPECT_LT((difference - derivative).norm(), 2e-6 * (1.0 + derivative.norm())) << i;
  }
  EXPECT_GT(num_slip, 50);
  EXPECT_GT(num_stick, 20);
}

}  // namespace
}  // namespace clothid::contact_test

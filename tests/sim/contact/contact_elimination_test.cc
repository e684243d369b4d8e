// The system without its contacts against the whole one, A = (I + S) K - S D, as a dense matrix.
#include "sim/contact/contact_elimination.h"

#include <gtest/gtest.h>

#include <Eigen/LU>
#include <memory>
#include <numeric>
#include <vector>

#include "sim/contact/contact_law.h"
#include "sim/matrix/dense.h"

namespace clothid::contact_elimination_test {
namespace {

constexpr int kNumBlocks = 6;

// Six nodes with a random symmetric positive definite K: one sticks, two slip with friction, one without, two are free.
class ContactEliminationTest : public ::testing::Test {
 protected:
  ContactEliminationTest()
      : free_index_(kNumBlocks), hessian_(std::make_shared<BlockPattern>(Everyone())), mu_({0.5, 0.0}) {
    std::srand(3);
    std::iota(free_index_.begin(), free_index_.end(), 0);
    const Eigen::MatrixXd random = Eigen::MatrixXd::Random(size(), size());
    dense_ = random * random.transpose() + Eigen::MatrixXd::Identity(size(), size());
    hessian_.values = dense_.reshaped();
    AddContact(0, 0, {0.3, -0.2, -2.0});  // within the cone
    AddContact(2, 0, {2.0, 1.0, -1.0});
    AddContact(3, 0, {-1.0, 2.0, -0.7});
    AddContact(5, 1, {0.4, 0.1, -1.0});  // the second obstacle has no friction
    elimination_.SetContacts(contacts_, free_index_);
    impulse_ = Eigen::MatrixXd::Zero(size(), size());
    Eigen::MatrixXd weights = impulse_;
    for (const Contact& contact : contacts_) {
      const int row = 3 * contact.candidate.node;
      impulse_.block<3, 3>(row, row) =
          ImpulseForceJacobian(contact.response, contact.candidate.normal, mu_[contact.candidate.obstacle]);
      weights.diagonal().segment<3>(row).setConstant(contact.weight);
    }
    with_impulse_ = Eigen::MatrixXd::Identity(size(), size()) + impulse_;
    jacobian_ = with_impulse_ * dense_ - impulse_ * weights;
  }

  static int size() { return 3 * kNumBlocks; }

  static std::vector<std::vector<int>> Everyone() {
    std::vector<int> all(kNumBlocks);
    std::iota(all.begin(), all.end(), 0);
    return std::vector<std::vector<int>>(kNumBlocks, all);
  }

  // `force` in the axes of a tilted surface, the normal last.
  void AddContact(int node, int obstacle, const Eigen::Vector3d& force) {
    ContactCandidate candidate;
    candidate.node = node;
    candidate.obstacle = obstacle;
    const Eigen::Matrix3d tilt = ShortestTurn(Eigen::Vector3d::UnitZ(), {0.3 * node, 0.5, 1.0});
    candidate.normal = tilt * Eigen::Vector3d::UnitZ();
    const Eigen::Vector3d in_world = tilt * force;
    const double mu = mu_[obstacle];
    contacts_.push_back(
        {candidate, EvaluateContactLaw(in_world, candidate.normal, mu), in_world, 0.4, {0.0, 0.0, 0.0}, mu});
  }

  // The matrix of a map of columns in place.
  template <typename Map>
  static Eigen::MatrixXd MatrixOf(const Map& map) {
    Eigen::MatrixXd columns = Eigen::MatrixXd::Identity(size(), size());
    map(&columns);
    return columns;
  }

  Eigen::MatrixXd Projection() const {
    return MatrixOf([this](Eigen::MatrixXd* v) { elimination_.Project(v); });
  }
  Eigen::MatrixXd Friction() const {
    return MatrixOf([this](Eigen::MatrixXd* v) { elimination_.AddFriction(v); });
  }

  // Z^T (I + mu t n^T) K Z + kappa b b^T, with the eliminated unknowns as identities.
  Eigen::MatrixXd ReducedMatrix() const {
    const Eigen::MatrixXd projection = Projection(), identity = Eigen::MatrixXd::Identity(size(), size());
    Eigen::MatrixXd reduced = projection * Friction() * dense_ * projection;
    elimination_.AddSlipStiffness(projection, &reduced);
    return reduced + identity - projection;
  }

  std::vector<int> free_index_;
  BlockMatrix hessian_;
  std::vector<double> mu_;  // of two obstacles
  std::vector<Contact> contacts_;
  ContactElimination elimination_;
  Eigen::MatrixXd dense_, impulse_, with_impulse_, jacobian_;  // K, S, I + S, A
};

TEST_F(ContactEliminationTest, TheContactsAreOfEveryKind) {
  EXPECT_EQ(contacts_[0].response.branch, ContactBranch::kStick);
  for (const int i : {1, 2, 3}) EXPECT_EQ(contacts_[i].response.branch, ContactBranch::kSlip);
  EXPECT_TRUE(elimination_.has_coupling());
  EXPECT_EQ(elimination_.Held().slipping.size(), 3u);
}

TEST_F(ContactEliminationTest, TheFullJacobianIsTheFormula) {
  Eigen::VectorXd values;
  elimination_.FullJacobian(hessian_, &values);
  EXPECT_LT((values - jacobian_.reshaped()).norm(), 1e-14 * jacobian_.norm());
}

TEST_F(ContactEliminationTest, MapsAreTheirFormulas) {
  const Eigen::MatrixXd projection = Projection();
  EXPECT_LT((projection * projection - projection).norm(), 1e-14);
  EXPECT_LT((projection - projection.transpose()).norm(), 1e-15);
  EXPECT_NEAR(projection.trace(), size() - 3 - 3, 1e-14);  // less a sticking node and three normals
  EXPECT_LT((MatrixOf([this](Eigen::MatrixXd* v) { elimination_.AddImpulse(v); }) - with_impulse_).norm(), 1e-14);
  EXPECT_LT((MatrixOf([this](Eigen::MatrixXd* v) { elimination_.AddImpulseTransposed(v); }) - with_impulse_.transpose())
                .norm(),
            1e-14);
  EXPECT_LT(
      (MatrixOf([this](Eigen::MatrixXd* v) { elimination_.AddFrictionTransposed(v); }) - Friction().transpose()).norm(),
      1e-15);
}

TEST_F(ContactEliminationTest, FramesTurnThereAndBack) {
  const std::vector<LocalFrame> frames = elimination_.Held().slipping;
  Eigen::MatrixXd vectors = Eigen::MatrixXd::Random(size(), 2);
  const Eigen::MatrixXd before = vectors;
  ToLocal(frames, &vectors);
  EXPECT_NEAR(vectors.norm(), before.norm(), 1e-14);
  EXPECT_NEAR(vectors(3 * 2, 0), contacts_[1].candidate.normal.dot(before.block<3, 1>(3 * 2, 0)), 1e-15);
  ToWorld(frames, &vectors);
  EXPECT_LT((vectors - before).norm(), 1e-14);
}

// Without its friction coupling: symmetric, and in local frames the same matrix.
TEST_F(ContactEliminationTest, TheReducedMatrixIsTheSymmetricPart) {
  Eigen::VectorXd values;
  elimination_.Reduce(hessian_, &values);
  const Eigen::MatrixXd reduced = values.reshaped(size(), size());
  EXPECT_LT((reduced - reduced.transpose()).norm(), 1e-14 * reduced.norm());
  const Eigen::MatrixXd projection = Projection();
  Eigen::MatrixXd expected = projection * dense_ * projection;
  elimination_.AddSlipStiffness(projection, &expected);
  Eigen::MatrixXd in_world = projection;
  ToLocal(elimination_.Held().slipping, &in_world);
  in_world = (reduced * in_world).eval();
  ToWorld(elimination_.Held().slipping, &in_world);
  elimination_.Project(&in_world);
  EXPECT_LT((in_world - expected).norm(), 1e-13 * expected.norm());
}

TEST_F(ContactEliminationTest, ColumnsOfTheReducedMatrixAreThoseOfTheWhole) {
  const Eigen::MatrixXd projection = Projection(), identity = Eigen::MatrixXd::Identity(size(), size());
  Eigen::MatrixXd expected = projection * dense_ * projection + 0.4 * (identity - projection);
  elimination_.AddSlipStiffness(projection, &expected);
  EXPECT_LT((elimination_.ReducedColumns(hessian_, free_index_) - expected).norm(), 1e-13 * expected.norm());
  const Eigen::MatrixXd some = elimination_.ReducedColumns(hessian_, {2, 5});
  EXPECT_LT((some.leftCols<3>() - expected.middleCols<3>(3 * 2)).norm(), 1e-13 * expected.norm());
  EXPECT_LT((some.rightCols<3>() - expected.middleCols<3>(3 * 5)).norm(), 1e-13 * expected.norm());
}

// Nodes 0 (which stuck), 2, 3 and 5 were held: 0 comes to slip, 2 stays, 3 sticks, and 5 takes off.
TEST_F(ContactEliminationTest, WhatContactsHoldNoMoreIsFreed) {
  const HeldBlocks before = elimination_.Held();
  EXPECT_EQ(before.sticking, std::vector<int>{0});
  EXPECT_EQ(before.slipping.size(), 3u);
  EXPECT_TRUE(elimination_.FreedSince(before, kNumBlocks).empty());
  contacts_.clear();
  AddContact(0, 0, {2.0, 1.0, -1.0});
  AddContact(2, 0, {1.0, 3.0, -1.0});
  AddContact(3, 0, {0.1, 0.1, -1.0});
  elimination_.SetContacts(contacts_, free_index_);
  const std::vector<FreedBlock> freed = elimination_.FreedSince(before, kNumBlocks);
  ASSERT_EQ(freed.size(), 2u);
  EXPECT_EQ(freed[0].block, 0);
  const Eigen::Vector3d n = contacts_[0].candidate.normal, left = before.slipping[2].axes.col(0);
  EXPECT_LT((freed[0].projection - (Eigen::Matrix3d::Identity() - n * n.transpose())).norm(), 1e-14);
  EXPECT_EQ(freed[1].block, 5);
  EXPECT_LT((freed[1].projection - left * left.transpose()).norm(), 1e-14);
}

TEST_F(ContactEliminationTest, TheReducedSystemHasTheSolutionOfTheWhole) {
  const Eigen::MatrixXd right = Eigen::MatrixXd::Random(size(), 2);
  const Eigen::MatrixXd expected = jacobian_.lu().solve(right);
  const Eigen::MatrixXd known = elimination_.KnownPart(right);
  EXPECT_LT((Projection() * known).norm(), 1e-14 * known.norm());
  const Eigen::MatrixXd q = ReducedMatrix().lu().solve(elimination_.ReducedRight(right, known, dense_ * known));
  EXPECT_LT((known + q - expected).norm(), 1e-11 * expected.norm());
}

TEST_F(ContactEliminationTest, TheTransposedSystemHasTheSolutionOfTheWhole) {
  const Eigen::MatrixXd right = Eigen::MatrixXd::Random(size(), 2);
  const Eigen::MatrixXd expected = jacobian_.transpose().lu().solve(right);
  const Eigen::MatrixXd q = ReducedMatrix().transpose().lu().solve(Projection() * right);
  const Eigen::MatrixXd y = Friction().transpose() * q;
  const Eigen::MatrixXd z = elimination_.RecoverAdjoint(right, q, dense_ * y);
  EXPECT_LT((z - expected).norm(), 1e-11 * expected.norm());
  EXPECT_LT((y - with_impulse_.transpose() * expected).norm(), 1e-11 * expected.norm());
}

}  // namespace
}  // namespace clothid::contact_elimination_test

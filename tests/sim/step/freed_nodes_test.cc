// The preconditioner of nodes that contacts have let go, as a dense matrix: symmetric, positive definite, and near the
// inverse where that of the factor alone is not.
#include "sim/step/freed_nodes.h"

#include <gtest/gtest.h>

#include <Eigen/Cholesky>
#include <Eigen/Eigenvalues>
#include <memory>
#include <numeric>
#include <vector>

#include "sim/contact/contact_law.h"

namespace clothid::freed_nodes_test {
namespace {

constexpr int kColumns = 8, kRows = 24;  // of the nodes of a sheet of springs
constexpr int kNumNodes = kColumns * kRows;
constexpr double kFriction = 0.4, kWeight = 0.3;

class FreedNodesTest : public ::testing::Test {
 protected:
  FreedNodesTest() : free_index_(kNumNodes), hessian_(std::make_shared<BlockPattern>(Neighbours())) {
    std::iota(free_index_.begin(), free_index_.end(), 0);
    const BlockPattern& pattern = hessian_.pattern();
    for (int column = 0; column < pattern.num_blocks(); ++column) {
      Eigen::Matrix3d own = 0.05 * Eigen::Matrix3d::Identity();
      for (int k = 0; k < pattern.num_rows(column); ++k) {
        const int row = pattern.rows_begin(column)[k];
        if (row == column) continue;
        const Eigen::Vector3d along = Place(row) - Place(column);
        const Eigen::Matrix3d spring = along * along.transpose() + 0.2 * Eigen::Matrix3d::Identity();
        hessian_.block(pattern.Position(column, k)) = -spring;
        own += spring;
      }
      hessian_.block(pattern.Diagonal(column)) = own;
    }
  }

  static Eigen::Vector3d Place(int node) {
    return {static_cast<double>(node % kColumns), static_cast<double>(node / kColumns), 0.0};
  }

  static std::vector<std::vector<int>> Neighbours() {
    std::vector<std::vector<int>> neighbours(kNumNodes);
    for (int i = 0; i < kNumNodes; ++i) {
      for (int j = 0; j < kNumNodes; ++j) {
        if (i != j && (Place(i) - Place(j)).norm() < 1.1) neighbours[i].push_back(j);
      }
    }
    return neighbours;
  }

  // The lower rows of the sheet slip on a slope up to row `first_sticking`, and stick from there on.
  ContactElimination ContactsWithSticking(int first_sticking) const {
    std::vector<Contact> contacts;
    for (int node = kColumns * (kRows / 2); node < kNumNodes; ++node) {
      ContactCandidate candidate;
      candidate.node = node;
      candidate.normal = Eigen::Vector3d(0.1, 0.2, 1.0).normalized();
      const bool slips = node < kColumns * first_sticking;
      const Eigen::Vector3d across = candidate.normal.unitOrthogonal();
      const Eigen::Vector3d force = -candidate.normal + (slips ? 0.9 : 0.1) * across;
      contacts.push_back({candidate, EvaluateContactLaw(force, candidate.normal, kFriction), force, kWeight,
                          Eigen::Vector3d::Zero(), kFriction});
    }
    ContactElimination elimination;
    elimination.SetContacts(contacts, free_index_);
    return elimination;
  }

  Eigen::MatrixXd Reduced(const ContactElimination& contacts) const {
    return contacts.ReducedColumns(hessian_, free_index_);
  }

  static Eigen::MatrixXd Projection(const ContactElimination& contacts) {
    Eigen::MatrixXd projection = Eigen::MatrixXd::Identity(3 * kNumNodes, 3 * kNumNodes);
    contacts.Project(&projection);
    return projection;
  }

  // On what the contacts leave free: its largest over its smallest eigenvalue as a preconditioner.
  static double Condition(const Eigen::MatrixXd& preconditioner, const Eigen::MatrixXd& matrix,
                          const Eigen::MatrixXd& projection) {
    const Eigen::MatrixXd rest = Eigen::MatrixXd::Identity(matrix.rows(), matrix.cols()) - projection;
    const Eigen::MatrixXd root = Eigen::LLT<Eigen::MatrixXd>(projection * matrix * projection + rest).matrixL();
    const Eigen::MatrixXd product = root.transpose() * (projection * preconditioner * projection + rest) * root;
    const Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd> solver(product, Eigen::EigenvaluesOnly);
    return solver.eigenvalues().maxCoeff() / solver.eigenvalues().minCoeff();
  }

  // As a matrix, with the factor of `before` where the contacts are those of `now`.
  struct Preconditioners {
    Eigen::MatrixXd plain, freed;
  };
  Preconditioners At(const ContactElimination& before, const ContactElimination& now, FreedNodes* nodes) const {
    const Eigen::LLT<Eigen::MatrixXd> factor(Reduced(before));
    const LinearMap apply = [&](const Eigen::MatrixXd& v) {
      Eigen::MatrixXd result = factor.solve(v);
      now.Project(&result);
      return result;
    };
    nodes->Find(hessian_, now, before.Held());
    const Eigen::MatrixXd projection = Projection(now);
    return {apply(projection), nodes->Apply(apply, projection)};
  }

  std::vector<int> free_index_;
  BlockMatrix hessian_;
};

TEST_F(FreedNodesTest, ARowThatComesToSlideCostsNoNewFactor) {
  const ContactElimination before = ContactsWithSticking(15), now = ContactsWithSticking(16);
  FreedNodes nodes;
  const Preconditioners as = At(before, now, &nodes);
  ASSERT_FALSE(nodes.empty());
  EXPECT_LT((as.freed - as.freed.transpose()).norm(), 1e-12 * as.freed.norm());
  const Eigen::MatrixXd matrix = Reduced(now), projection = Projection(now);
  EXPECT_GT(Condition(as.plain, matrix, projection), 10.0);
  EXPECT_LT(Condition(as.freed, matrix, projection), 2.0);
}

TEST_F(FreedNodesTest, NodesThatTakeOffAreFreedToo) {
  const ContactElimination before = ContactsWithSticking(15);
  ContactElimination now = ContactsWithSticking(15);
  FreedNodes nodes;
  nodes.Find(hessian_, now, before.Held());
  EXPECT_TRUE(nodes.empty());
  now.SetContacts({}, free_index_);
  nodes.Find(hessian_, now, before.Held());
  EXPECT_TRUE(nodes.are_too_many());  // all that touched
  EXPECT_TRUE(nodes.empty());
  const Eigen::MatrixXd vectors = Eigen::MatrixXd::Random(3 * kNumNodes, 2);
  EXPECT_EQ(nodes.Apply([](const Eigen::MatrixXd& v) -> Eigen::MatrixXd { return 2.0 * v; }, vectors), 2.0 * vectors);
  nodes.Clear();
  EXPECT_FALSE(nodes.are_too_many());
}

}  // namespace
}  // namespace clothid::freed_nodes_test

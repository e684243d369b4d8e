// Linear systems of steps of a cloth that touches itself: a solution fits the equations, and the transposed solve is
// the transposed one, with contacts of both kinds, with friction, and with pairs that find no slave.
#include <gtest/gtest.h>

#include <string>

#include "sim/rollout/rollout.h"
#include "sim/rollout/simulator.h"
#include "sim/scene/scene_json.h"
#include "sim/step/second_start.h"
#include "sim/step/step_jacobian.h"
#include "sim/step/step_problem.h"

namespace clothid::pair_jacobian_test {
namespace {

class PairJacobianTest : public ::testing::TestWithParam<const char*> {
 protected:
  PairJacobianTest() : simulator_(EulerScene()), hessian_(simulator_.model().pattern()), jacobian_(simulator_.model()) {
    rollout_ = Simulate(simulator_.scene().nominal_parameters(), simulator_.scene().num_steps(), &simulator_);
  }

  static Scene EulerScene() {
    Scene scene = ReadScene(std::string(CLOTHID_SOURCE_DIR) + "/datasets/" + GetParam() + ".scene.json");
    scene.integrator = Integrator::kEuler;
    return scene;
  }

  void SetPoint(std::size_t i) {
    const StepRecord& record = rollout_.records[i];
    const ClothModel& model = simulator_.model();
    const Eigen::VectorXd& start = i == 0 ? rollout_.initial_positions : rollout_.records[i - 1].positions;
    contacts_ = RestoreContacts(record, start, {}, rollout_.parameters, model);
    HeldForces held;
    SetForceStart(model.forces(), {start, record.velocities}, record.time_step, model.scene().handles.nodes,
                  record.positions, &held.start);
    model.forces().Hold(rollout_.parameters, record.time, &held);
    AssembleStepHessian(model, HessianKind::kExact,
                        {rollout_.parameters, record.time_step, record.time, record.positions, record.velocities}, held,
                        &hessian_);
    jacobian_.SetPoint(hessian_, contacts_);
  }

  StepColumns Random() const {
    return {Eigen::MatrixXd::Random(3 * simulator_.model().num_free(), 2),
            Eigen::MatrixXd::Random(3 * static_cast<Eigen::Index>(contacts_.pairs.size()), 2)};
  }

  // (I + S)(K dv - J^T dr) - S D dv and d P J dv + (I - P) dr of every pair.
  StepColumns Times(const StepColumns& x) const {
    StepColumns product{hessian_.view() * x.velocities, x.impulses};
    for (std::size_t c = 0; c < contacts_.pairs.size(); ++c) {
      const PairContact& pair = contacts_.pairs[c];
      const auto rows = Eigen::seqN(3 * static_cast<Eigen::Index>(c), 3);
      Eigen::MatrixXd relative = Eigen::MatrixXd::Zero(3, 2);
      for (int i = 0; i < 4; ++i) {
        if (pair.candidate.blocks[i] < 0) continue;
        const double weight = pair.candidate.geometry.weights[i];
        relative += weight * x.velocities.middleRows<3>(3 * pair.candidate.blocks[i]);
        product.velocities.middleRows<3>(3 * pair.candidate.blocks[i]) -= weight * x.impulses(rows, Eigen::all);
      }
      const Eigen::Matrix3d law =
          -ImpulseForceJacobian(pair.response, pair.candidate.geometry.normal, pair.friction_coefficient);
      product.impulses(rows, Eigen::all) += law * (pair.candidate.weight * relative - x.impulses(rows, Eigen::all));
    }
    for (const Contact& contact : contacts_.nodes) {
      const Eigen::Index row = 3 * simulator_.model().free_index()[contact.candidate.node];
      const Eigen::Matrix3d law =
          ImpulseForceJacobian(contact.response, contact.candidate.normal, contact.friction_coefficient);
      product.velocities.middleRows<3>(row) +=
          (law * (product.velocities.middleRows<3>(row) - contact.weight * x.velocities.middleRows<3>(row))).eval();
    }
    return product;
  }

  Simulator simulator_;
  Rollout rollout_;
  ContactSet contacts_;
  BlockMatrix hessian_;
  StepJacobian jacobian_;
};

double Product(const StepColumns& a, const StepColumns& b) {
  return a.velocities.cwiseProduct(b.velocities).sum() + a.impulses.cwiseProduct(b.impulses).sum();
}

TEST_P(PairJacobianTest, SolvesTheEquationsAndTheirTranspose) {
  ASSERT_TRUE(rollout_.ok()) << rollout_.failure->ToString();
  int num_points = 0;
  for (std::size_t i = rollout_.records.size() / 4; i < rollout_.records.size(); i += 6) {
    SetPoint(i);
    if (contacts_.pairs.empty() || !jacobian_.Factor(StepJacobian::Method::kReduced)) continue;
    const StepColumns right = Random(), other = Random();
    StepColumns x, z;
    Eigen::MatrixXd y;
    if (!jacobian_.Solve(right, 1e-12, &x)) continue;
    ++num_points;
    StepColumns rest = Times(x);
    rest -= right;
    const double size = std::sqrt(Product(right, right));
    EXPECT_LT(std::sqrt(Product(rest, rest)), 1e-7 * size)
        << "step " << i << ", " << contacts_.pairs.size() << " pairs";
    ASSERT_TRUE(jacobian_.SolveTransposed(other, 1e-12, &z, &y));
    const double scale = std::sqrt(Product(x, x) * Product(other, other)) + std::sqrt(Product(z, z)) * size;
    EXPECT_NEAR(Product(other, x), Product(z, right), 1e-8 * scale) << "step " << i;
  }
  EXPECT_GE(num_points, 5);
}

INSTANTIATE_TEST_SUITE_P(Scenes, PairJacobianTest,
                         ::testing::Values("folding/fold", "folding/crumple", "folding/slide", "garment/cuff"),
                         [](const auto& scene) {
                           const std::string name = scene.param;
                           return name.substr(name.find('/') + 1);
                         });

}  // namespace
}  // namespace clothid::pair_jacobian_test

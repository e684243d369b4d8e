// The derivatives of the forces at handles by positions, constants, sizes and fields: central differences.
#include <gtest/gtest.h>

#include <memory>
#include <random>
#include <string>
#include <utility>

#include "sim/rollout/handle_forces.h"
#include "tests/sim/held_rollouts.h"

namespace clothid::handle_force_derivative_test {
namespace {

struct DifferenceCase {
  const char* name;
  MembraneLaw membrane;
  BendingLaw bending;
  bool orthotropic_bending;
  bool has_every_force = false;
  AirLaw air_law = AirLaw::kLinear;
};

void PrintTo(const DifferenceCase& difference_case, std::ostream* out) { *out << difference_case.name; }

class HandleForceDerivativeTest : public testing::TestWithParam<DifferenceCase> {
 protected:
  HandleForceDerivativeTest() {
    scene_ = ShakenCloth(Integrator::kSdirk2, 0.01);
    if (GetParam().has_every_force) scene_ = WithEveryForce(scene_);
    scene_.air_law = GetParam().air_law;
    scene_.membrane = GetParam().membrane;
    scene_.bending.law = GetParam().bending;
    scene_.bending.orthotropic = GetParam().orthotropic_bending;
    Material& material = scene_.material;
    material.added_mass = 0.05;
    if (scene_.membrane == MembraneLaw::kYarn) {
      material.warp_stiffening = 6.0;
      material.weft_stiffening = 3.0;
    }
    if (scene_.membrane != MembraneLaw::kArap) {
      material.warp_stiffness = 80.0;
      material.weft_stiffness = 50.0;
      material.poisson_stiffness = 20.0;
      material.shear_stiffness = 15.0;
    }
    if (scene_.bending.orthotropic) {
      material.bending_stiffness = 0.0;
      material.warp_bending = 2e-4;
      material.weft_bending = 1e-4;
      material.twist_bending = 5e-5;
    }
  }

  // Of the first, a middle and the last step of both integrators, in states that no rollout has.
  template <typename Check>
  void ForEachStep(const Check& check) {
    for (const Integrator integrator : kIntegrators) {
      scene_.integrator = integrator;
      const Simulator simulator(scene_);
      const HandleForces forces(simulator.model(), scene_.nominal_parameters(), scene_.num_steps(), groups_);
      std::mt19937_64 generator(3);
      std::normal_distribution<double> normal;
      HandleForces::States states;
      for (Eigen::MatrixXd& state : states) {
        state = forces.Gather(scene_.initial_positions);
        for (double& coordinate : state.reshaped()) coordinate = 1.02 * coordinate + 0.004 * normal(generator);
      }
      for (const int step : {0, 1, 7, scene_.num_steps()}) {
        SCOPED_TRACE(std::string(IntegratorName(integrator)) + ", step " + std::to_string(step));
        check(simulator.model(), forces, step, states);
      }
    }
  }

  Scene scene_;
  const HandleGroups groups_ = {{0, 1, 2}, {4, 5}};
};

TEST_P(HandleForceDerivativeTest, IsThatOfTheForceByPositions) {
  ForEachStep([](const ClothModel&, const HandleForces& forces, int step, const HandleForces::States& states) {
    const auto jacobian = forces.Jacobian(step, states);
    constexpr double kStep = 1e-6;
    for (std::size_t k = 0; k < 3; ++k) {
      Eigen::MatrixXd differences(jacobian[k].rows(), jacobian[k].cols());
      for (Eigen::Index i = 0; i < differences.cols(); ++i) {
        HandleForces::States up = states, down = states;
        up[k](i) += kStep;
        down[k](i) -= kStep;
        differences.col(i) = (forces.At(step, up) - forces.At(step, down)) / (2.0 * kStep);
      }
      EXPECT_LE((jacobian[k] - differences).norm(), 1e-6 * differences.norm()) << k;
    }
  });
}

TEST_P(HandleForceDerivativeTest, IsThatOfTheForceByParameters) {
  ForEachStep(
      [this](const ClothModel& model, const HandleForces& forces, int step, const HandleForces::States& states) {
        std::vector<ParameterId> ids = {{ParameterKind::kWind, 0}, {ParameterKind::kWind, 2}};
        for (const ParameterKind kind : MaterialKinds()) {
          if (scene_.has_term(kind)) ids.push_back({kind});
        }
        for (const ParameterId& id : ids) {
          const Eigen::VectorXd derivative = forces.ParameterDerivative(id, step, states);
          // R is linear in every constant but a stiffening, and in a wind that drag is linear in.
          const bool is_linear = RowOf(id.kind).need != ParameterNeed::kYarnMembrane &&
                                 (!IsWind(id.kind) || scene_.air_law == AirLaw::kLinear);
          const double value = GetParameter(scene_.nominal_parameters(), id);
          const double change = !is_linear ? 1e-5 : value == 0.0 ? 1.0 : 0.1 * value;
          const auto force_at = [&](double changed) -> Eigen::VectorXd {
            Parameters parameters = scene_.nominal_parameters();
            SetParameter(id, changed, &parameters);
            return HandleForces(model, parameters, scene_.num_steps(), groups_).At(step, states);
          };
          const Eigen::VectorXd difference = (force_at(value + change) - force_at(value - change)) / (2.0 * change);
          EXPECT_GT(derivative.norm(), 0.0) << ParameterName(id, {});
          EXPECT_LE((derivative - difference).norm(), 1e-6 * difference.norm()) << ParameterName(id, {});
        }
      });
}

TEST_P(HandleForceDerivativeTest, IsThatOfTheForceBySizes) {
  const std::vector<ParameterId> sizes = ParametersOf(ParameterTerm::kSize);
  Simulator simulator(scene_);
  Parameters parameters = scene_.nominal_parameters();
  parameters.size = {1.02, 0.97};
  const auto forces_at = [&](const Parameters& of) {
    simulator.UseParameters(of);
    return HandleForces(simulator.model(), of, scene_.num_steps(), groups_, sizes);
  };
  constexpr int kStep = 7;
  HandleForces::States states;
  {
    const HandleForces forces = forces_at(parameters);
    std::mt19937_64 generator(3);
    std::normal_distribution<double> normal;
    for (Eigen::MatrixXd& state : states) {
      state = forces.Gather(scene_.initial_positions);
      for (double& coordinate : state.reshaped()) coordinate = 1.02 * coordinate + 0.004 * normal(generator);
    }
  }
  for (const ParameterId& id : sizes) {
    const Eigen::VectorXd derivative = forces_at(parameters).ParameterDerivative(id, kStep, states);
    Parameters more = parameters, less = parameters;
    constexpr double kChange = 1e-5;
    SetParameter(id, GetParameter(parameters, id) + kChange, &more);
    SetParameter(id, GetParameter(parameters, id) - kChange, &less);
    const Eigen::VectorXd high = forces_at(more).At(kStep, states), low = forces_at(less).At(kStep, states);
    const Eigen::VectorXd difference = (high - low) / (2.0 * kChange);
    EXPECT_GT(derivative.norm(), 0.0) << ParameterName(id, {});
    EXPECT_LE((derivative - difference).norm(), 1e-6 * difference.norm()) << ParameterName(id, {});
  }
}

INSTANTIATE_TEST_SUITE_P(
    All, HandleForceDerivativeTest,
    testing::Values(DifferenceCase{"Arap", MembraneLaw::kArap, BendingLaw::kPatches, false},
                    DifferenceCase{"ArapEdges", MembraneLaw::kArap, BendingLaw::kEdges, false},
                    DifferenceCase{"Orthotropic", MembraneLaw::kOrthotropic, BendingLaw::kPatches, true},
                    DifferenceCase{"EveryForce", MembraneLaw::kArap, BendingLaw::kPatches, false, true},
                    DifferenceCase{"EveryForceOrthotropicQuadratic", MembraneLaw::kOrthotropic, BendingLaw::kPatches,
                                   true, true, AirLaw::kQuadratic},
                    DifferenceCase{"EveryForceYarn", MembraneLaw::kYarn, BendingLaw::kPatches, true, true}),
    [](const auto& named) { return named.param.name; });

// Fields of one value everywhere are that value.
TEST(HandleForceFieldTest, TakesConstantsThatVaryFromTheFields) {
  Scene scene = ShakenCloth(Integrator::kSdirk2, 0.01);
  const HeldRollout expected(scene, {FirstRow(6)});
  const std::pair<ParameterKind, double Material::*> kinds[] = {
      {ParameterKind::kStretchStiffness, &Material::stretch_stiffness},
      {ParameterKind::kDensity, &Material::density},
      {ParameterKind::kBendingStiffness, &Material::bending_stiffness}};
  for (const auto& [kind, constant] : kinds) {
    GridField field;
    field.kind = kind;
    field.values = Eigen::MatrixXd::Constant(2, 2, scene.material.*constant);
    scene.fields.push_back(field);
  }
  const Parameters levels = scene.nominal_parameters();
  for (const double factor : {1.0, 2.0}) {
    Parameters parameters = levels;
    auto fields = std::make_shared<std::vector<FieldFactors>>(*levels.fields);
    for (FieldFactors& field : *fields) field.log_factors.array() += std::log(factor);
    parameters.fields = fields;
    Simulator simulator(scene);
    simulator.UseParameters(parameters);
    const HandleForces forces(simulator.model(), parameters, scene.num_steps(), {FirstRow(6)});
    Parameters scaled = scene.nominal_parameters();
    scaled.fields = nullptr;
    for (const auto& [kind, constant] : kinds) scaled.material.*constant *= factor;
    Scene plain = scene;
    plain.fields.clear();
    const Simulator plain_simulator(plain);
    const HandleForces same(plain_simulator.model(), scaled, scene.num_steps(), {FirstRow(6)});
    HandleForces::States states, same_states;  // nodes that a zero couples are listed by one of them alone
    for (std::size_t k = 0; k < 3; ++k) {
      const Eigen::VectorXd& positions = expected.rollout.positions(7 + static_cast<int>(k));
      states[k] = forces.Gather(positions);
      same_states[k] = same.Gather(positions);
    }
    const Eigen::VectorXd force = forces.At(8, states);
    EXPECT_LE((force - same.At(8, same_states)).norm(), 1e-9 * force.norm()) << factor;
    const Eigen::VectorXd change = Eigen::VectorXd::LinSpaced(scene.initial_positions.size(), -1.0, 2.0).array().sin();
    const Eigen::VectorXd moved = forces.Jacobian(8, states)[1] * forces.Gather(change);
    const Eigen::VectorXd same_moved = same.Jacobian(8, same_states)[1] * same.Gather(change);
    EXPECT_LE((moved - same_moved).norm(), 1e-9 * moved.norm()) << factor;
  }
}

// By the logarithm of the value of a triangle, of every constant that can be a field.
TEST(HandleForceFieldTest, FieldDerivativesAreThoseOfDifferences) {
  for (const Integrator integrator : kIntegrators) {
    SCOPED_TRACE(IntegratorName(integrator));
    Scene scene = ShakenCloth(integrator, 0.01);
    for (const ParameterKind kind :
         {ParameterKind::kStretchStiffness, ParameterKind::kDensity, ParameterKind::kBendingStiffness}) {
      const double level = GetParameter(scene.nominal_parameters(), {kind});
      scene.fields.push_back({kind, level * Eigen::Matrix2d{{1.0, 1.3}, {0.8, 1.1}}});
    }
    const HeldRollout run(scene, {{0, 1, 2}, {4, 5}});
    HandleForces::States states;
    for (std::size_t k = 0; k < 3; ++k) states[k] = run.forces.Gather(run.rollout.positions(7 + static_cast<int>(k)));
    const int step = integrator == Integrator::kEuler ? 9 : 8;
    const Eigen::MatrixXd derivative = run.forces.FieldDerivative(step, states);
    const Eigen::Index num_faces = scene.mesh.num_faces();
    ASSERT_EQ(derivative.cols(), 3 * num_faces);
    for (int k = 0; k < 3; ++k) {
      const Eigen::VectorXd change = Eigen::VectorXd::LinSpaced(num_faces, -2.0, 3.0).array().cos();
      const auto force_at = [&](double share) -> Eigen::VectorXd {
        auto fields = std::make_shared<std::vector<FieldFactors>>(*run.rollout.parameters.fields);
        (*fields)[static_cast<std::size_t>(k)].log_factors += share * change;
        Parameters parameters = run.rollout.parameters;
        parameters.fields = fields;
        Simulator simulator(scene);
        simulator.UseParameters(parameters);
        return HandleForces(simulator.model(), parameters, scene.num_steps(), {{0, 1, 2}, {4, 5}}).At(step, states);
      };
      constexpr double kStep = 1e-4;
      const Eigen::VectorXd difference = (force_at(kStep) - force_at(-kStep)) / (2.0 * kStep);
      const Eigen::VectorXd along = derivative.middleCols(k * num_faces, num_faces) * change;
      EXPECT_GT(along.norm(), 0.0) << k;
      EXPECT_LE((along - difference).norm(), 1e-6 * difference.norm()) << k;
    }
  }
}

}  // namespace
}  // namespace clothid::handle_force_derivative_test

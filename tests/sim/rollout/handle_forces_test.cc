// The forces at handles: closed forms, balances of momentum and energy over rollouts, central differences.
#include "sim/rollout/handle_forces.h"

#include <gtest/gtest.h>

#include <cmath>
#include <random>
#include <utility>

#include "sim/base/error.h"
#include "sim/rollout/energy_loss.h"
#include "sim/rollout/pair_forces.h"
#include "tests/sim/plain_scenes.h"
#include "tests/sim/self_contact_scenes.h"

namespace clothid::handle_forces_test {
namespace {

constexpr Integrator kIntegrators[] = {Integrator::kEuler, Integrator::kSdirk2};
using Groups = std::vector<std::vector<int>>;

// A rollout with the forces of groups of its handles.
struct TestRun {
  Scene scene;
  Simulator simulator;
  Rollout rollout;
  HandleForces forces;
  Eigen::MatrixXd values;  // [3G x steps + 1]

  TestRun(const Scene& given, const Groups& groups)
      : scene(given),
        simulator(scene),
        rollout(Simulate(scene.nominal_parameters(), scene.num_steps(), &simulator)),
        forces(simulator.model(), rollout.parameters, scene.num_steps(), groups) {
    EXPECT_TRUE(rollout.ok()) << rollout.failure->ToString();
    Eigen::MatrixXd states(3 * static_cast<Eigen::Index>(forces.nodes().size()), scene.num_steps() + 1);
    for (int step = 0; step <= scene.num_steps(); ++step) states.col(step) = forces.Gather(rollout.positions(step));
    values = forces.Over(states);
  }

  double total_mass() const {
    return rollout.parameters.material.density * simulator.model().nodes().mass_areas().sum();
  }
  Eigen::VectorXd AccelerationAt(int step) const {
    const double h = scene.time_step;
    return (rollout.positions(step + 1) - 2.0 * rollout.positions(step) + rollout.positions(step - 1)) / (h * h);
  }
};

std::vector<int> FirstRow(int count) {
  std::vector<int> nodes;
  for (int i = 0; i < count; ++i) nodes.push_back(i);
  return nodes;
}

// The handles move from where they are by `shift`(t), given at so many knots.
template <typename Shift>
void MoveHandles(int num_knots, const Shift& shift, Scene* scene) {
  const std::vector<int>& nodes = scene->handles.nodes;
  const Eigen::VectorXd times = Eigen::VectorXd::LinSpaced(num_knots, 0.0, scene->duration);
  Eigen::MatrixXd path(3 * static_cast<Eigen::Index>(nodes.size()), num_knots);
  for (int k = 0; k < num_knots; ++k) {
    for (std::size_t i = 0; i < nodes.size(); ++i) {
      path.col(k).segment<3>(3 * static_cast<Eigen::Index>(i)) =
          scene->initial_positions.segment<3>(3 * nodes[i]) + shift(times[k]);
    }
  }
  scene->handles.path = HandlePath(times, path);
}

// Every term at once, its first row shaken.
Scene ShakenCloth(Integrator integrator, double time_step) {
  Scene scene = ClothScene(SquareGrid(6, 0.3), time_step);
  scene.integrator = integrator;
  scene.duration = 0.24;
  scene.handles.nodes = FirstRow(6);
  scene.material.bending_stiffness = 1e-4;
  scene.material.damping = 0.05;
  scene.material.drag = 0.1;
  scene.wind.mean = Eigen::Vector3d(0.3, 0.1, 0.2);
  scene.node_force = Eigen::Vector3d(1e-4, 0.0, 2e-4);
  MoveHandles(
      25, [](double t) { return Eigen::Vector3d(0.0, 0.02 * std::sin(15.0 * t), 0.03 * t * t); }, &scene);
  return scene;
}

// Drag by direction, pressure, a rest shape that is curved, and links at and beside the handles, one of which closes.
Scene WithEveryForce(Scene scene) {
  scene.material.normal_drag = 0.4;
  scene.material.tangential_drag = 0.15;
  scene.material.pressure = 1.5;
  scene.mesh.links = {{2, {14, 14}, 0.0, 3.0, 0.0}, {9, {3, 4}, 0.4, 5.0, 0.2}, {20, {27, 28}, 0.5, 4.0, 0.1}};
  for (int node = 0; node < scene.mesh.num_nodes(); ++node) {
    const double along = scene.mesh.rest_positions(0, node);
    scene.mesh.rest_positions(2, node) += 0.5 * along * along;
  }
  scene.initial_positions = scene.mesh.rest_positions.reshaped();
  return scene;
}

// A plate that moves along its normal through air at rest.
TEST(HandleForcesTest, IsTheDragOfAPlate) {
  for (const AirLaw law : {AirLaw::kLinear, AirLaw::kQuadratic}) {
    for (const Integrator integrator : kIntegrators) {
      Scene scene = ClothScene(SquareGrid(4, 0.1), 0.01);
      scene.integrator = integrator;
      scene.gravity.setZero();
      scene.duration = 0.1;
      scene.air_law = law;
      scene.material.normal_drag = 0.7;
      scene.material.tangential_drag = 0.2;
      scene.material.pressure = 5.0;
      scene.handles.nodes = FirstRow(8);
      const Simulator simulator(scene);
      const HandleForces forces(simulator.model(), scene.nominal_parameters(), 10, {scene.handles.nodes});
      constexpr double kSpeed = 3.0;
      HandleForces::States states;
      for (std::size_t k = 0; k < 3; ++k) {
        Eigen::VectorXd positions = scene.initial_positions;
        for (int node = 0; node < 16; ++node) positions[3 * node + 2] += kSpeed * 0.01 * static_cast<double>(k);
        states[k] = forces.Gather(positions);
      }
      const double area = simulator.model().node_areas().head(8).sum();
      const double drag = 0.7 * (law == AirLaw::kQuadratic ? kSpeed * kSpeed : kSpeed);
      const Eigen::Vector3d expected(0.0, 0.0, area * (drag - 5.0));
      EXPECT_LT((forces.At(5, states) - expected).norm(), 1e-11 * expected.norm());
    }
  }
}

// At rest in air that stands still it is what the energy grows by where the handles move.
TEST(HandleForcesTest, IsTheSlopeOfTheEnergyOfEveryForce) {
  Scene scene = WithEveryForce(ShakenCloth(Integrator::kSdirk2, 0.01));
  scene.gravity.setZero();
  scene.node_force.setZero();
  scene.wind = Wind();
  scene.material.pressure = 0.0;  // has no energy
  const Simulator simulator(scene);
  const Groups groups = {{0, 1, 2}, {4, 5}};
  const HandleForces forces(simulator.model(), scene.nominal_parameters(), scene.num_steps(), groups);
  std::mt19937_64 generator(5);
  std::normal_distribution<double> normal;
  Eigen::VectorXd positions = 1.03 * scene.initial_positions;
  for (double& coordinate : positions) coordinate += 0.004 * normal(generator);
  constexpr int kStep = 7;
  const Eigen::MatrixXd near = forces.Gather(positions);
  const Eigen::VectorXd force = forces.At(kStep, {near, near, near});
  const Eigen::VectorXd still = Eigen::VectorXd::Zero(positions.size());
  for (Eigen::Index row = 0; row < force.size(); ++row) {
    const auto energy_at = [&](double shift) {
      Eigen::VectorXd moved = positions;
      for (const int node : groups[static_cast<std::size_t>(row / 3)]) moved[3 * node + row % 3] += shift;
      return StateEnergy(scene.nominal_parameters(), moved, still, simulator, kStep * scene.time_step).elastic();
    };
    const double difference = (energy_at(1e-5) - energy_at(-1e-5)) / 2e-5;
    EXPECT_NEAR(force[row], difference, 1e-7 * force.norm()) << row;
  }
}

TEST(HandleForcesTest, IsTheWeightOfAClothThatHangsAtRest) {
  for (const Integrator integrator : kIntegrators) {
    SCOPED_TRACE(IntegratorName(integrator));
    GridOptions grid = SquareGrid(5, 0.2);
    grid.axes = {Eigen::Vector3d::UnitX(), -Eigen::Vector3d::UnitZ()};
    Scene scene = ClothScene(grid, 0.02);
    scene.integrator = integrator;
    scene.duration = 6.0;
    scene.handles.nodes = FirstRow(5);
    scene.material.drag = 1.0;
    scene.material.damping = 0.5;
    const TestRun run(scene, {FirstRow(5)});
    const Eigen::Vector3d force = run.values.rightCols(1);
    EXPECT_LE((force - Eigen::Vector3d(0.0, 0.0, 9.81 * run.total_mass())).norm(), 1e-5 * 9.81 * run.total_mass());
  }
}

// k/2 |F - R|^2 of a strip whose ends stand e apart, and whose sides are held to the rest width: k e per width.
TEST(HandleForcesTest, IsTheStressOfAStretchedStrip) {
  GridOptions grid;
  grid.nodes = {5, 3};
  grid.size = {0.2, 0.05};
  Scene scene = ClothScene(grid, 0.01);
  scene.gravity.setZero();
  scene.duration = 0.02;
  constexpr double kStrain = 0.04;
  for (int node = 0; node < scene.mesh.num_nodes(); ++node) scene.handles.nodes.push_back(node);
  for (int node = 0; node < scene.mesh.num_nodes(); ++node) scene.initial_positions[3 * node] *= 1.0 + kStrain;
  scene.handles.nodes.pop_back();  // a cloth must have a node that moves, here one where forces cancel but along x
  const std::vector<int> left = {0, 5, 10};
  const TestRun run(scene, {left});
  const double expected = -scene.material.stretch_stiffness * kStrain * 0.05;
  EXPECT_NEAR(run.values(0, 0), expected, 1e-9 * std::abs(expected));
  EXPECT_LE(std::abs(run.values(1, 0)) + std::abs(run.values(2, 0)), 1e-12);
}

// Of yarns that stiffen k (exp(b e) - 1)/b per width.
TEST(HandleForcesTest, IsTheCurveOfAStripOfYarns) {
  GridOptions grid;
  grid.nodes = {5, 3};
  grid.size = {0.2, 0.05};
  Scene scene = ClothScene(grid, 0.01);
  scene.gravity.setZero();
  scene.duration = 0.02;
  scene.membrane = MembraneLaw::kYarn;
  Material& material = scene.material;
  material.stretch_stiffness = 0.0;
  material.warp_stiffness = material.weft_stiffness = 80.0;
  material.shear_stiffness = 15.0;
  material.warp_stiffening = 20.0;
  scene.handles.nodes = FirstRow(14);
  for (const double strain : {0.02, 0.1, 0.3}) {
    Scene strained = scene;
    for (int node = 0; node < 15; ++node) strained.initial_positions[3 * node] *= 1.0 + strain;
    const TestRun run(strained, {{0, 5, 10}});
    const double expected = -80.0 * std::expm1(20.0 * strain) / 20.0 * 0.05;
    EXPECT_NEAR(run.values(0, 0), expected, 1e-9 * std::abs(expected)) << strain;
  }
}

// Lifted as a whole: weight and inertia of all of it, in each group of its own nodes.
TEST(HandleForcesTest, LiftsAClothHeldEverywhere) {
  Scene scene = ClothScene(SquareGrid(3, 0.1), 0.01);
  scene.duration = 0.2;
  scene.handles.nodes = {0, 1, 2, 3, 4, 5, 6, 7};
  const Eigen::Vector3d acceleration(0.5, 0.0, 2.0);
  MoveHandles(
      21, [&](double t) -> Eigen::Vector3d { return 0.5 * t * t * acceleration; }, &scene);
  const TestRun run(scene, {{0, 1, 2}, {3}});
  const double mass = scene.material.density * run.simulator.model().nodes().mass_areas()[3];
  const Eigen::Vector3d force = run.values.col(1).tail<3>();
  // In the first steps node 8 has not moved yet.
  EXPECT_LE((force - mass * (acceleration - scene.gravity)).norm(), 1e-3 * mass * 9.81);
}

// Momentum: what all handles take is what all nodes gain less what acts on them from outside.
double MomentumDefect(const TestRun& run, int step) {
  const Scene& scene = run.scene;
  const ClothModel& model = run.simulator.model();
  const bool is_euler = scene.integrator == Integrator::kEuler;
  const Eigen::VectorXd acceleration = run.AccelerationAt(is_euler ? step - 1 : step);
  const Eigen::VectorXd ends = run.rollout.positions(is_euler ? step : step + 1);
  const Eigen::VectorXd velocity =
      (ends - run.rollout.positions(step - 1)) / ((is_euler ? 1.0 : 2.0) * scene.time_step);
  Eigen::Vector3d sum = Eigen::Vector3d::Zero();
  for (int node = 0; node < model.num_nodes(); ++node) {
    const double mass = scene.material.density * model.nodes().mass_areas()[node];
    sum += mass * (acceleration.segment<3>(3 * node) - scene.gravity) - scene.node_force;
    sum -= scene.material.drag * model.nodes().drag()->areas()[node] *
           (model.nodes().drag()->WindAt(node, step * scene.time_step, scene.wind) - velocity.segment<3>(3 * node));
  }
  if (model.forces().has(ForceGroup::kAir)) {  // of a step of backward Euler
    HeldForces held;
    held.start.origins = {{&run.rollout.positions(step - 1), 1.0}};
    held.start.predicted = 2.0 * run.rollout.positions(step - 1) - run.rollout.positions(step - 2);
    for (const int node : scene.handles.nodes) held.start.predicted.segment<3>(3 * node) = ends.segment<3>(3 * node);
    model.forces().Hold(run.rollout.parameters, step * scene.time_step, &held);
    Eigen::VectorXd force = Eigen::VectorXd::Zero(ends.size());
    model.forces().AddForce(ForceGroup::kAir,
                            {run.rollout.parameters, scene.time_step, step * scene.time_step, ends, velocity}, held,
                            &force);
    sum -= force.reshaped(3, model.num_nodes()).rowwise().sum();
  }
  return (run.values.col(step) - sum).norm() / run.values.col(step).norm();
}

TEST(HandleForcesTest, ClosesTheBalanceOfMomentumOfBackwardEuler) {
  const TestRun run(ShakenCloth(Integrator::kEuler, 0.01), {FirstRow(6)});
  for (int step = 2; step <= run.scene.num_steps(); ++step) EXPECT_LE(MomentumDefect(run, step), 1e-8) << step;
}

// Forces in the cloth add up to nothing, those of the air do not.
TEST(HandleForcesTest, ClosesTheBalanceOfMomentumWithEveryForce) {
  for (const AirLaw law : {AirLaw::kLinear, AirLaw::kQuadratic}) {
    Scene scene = WithEveryForce(ShakenCloth(Integrator::kEuler, 0.01));
    scene.air_law = law;
    const TestRun run(scene, {FirstRow(6)});
    for (int step = 2; step <= scene.num_steps(); ++step) EXPECT_LE(MomentumDefect(run, step), 1e-8) << step;
  }
}

TEST(HandleForcesTest, ClosesTheBalanceOfMomentumOfSdirk2InSecondOrder) {
  const auto largest = [](double time_step) {
    Scene scene = ShakenCloth(Integrator::kSdirk2, time_step);
    scene.material.stretch_stiffness = 5.0;  // so slow that the steps resolve all of its modes
    MoveHandles(
        3, [](double t) -> Eigen::Vector3d { return Eigen::Vector3d(0.0, 0.4, 0.3) * t * t; }, &scene);
    const TestRun run(scene, {FirstRow(6)});
    double defect = 0.0;
    for (int step = 2 * run.scene.num_steps() / 3; step < run.scene.num_steps(); ++step) {
      defect = std::max(defect, MomentumDefect(run, step));
    }
    return defect;
  };
  const double coarse = largest(0.0025), fine = largest(0.00125);
  EXPECT_LE(coarse, 0.02);
  EXPECT_GE(coarse / fine, 3.0);
}

// A layer slides on another, all of which is held: what its contacts push the handles with is in the balance.
TEST(HandleForcesTest, CarriesALayerThatSlides) {
  Scene scene = LayersOnASlope(2, 0.44, 0.3, Integrator::kEuler, 0.005);
  scene.material.bending_stiffness = 0.0;  // at rest it is not flat
  scene.duration = 0.1;
  const TestRun run(scene, {scene.handles.nodes});
  for (int step = 2; step <= scene.num_steps(); ++step) {
    const StepRecord& end = run.rollout.records[run.rollout.last_record[step - 1]];
    ASSERT_FALSE(end.contacts.pairs.empty());
    const Eigen::Vector3d pushed =
        run.forces.OverGroups(PairForces(run.simulator.model(), run.rollout.parameters, end));
    const Eigen::VectorXd acceleration = run.AccelerationAt(step - 1);
    Eigen::Vector3d sum = Eigen::Vector3d::Zero();
    for (int node = 0; node < scene.mesh.num_nodes(); ++node) {
      const double mass = scene.material.density * run.simulator.model().nodes().mass_areas()[node];
      sum += mass * (acceleration.segment<3>(3 * node) - scene.gravity);
    }
    EXPECT_LE((run.values.col(step) - pushed - sum).norm(), 1e-8 * sum.norm()) << step;
    EXPECT_GE(pushed.norm(), 0.1 * sum.norm());
  }
}

TEST(HandleForcesTest, SumsGroups) {
  const Scene scene = ShakenCloth(Integrator::kSdirk2, 0.01);
  const TestRun all(scene, {FirstRow(6)}), parts(scene, {{0, 1, 5}, {2, 4, 3}});
  EXPECT_LE((parts.values.topRows(3) + parts.values.bottomRows(3) - all.values).norm(), 1e-10 * all.values.norm());
}

// Energy: pulled slowly, the work at the handles is the energy that the cloth stores.
TEST(HandleForcesTest, DoesTheWorkThatAStretchedClothStores) {
  for (const Integrator integrator : kIntegrators) {
    SCOPED_TRACE(IntegratorName(integrator));
    GridOptions grid;
    grid.nodes = {6, 4};
    grid.size = {0.2, 0.1};
    Scene scene = ClothScene(grid, 0.02);
    scene.integrator = integrator;
    scene.gravity.setZero();
    scene.duration = 8.0;
    scene.material.drag = 0.5;
    scene.membrane = MembraneLaw::kOrthotropic;
    scene.material.warp_stiffness = 80.0;
    scene.material.weft_stiffness = 50.0;
    scene.material.poisson_stiffness = 20.0;
    scene.material.shear_stiffness = 15.0;
    scene.handles.nodes = {0, 6, 12, 18, 5, 11, 17, 23};
    const Eigen::VectorXd times = Eigen::VectorXd::LinSpaced(41, 0.0, scene.duration);
    Eigen::MatrixXd path(24, times.size());
    for (Eigen::Index k = 0; k < times.size(); ++k) {
      const double s = times[k] / scene.duration;
      for (int i = 0; i < 8; ++i) {
        path.col(k).segment<3>(3 * i) = scene.initial_positions.segment<3>(3 * scene.handles.nodes[i]);
        if (i >= 4) path(3 * i, k) += 0.02 * s * s * (3.0 - 2.0 * s);
      }
    }
    scene.handles.path = HandlePath(times, path);
    const TestRun run(scene, {{0, 6, 12, 18}, {5, 11, 17, 23}});
    double work = 0.0;
    for (int step = 1; step <= scene.num_steps(); ++step) {
      const double moved = run.rollout.positions(step)[3 * 5] - run.rollout.positions(step - 1)[3 * 5];
      work += 0.5 * (run.values(3, step) + run.values(3, step - 1)) * moved;
    }
    const Eigen::VectorXd end = run.rollout.positions(scene.num_steps());
    const double stored =
        StateEnergy(run.rollout.parameters, end, Eigen::VectorXd::Zero(end.size()), run.simulator, 0.0).elastic();
    EXPECT_NEAR(work, stored, 2e-3 * stored);
    EXPECT_NEAR(run.values(0, scene.num_steps()), -run.values(3, scene.num_steps()), 1e-3 * run.values(3, 200));
  }
}

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
  const Groups groups_ = {{0, 1, 2}, {4, 5}};
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
TEST(HandleForcesTest, TakesConstantsThatVaryFromTheFields) {
  Scene scene = ShakenCloth(Integrator::kSdirk2, 0.01);
  const TestRun expected(scene, {FirstRow(6)});
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
TEST(HandleForcesTest, FieldDerivativesAreThoseOfDifferences) {
  for (const Integrator integrator : kIntegrators) {
    SCOPED_TRACE(IntegratorName(integrator));
    Scene scene = ShakenCloth(integrator, 0.01);
    for (const ParameterKind kind :
         {ParameterKind::kStretchStiffness, ParameterKind::kDensity, ParameterKind::kBendingStiffness}) {
      const double level = GetParameter(scene.nominal_parameters(), {kind});
      scene.fields.push_back({kind, level * Eigen::Matrix2d{{1.0, 1.3}, {0.8, 1.1}}});
    }
    const TestRun run(scene, {{0, 1, 2}, {4, 5}});
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

TEST(HandleForcesTest, RejectsGroupsThatAreNoHandles) {
  const Scene scene = ShakenCloth(Integrator::kEuler, 0.01);
  const Simulator simulator(scene);
  const auto make = [&](const Groups& groups) {
    HandleForces(simulator.model(), scene.nominal_parameters(), 10, groups);
  };
  EXPECT_THROW(make({{}}), Error);
  EXPECT_THROW(make({{0, 6}}), Error);
  EXPECT_THROW(make({{-1}}), Error);
}

}  // namespace
}  // namespace clothid::handle_forces_test

// What is in doubt about a set-up is found again: the size of the cloth at rest, beside its stiffnesses, and where the
// handles were.
#include <gtest/gtest.h>

#include <cmath>
#include <iterator>
#include <map>
#include <string>
#include <vector>

#include "identify/fit/fit.h"
#include "tests/costs/synthetic_motion.h"

namespace clothid::set_up_fit_test {
namespace {

// Priors so wide that they do not count.
FitOptions OptionsOf(const std::map<std::string, double>& truth) {
  FitOptions options;
  for (const auto& [name, value] : truth) options.parameters.push_back(name);
  options.overrides.priors = {{"handle_shift", {0.0, 100.0}},  {"handle_shift1", {0.0, 100.0}},
                              {"handle_shift2", {0.0, 100.0}}, {"handle_turn", {0.0, 1000.0}},
                              {"size.x", {1.0, 1e9}},          {"size.y", {1.0, 1e9}}};
  for (auto it = options.overrides.priors.begin(); it != options.overrides.priors.end();) {
    const bool is_fitted = truth.count(it->first) > 0 || truth.count(it->first + ".x") > 0;
    it = is_fitted ? std::next(it) : options.overrides.priors.erase(it);
  }
  options.max_iterations = 100;
  return options;
}

void ExpectFound(const RecordedMotion& motion, const std::map<std::string, double>& truth) {
  const FitOptions options = OptionsOf(truth);
  FitProblem problem({motion}, options);
  const FitSummary summary = Fit(options, &problem);
  EXPECT_EQ(summary.status, FitStatus::kConverged) << summary.message;
  ASSERT_EQ(summary.parameters.size(), truth.size());
  for (const FittedParameter& parameter : summary.parameters) {
    const double value = truth.at(parameter.name);
    EXPECT_NEAR(parameter.value, value, 1e-4 * std::abs(value)) << parameter.name;
  }
  ASSERT_TRUE(summary.uncertainty.has_value());
  for (const ParameterUncertainty& parameter : summary.uncertainty->parameters) EXPECT_TRUE(parameter.identifiable);
}

TEST(SetUpFitTest, FindsTheSizeOfTheClothBesideItsStiffness) {
  const std::map<std::string, double> truth = {
      {"size.x", 0.96}, {"size.y", 1.05}, {"k_stretch", 70.0}, {"k_bend", 3e-3}};
  ExpectFound(MakeMotion(SwingScene(), {truth, 0.0, 0.0, 0.0}), truth);
}

// The same motion, told by handles that are elsewhere.
TEST(SetUpFitTest, FindsWhereTheHandlesWere) {
  Scene scene = SwingScene();
  Eigen::MatrixXd places(6, 3);
  places.topRows(3).setZero();
  places.bottomRows(3) = scene.initial_positions.segment<3>(12).replicate(1, 3);
  places.row(1) << 0.0, 0.02, 0.01;
  places.row(5) << 0.0, 0.03, 0.02;
  const Eigen::Vector3d times(0.0, 0.1, 0.2), arm = 0.5 * scene.initial_positions.segment<3>(12);
  scene.handles.path = HandlePath(times, places);
  RecordedMotion motion = MakeMotion(scene, {{{"k_stretch", 70.0}}, 0.0, 0.0, 0.0});
  motion.scene.handles.path =
      HandlePath(times, places.colwise() - (Eigen::VectorXd(6) << 0.004, 0.0, 0.006, 0.001, -0.003, 0.0).finished());
  ExpectFound(motion, {{"handle_shift1.x", 0.004},
                       {"handle_shift1.z", 0.006},
                       {"handle_shift2.x", 0.001},
                       {"handle_shift2.y", -0.003},
                       {"k_stretch", 70.0}});
  // By a turn of 0.05 rad about z, on handles at rest.
  scene.handles.path = HandlePath(Eigen::VectorXd::Zero(1), places.col(0));
  motion = MakeMotion(scene, {{{"k_stretch", 70.0}}, 0.0, 0.0, 0.0});
  const Eigen::Vector3d turned(std::cos(0.05) * arm.x(), -std::sin(0.05) * arm.x(), 0.0);
  const Eigen::Vector3d shift(0.0, 0.0, -0.004);
  Eigen::VectorXd told(6);
  told << arm - turned + shift, arm + turned + shift;
  motion.scene.handles.path = HandlePath(Eigen::VectorXd::Zero(1), told);
  ExpectFound(motion, {{"handle_turn.z", 0.05}, {"handle_shift.z", 0.004}, {"k_stretch", 70.0}});
}

}  // namespace
}  // namespace clothid::set_up_fit_test

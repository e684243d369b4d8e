// A rollout of a benchmark scene and the gradient of one scalar of it, by any method of the reverse sweep.
//
// The scene first runs for kWarmUpSeconds, so that the cloth is loaded, folded and in contact. The scalar is
// C = 1/2 sum over the steps that follow of |x_n - x_0|^2, where x_0 is a constant, not differentiated.
#ifndef CLOTHID_TOOLS_BENCHMARK_DERIVATIVES_BACKPROP_CASE_H_
#define CLOTHID_TOOLS_BENCHMARK_DERIVATIVES_BACKPROP_CASE_H_

#include <string>
#include <vector>

#include "sim/derivative/adjoint.h"
#include "sim/rollout/rollout.h"
#include "sim/rollout/simulator.h"
#include "tools/benchmark/base/benchmark_scene.h"
#include "tools/benchmark/base/common.h"

namespace clothid {

inline constexpr double kWarmUpSeconds = 0.2;

struct BackpropSetting {
  std::string name;
  double stretch_stiffness = 0.0;  // N/m
  double time_step = 0.0;          // s
};

// On `wind` and `slope` the paper's fixed point converges in the first; in the others it fails on many or all steps.
inline const std::vector<BackpropSetting> kBackpropSettings = {
    {"soft", 20.0, 0.005}, {"realistic", 1000.0, 0.01}, {"stiff", 1e5, 0.005}};

// Throws `Error` (kUsage), naming --settings, for a name that is none of them.
BackpropSetting FindBackpropSetting(const std::string& name);
std::vector<std::string> BackpropSettingNames();

struct BackpropCaseName {
  std::string scene, setting;
  int nodes = 0;      // along both axes
  int num_steps = 0;  // differentiated

  std::string ToString() const;  // "wind, soft, 12 x 12 nodes"
};

// Relative errors; NaN for what the scene does not have and for what C does not depend on:
// |theta dC/dtheta| <= 1e-8 C.
struct GradientErrors {
  double k_stretch = 0.0, density = 0.0, mu = 0.0;
  double x_0 = 0.0;  // |difference|/|dC/dx_0|

  double Worst() const;  // of those that are not NaN
};

class BackpropCase {
 public:
  // Throws `Error` (kUsage) for scene, setting and nodes that are not known, (kBadData) where a step does not converge.
  explicit BackpropCase(BackpropCaseName name);

  const BackpropCaseName& name() const { return name_; }

  // Repeats the rollout, to be timed.
  void SimulateAgain();

  // From now on the rollout is the one from the same start with this tolerance of its steps. Throws as the constructor.
  void SetStepTolerance(double tolerance);

  // Column j is the gradient of C with the term of step n times cos(j n): column 0 that of C.
  RolloutGradient Differentiate(const AdjointOptions& options, int num_columns = 1);

  // Of column 0.
  GradientErrors Compare(const RolloutGradient& gradient, const RolloutGradient& reference) const;

 private:
  void SetRollout(Rollout rollout);
  double ParameterError(int index, const RolloutGradient& gradient, const RolloutGradient& reference) const;

  BackpropCaseName name_;
  Simulator simulator_;
  Rollout rollout_;
  std::vector<ParameterId> ids_;
  double cost_ = 0.0;  // C, m^2
};

struct BackpropCaseOptions {
  std::vector<std::string> scenes = kBenchmarkScenes;
  std::vector<std::string> settings = {"soft", "realistic"};  // of kBackpropSettings
  std::vector<int> nodes = {12, 24, 48};
  int num_steps = 0;              // 0: the fewer the finer the mesh, 20 down to 4
  BenchmarkProgress on_progress;  // after every case

  // Throws `Error` (kUsage) naming the first flag out of range.
  void Validate() const;
};

// Every case in turn, by scene, setting, nodes.
void ForEachCase(const BackpropCaseOptions& options, const std::function<void(BackpropCase*)>& visit);

}  // namespace clothid

#endif  // CLOTHID_TOOLS_BENCHMARK_DERIVATIVES_BACKPROP_CASE_H_

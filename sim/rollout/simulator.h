// The workspace of a simulation: the scene's model, the matrices of a step and their symbolic factorisations. One per
// thread; rollouts of one simulator share its memory and its analyses, never its results: a rollout depends on
// parameters and scene alone.
#ifndef CLOTHID_SIM_ROLLOUT_SIMULATOR_H_
#define CLOTHID_SIM_ROLLOUT_SIMULATOR_H_

#include <memory>

#include "sim/scene/scene.h"

namespace clothid {

class ClothModel;
class StepSolver;
struct StepWorkspace;

class Simulator {
 public:
  // Builds the terms that the scene has: no obstacle, no contact; k_bend = 0, no bending; drag = 0, neither drag nor
  // wind; damping = 0, no internal damping. Throws `Error` where `ValidateScene` does.
  explicit Simulator(Scene scene);
  ~Simulator();
  Simulator(Simulator&&) noexcept;
  Simulator& operator=(Simulator&&) noexcept;

  // Threads that share the work of one rollout or sweep, 1 at first. They gain something in scenes of some thousand
  // nodes and cost nothing elsewhere. Results do not depend on them.
  void SetNumThreads(int num_threads);

  // Puts the fields, the pieces and the size of `parameters` into the model, which is const to all others: what runs a
  // rollout or a sweep does that first. Nothing where they are there already. Throws `Error` for a size where the rest
  // shape has no front.
  void UseParameters(const Parameters& parameters);

  const Scene& scene() const;       // as it was given: of its own size
  const ClothModel& model() const;  // whose scene has the size of the parameters
  StepSolver& step_solver();
  StepWorkspace& step_workspace();  // for one StepProblem at a time

 private:
  struct State;
  std::unique_ptr<State> state_;
};

}  // namespace clothid

#endif  // CLOTHID_SIM_ROLLOUT_SIMULATOR_H_

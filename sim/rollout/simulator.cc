#include "sim/rollout/simulator.h"

#include <utility>

#include "sim/cloth/cloth_model.h"
#include "sim/rollout/sized_scene.h"
#include "sim/step/step_solver.h"

namespace clothid {

struct Simulator::State {
  explicit State(Scene s)
      : scene(std::move(s)), model(scene), own_pattern(model.pattern()), solver(std::make_unique<StepSolver>(model)) {}

  // Makes the model one of that size, in the same place. The solver stays, as does the pattern, unless that is too
  // narrow for any size but the scene's own.
  void SetSize(const std::array<double, 2>& other) {
    const bool is_own = other == Parameters().size;
    auto sized = is_own ? nullptr : std::make_unique<Scene>(SizedScene(scene, other));
    const auto pattern = model.pattern();
    if (is_own && pattern != own_pattern) {
      model = ClothModel(scene);
      own_pattern = model.pattern();
    } else {
      model = ClothModel(is_own ? scene : *sized, model);
    }
    if (model.pattern() != pattern) {
      const int num_threads = solver->jacobian().num_threads();
      solver = std::make_unique<StepSolver>(model);
      solver->jacobian().SetNumThreads(num_threads);
    }
    sized_scene = std::move(sized);
    size = other;
    workspace = StepWorkspace();  // its masses are those of another size
  }

  Scene scene;
  std::unique_ptr<Scene> sized_scene;  // null: that of the model is the one above
  ClothModel model;
  std::shared_ptr<const BlockPattern> own_pattern;  // of the scene's own size
  std::unique_ptr<StepSolver> solver;               // of the model's pattern
  StepWorkspace workspace;
  std::array<double, 2> size = Parameters().size;  // in the model
};

namespace {

Scene Validated(Scene scene) {
  ValidateScene(scene, "scene");
  return scene;
}

}  // namespace

Simulator::Simulator(Scene scene) : state_(std::make_unique<State>(Validated(std::move(scene)))) {}
Simulator::~Simulator() = default;
Simulator::Simulator(Simulator&&) noexcept = default;
Simulator& Simulator::operator=(Simulator&&) noexcept = default;

void Simulator::SetNumThreads(int num_threads) { state_->solver->jacobian().SetNumThreads(num_threads); }

void Simulator::UseParameters(const Parameters& parameters) {
  if (parameters.size != state_->size) state_->SetSize(parameters.size);
  if (state_->model.SetVariation(parameters)) state_->workspace.time_step = 0.0;  // its masses are others
}

const Scene& Simulator::scene() const { return state_->scene; }
const ClothModel& Simulator::model() const { return state_->model; }
StepSolver& Simulator::step_solver() { return *state_->solver; }
StepWorkspace& Simulator::step_workspace() { return state_->workspace; }

}  // namespace clothid

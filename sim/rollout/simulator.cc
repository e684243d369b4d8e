#include "sim/rollout/simulator.h"

#include <utility>

#include "sim/cloth/cloth_model.h"
#include "sim/rollout/sized_scene.h"
#include "sim/step/step_solver.h"

namespace clothid {

struct Simulator::State {
  explicit State(Scene s) : scene(std::move(s)), model(scene), solver(model) {}
  // Makes the model one of that size, in the same place.
  void SetSize(const std::array<double, 2>& other) {
    const bool is_own = other == Parameters().size;
    auto sized = is_own ? nullptr : std::make_unique<Scene>(SizedScene(scene, other));
    model = ClothModel(is_own ? scene : *sized, model);
    sized_scene = std::move(sized);
    size = other;
    fields.reset();
    workspace.time_step = 0.0;  // its masses are those of another size
  }

  Scene scene;
  std::unique_ptr<Scene> sized_scene;  // null: that of the model is the one above
  ClothModel model;
  StepSolver solver;
  StepWorkspace workspace;
  std::shared_ptr<const std::vector<FieldFactors>> fields;  // in the model
  std::array<double, 2> size = Parameters().size;           // likewise
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

void Simulator::UseParameters(const Parameters& parameters) {
  if (parameters.size != state_->size) state_->SetSize(parameters.size);
  if (parameters.fields == state_->fields) return;
  state_->fields = parameters.fields;
  state_->model.SetFields(parameters.fields.get());
  state_->workspace.time_step = 0.0;  // its masses are those of other fields
}

const Scene& Simulator::scene() const { return state_->scene; }
const ClothModel& Simulator::model() const { return state_->model; }
StepSolver& Simulator::step_solver() { return state_->solver; }
StepWorkspace& Simulator::step_workspace() { return state_->workspace; }

}  // namespace clothid

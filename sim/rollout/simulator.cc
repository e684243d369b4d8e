#include "sim/rollout/simulator.h"

#include <utility>

#include "sim/cloth/cloth_model.h"
#include "sim/step/step_solver.h"

namespace clothid {

struct Simulator::State {
  explicit State(Scene s) : scene(std::move(s)), model(scene), solver(model) {}
  Scene scene;
  ClothModel model;
  StepSolver solver;
  StepWorkspace workspace;
  std::shared_ptr<const std::vector<FieldFactors>> fields;  // in the model
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

void Simulator::UseFields(const Parameters& parameters) {
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

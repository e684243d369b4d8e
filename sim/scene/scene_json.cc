#include "sim/scene/scene_json.h"

#include <algorithm>
#include <filesystem>
#include <limits>
#include <optional>
#include <system_error>
#include <utility>

#include "sim/air/wind_json.h"
#include "sim/base/error.h"
#include "sim/base/json_document.h"
#include "sim/base/text_file.h"
#include "sim/mesh/mesh_json.h"
#include "sim/scene/handles_json.h"
#include "sim/scene/materials_json.h"
#include "sim/scene/obstacle_json.h"
#include "sim/scene/pieces.h"
#include "sim/scene/sequence_json.h"

namespace clothid {
namespace {

using Kind = JsonValue::Kind;

// Reads one scene text. The parts come in the order in which they need each other: mesh, handles, start, obstacles.
class SceneReader {
 public:
  SceneReader(const JsonNode& root, const std::string& folder, const SceneDefaults& defaults)
      : root_(root), folder_(folder), defaults_(defaults) {}

  Scene Read() {
    root_.ExpectKeys({"clothid_scene", "time_step", "integrator", "duration",
                      "gravity",       "contact",   "touch",      "depenetration_speed",
                      "wind",          "air",       "node_force", "mesh",
                      "initial",       "handles",   "obstacles",  "self_contact",
                      "fabric",        "materials", "fields",     "pieces",
                      "parameters",    "solver"});
    ReadVersion();
    ReadTime();
    ReadForces();
    ReadContact();
    ReadMesh();
    ReadHandles();
    ReadInitial();
    if (const auto obstacles = root_.Find("obstacles"))
      scene_.obstacles = ReadObstacles(*obstacles, defaults_.sequences, folder_);
    if (const auto self_contact = root_.Find("self_contact")) ReadSelfContact(*self_contact);
    if (handles_) handles_->Attach(&scene_);
    if (const auto fabric = root_.Find("fabric")) ReadFabric(*fabric, &scene_);
    if (const auto materials = root_.Find("materials")) ReadMaterials(*materials, folder_, &scene_);
    if (const auto fields = root_.Find("fields")) scene_.fields = ReadFields(*fields);
    if (const auto pieces = root_.Find("pieces")) ReadPieces(*pieces, groups_, &scene_);
    ReadParameters();
    ReadSolver();
    return std::move(scene_);
  }

 private:
  static void ReadVector(const JsonNode& object, const char* key, Eigen::Vector3d* value) {
    if (const auto node = object.Find(key)) *value = node->Vector3();
  }

  static void ReadNumber(const JsonNode& object, const char* key, double* value) {
    if (const auto node = object.Find(key)) *value = node->Number();
  }

  static void ReadNonNegative(const JsonNode& object, const char* key, double* value) {
    if (const auto node = object.Find(key)) *value = node->NonNegativeNumber();
  }

  static void ReadPositive(const JsonNode& object, const char* key, double* value) {
    if (const auto node = object.Find(key)) *value = node->PositiveNumber();
  }

  // What a scene of version 1 does not name is what such scenes were made with.
  void ReadVersion() {
    const JsonNode version = root_.Require("clothid_scene", "the version of the format: 2");
    const int number = version.Integer(0, std::numeric_limits<int>::max());
    if (number != 1 && number != 2) version.Fail("expected version 1 or 2");
    if (number == 2) return;
    scene_.integrator = Integrator::kEuler;
    scene_.bending.law = BendingLaw::kEdges;
    scene_.bending.is_flat_at_rest = true;
  }

  void ReadTime() {
    ReadPositive(root_, "time_step", &scene_.time_step);
    ReadIntegrator();
    if (defaults_.has_mesh) {
      ReadPositive(root_, "duration", &scene_.duration);
      scene_.start_time = defaults_.start_time;
      scene_.duration = defaults_.duration;
    } else {
      scene_.duration = root_.Require("duration", "a number > 0 (s)").PositiveNumber();
    }
  }

  void ReadIntegrator() {
    const auto node = root_.Find("integrator");
    if (!node) return;
    const std::string name = node->is(Kind::kString) ? node->String() : "";
    if (name != "euler" && name != "sdirk2") node->Fail("expected \"euler\" or \"sdirk2\"");
    scene_.integrator = name == "euler" ? Integrator::kEuler : Integrator::kSdirk2;
  }

  void ReadForces() {
    ReadVector(root_, "gravity", &scene_.gravity);
    ReadVector(root_, "node_force", &scene_.node_force);
    if (const auto wind = root_.Find("wind")) ReadWind(*wind, &scene_.wind);
    if (const auto air = root_.Find("air")) ReadAirLaw(*air, &scene_.air_law);
  }

  void ReadContact() {
    ReadNonNegative(root_, "touch", &scene_.touch);
    ReadNonNegative(root_, "depenetration_speed", &scene_.depenetration_speed);
    const auto mode = root_.Find("contact");
    if (!mode) return;
    if (!mode->is(Kind::kString) || (mode->String() != "gap" && mode->String() != "velocity")) {
      mode->Fail("expected \"gap\" or \"velocity\"");
    }
    scene_.contact_mode = mode->String() == "gap" ? ContactMode::kGap : ContactMode::kVelocity;
  }

  void ReadMesh() {
    const Mesh* recorded = defaults_.has_mesh ? &defaults_.mesh : nullptr;
    if (recorded != nullptr && !root_.Find("mesh")) {
      scene_.mesh = *recorded;
    } else {
      const auto materials = root_.Find("materials");
      Eigen::Matrix3Xd* along_u = materials && WarpFollowsUv(*materials) ? &scene_.warp.directions : nullptr;
      const auto pieces = root_.Find("pieces");
      FaceGroups* groups = pieces && NeedGroups(*pieces) ? &groups_ : nullptr;
      scene_.mesh = clothid::ReadMesh(root_.Require("mesh", kMeshForms), folder_, recorded, along_u, groups);
    }
  }

  void ReadHandles() {
    scene_.handles = defaults_.handles;
    if (const auto handles = root_.Find("handles")) handles_.emplace(*handles, folder_, &scene_);
  }

  void ReadSelfContact(const JsonNode& node) {
    node.ExpectKeys({"mu", "thickness"});
    scene_.self_contact.emplace();
    ReadNonNegative(node, "mu", &scene_.self_contact->friction_coefficient);
    scene_.self_contact->thickness = node.Require("thickness", "a number > 0 (m)").PositiveNumber();
  }

  void ReadInitial() {
    const Eigen::Index num_nodes = scene_.mesh.num_nodes();
    scene_.initial_velocities = Eigen::VectorXd::Zero(3 * num_nodes);
    const auto initial = root_.Find("initial");
    if (initial) initial->ExpectKeys({"positions", "velocity"});
    const auto positions = initial ? initial->Find("positions") : std::nullopt;
    if (positions) {
      scene_.initial_positions = ReadInitialPositions(*positions);
    } else if (!defaults_.has_mesh) {
      scene_.initial_positions = scene_.mesh.rest_positions.reshaped();
    } else if (defaults_.initial_positions.size() > 0) {
      scene_.initial_positions = defaults_.initial_positions;
    } else {
      root_.Fail("key 'initial.positions': is missing; the recording's first frame shows too few points to start from");
    }
    if (const auto velocity = initial ? initial->Find("velocity") : std::nullopt) {
      scene_.initial_velocities.reshaped(3, num_nodes).colwise() = velocity->Vector3();
    }
    PutHandlesOnPath();
  }

  void PutHandlesOnPath() {
    if (handles_) handles_->PutOnPaths(&scene_);
    if (scene_.handles.path.times().size() == 0) return;
    const Eigen::VectorXd start = scene_.handles.path.At(scene_.start_time);
    for (std::size_t i = 0; i < scene_.handles.nodes.size(); ++i) {
      scene_.initial_positions.segment<3>(3 * static_cast<Eigen::Index>(scene_.handles.nodes[i])) =
          start.segment<3>(3 * static_cast<Eigen::Index>(i));
    }
  }

  Eigen::VectorXd ReadInitialPositions(const JsonNode& node) const {
    if (node.String() == "rest") return scene_.mesh.rest_positions.reshaped();
    return ReadNpyVectors(node, folder_, scene_.mesh.num_nodes()).reshaped();
  }

  void ReadParameters() {
    const auto parameters = root_.Find("parameters");
    if (!parameters) return;
    for (const std::string& name : parameters->keys()) {
      const JsonNode node = *parameters->Find(name);
      const ParameterId id = KnownParameter(node, name);
      node.ExpectKeys({"nominal", "lower", "upper", "frozen", "prior"});
      ParameterRange& range = scene_.parameters[name];
      const ParameterDomain domain = RowOf(id.kind).domain;
      const auto read_bound = domain == ParameterDomain::kAny ? ReadNumber : ReadNonNegative;
      (domain == ParameterDomain::kPositive ? ReadPositive : read_bound)(node, "nominal", &range.nominal);
      read_bound(node, "lower", &range.lower_bound);
      read_bound(node, "upper", &range.upper_bound);
      if (const auto frozen = node.Find("frozen")) range.frozen = frozen->Boolean();
      // Absent values (NaN) compare as in order with everything.
      if (range.lower_bound >= range.upper_bound) node.Fail("expected lower < upper");
      if (range.nominal < range.lower_bound || range.nominal > range.upper_bound) {
        node.Fail("expected lower <= nominal <= upper");
      }
      if (const auto prior = node.Find("prior")) {
        if (range.frozen) prior->Fail("expected none of a parameter that is frozen");
        range.prior = ReadPrior(*prior, id.kind);
      }
    }
  }

  ParameterId KnownParameter(const JsonNode& node, const std::string& name) const {
    std::string problem;
    try {
      return ParseParameter(name, scene_);
    } catch (const Error& error) {
      problem = error.what();
    }
    node.Fail(Printable(problem));
  }

  void ReadSolver() {
    const auto solver = root_.Find("solver");
    if (!solver) return;
    solver->ExpectKeys({"step_tolerance", "adjoint_tolerance", "max_newton_iterations", "max_substep_halvings"});
    SolverOptions& options = scene_.solver;
    ReadTolerance(*solver, "step_tolerance", &options.step_tolerance);
    ReadTolerance(*solver, "adjoint_tolerance", &options.adjoint_tolerance);
    if (const auto node = solver->Find("max_newton_iterations"))
      options.max_newton_iterations = node->Integer(1, 100000);
    if (const auto node = solver->Find("max_substep_halvings")) options.max_substep_halvings = node->Integer(0, 20);
  }

  static void ReadTolerance(const JsonNode& object, const char* key, double* value) {
    const auto node = object.Find(key);
    if (!node) return;
    if (!node->is(Kind::kNumber) || !(node->Number() > 0.0 && node->Number() < 1.0)) {
      node->Fail("expected a number between 0 and 1");
    }
    *value = node->Number();
  }

  const JsonNode root_;
  const std::string& folder_;
  const SceneDefaults& defaults_;
  FaceGroups groups_;  // of the file of the mesh, where pieces need them
  std::optional<HandlesReader> handles_;
  Scene scene_;
};

std::string FolderOf(const std::string& path) { return std::filesystem::path(path).parent_path().string(); }

// The texts of the keys that JsonNode::Path is asked of, in `value`, which stands under `key`.
void CollectFiles(const JsonValue& value, const std::string& key, const std::string& folder,
                  std::vector<std::string>* files) {
  const bool is_start = key == "positions" && value.text != "rest";
  const bool is_warp = key == "warp_direction" && value.text != kWarpByUv;
  const bool is_sequence = key == "file";
  const std::string path = (std::filesystem::path(folder) / value.text).string();
  if (value.kind == Kind::kString &&
      (key == "obj" || key == "path" || key == "poses" || key == "times" || is_start || is_warp)) {
    files->push_back(path);
  } else if (value.kind == Kind::kString && is_sequence) {
    for (const std::string& file : FilesOfSequence(path)) files->push_back(file);
  }
  for (std::size_t i = 0; i < value.items.size(); ++i) {
    CollectFiles(value.items[i], i < value.keys.size() ? value.keys[i] : is_sequence ? key : "", folder, files);
  }
}

}  // namespace

Scene ParseScene(const std::string& text, const std::string& source, const std::string& folder,
                 const SceneDefaults& defaults) {
  const JsonValue document = ParseJson(text, source);
  Scene scene = SceneReader(JsonNode(document, source), folder, defaults).Read();
  ValidateScene(scene, source);
  SetLevels(&scene);
  return scene;
}

Scene ReadScene(const std::string& path) { return ParseScene(ReadText(path, kMaxJsonBytes), path, FolderOf(path)); }

std::vector<std::string> FilesOfScene(const std::string& path) {
  std::vector<std::string> files = {path};
  std::error_code ignored;
  if (std::filesystem::is_fifo(path, ignored)) return files;
  CollectFiles(ParseJson(ReadText(path, kMaxJsonBytes), path), "", FolderOf(path), &files);
  return files;
}

}  // namespace clothid

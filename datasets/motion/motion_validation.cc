#include "datasets/motion/motion_validation.h"

#include <algorithm>
#include <cfloat>
#include <cmath>
#include <set>
#include <sstream>

#include "datasets/motion/number_checks.h"

namespace clothid {
namespace {

// A time this little before the start of the scene, in steps, is rounding.
constexpr double kSameTime = 1e-9;

// What does not depend on handles.
void ValidateForces(const ForceReadings& forces, int num_nodes, const NumberChecks& check) {
  if (forces.is_empty()) {
    if (forces.values.size() > 0 || forces.sigma.size() > 0) check.Fail("force_times", "expected at least one time");
    return;
  }
  check.ExpectIncreasing("force_times", forces.times);
  const Eigen::Index num_groups = forces.num_groups();
  check.ExpectSize("handle_forces", forces.values.size(), 3 * num_groups * forces.times.size());
  check.ExpectSize("handle_forces", forces.values.cols(), forces.times.size());
  if (forces.values.array().isInf().any()) check.Fail("handle_forces", "expected finite numbers, or NaN");
  if (forces.values.array().isNaN().all()) check.Fail("handle_forces", "expected a force that was measured");
  if (forces.moments.size() > 0) {
    check.ExpectSize("handle_moments", forces.moments.size(), forces.values.size());
    if (!forces.moments.allFinite()) check.Fail("handle_moments", "expected finite numbers");
  }
  check.ExpectSize("force_sigma", forces.sigma.size(), num_groups);
  check.ExpectPositive("force_sigma", forces.sigma);
  std::set<int> seen;
  for (const std::vector<int>& group : forces.groups) {
    if (group.empty()) check.Fail("force_nodes", "has a group without a node");
    for (const int node : group) {
      check.ExpectIndex("force_nodes", static_cast<Eigen::Index>(seen.size()), node, num_nodes);
      if (!seen.insert(node).second) check.Fail("force_nodes", "node " + std::to_string(node) + " is listed twice");
    }
  }
}

class TensorValidator {
 public:
  TensorValidator(const MotionTensors& tensors, const std::string& path)
      : tensors_(tensors), path_(path), check_(NumberChecks::Kind::kFile, path) {}

  void Validate() const {
    ValidateTimes();
    ValidateSizes();
    ValidateMesh(tensors_.mesh, path_);
    check_.ExpectPositions("positions", tensors_.positions, Largest(tensors_.single_precision));
    ValidateIndices(tensors_.node_index, tensors_.mesh.num_nodes(), "node_index");
    ValidateIndices(tensors_.face_index, tensors_.mesh.num_faces(), "face_index");
    ValidateIndices(tensors_.handle_index, tensors_.mesh.num_nodes(), "handle_index");
    ValidateKinds();
    ValidateBarycentric();
    ValidateHandles();
    ValidateClouds();
    check_.ExpectPositive("sigma", tensors_.sigma);
    ValidateForces(tensors_.forces, tensors_.mesh.num_nodes(), check_);
  }

 private:
  static double Largest(bool single_precision) { return single_precision ? static_cast<double>(FLT_MAX) : DBL_MAX; }

  Eigen::Index num_points() const { return tensors_.positions.rows() / 3; }

  void ValidateTimes() const {
    const Eigen::Index num_times = tensors_.times.size();
    if (num_times < 2) check_.Fail("times", "expected at least two frames, found " + std::to_string(num_times));
    check_.ExpectIncreasing("times", tensors_.times);
    check_.ExpectIncreasing("handle_times", tensors_.handle_times);
  }

  void ValidateSizes() const {
    const Eigen::Index num_times = tensors_.times.size();
    check_.ExpectSize("positions", tensors_.positions.size(), 3 * num_points() * num_times);
    if (num_points() == 0 && tensors_.clouds.empty()) check_.Fail("positions", "expected at least one point");
    check_.ExpectSize("positions", tensors_.positions.cols(), num_times);
    ValidatePointSizes();
    const Eigen::Index num_handles = static_cast<Eigen::Index>(tensors_.handle_index.size());
    if (num_handles == 0) check_.ExpectSize("handle_times", tensors_.handle_times.size(), 0);
    const Eigen::Index num_knots = tensors_.handle_times.size() > 0 ? tensors_.handle_times.size() : num_times;
    check_.ExpectSize("handle_positions", tensors_.handle_positions.size(), 3 * num_handles * num_knots);
    if (num_handles > 0) check_.ExpectSize("handle_positions", tensors_.handle_positions.cols(), num_knots);
    if (tensors_.sigma.size() > 0) check_.ExpectSize("sigma", tensors_.sigma.size(), num_points());
  }

  void ValidatePointSizes() const {
    const bool by_node = !tensors_.node_index.empty(), by_face = !tensors_.face_index.empty();
    if (by_node && by_face) check_.Fail("face_index", "expected either node_index or face_index");
    if (by_node) {
      check_.ExpectSize("node_index", static_cast<Eigen::Index>(tensors_.node_index.size()), num_points());
    }
    if (by_face) {
      check_.ExpectSize("face_index", static_cast<Eigen::Index>(tensors_.face_index.size()), num_points());
    }
    check_.ExpectSize("barycentric", tensors_.barycentric.size(), by_face ? 3 * num_points() : 0);
    if (!tensors_.point_kind.empty()) {
      check_.ExpectSize("point_kind", static_cast<Eigen::Index>(tensors_.point_kind.size()), num_points());
    }
    if (!by_node && !by_face && num_points() != tensors_.mesh.num_nodes() && num_points() > 0) {
      check_.Fail("positions", "expected the " + std::to_string(tensors_.mesh.num_nodes()) +
                                   " nodes of the mesh, found " + std::to_string(num_points()) +
                                   " points and neither node_index nor face_index");
    }
  }

  void ValidateIndices(const std::vector<int>& indices, int count, const std::string& tensor) const {
    for (std::size_t i = 0; i < indices.size(); ++i) {
      check_.ExpectIndex(tensor, static_cast<Eigen::Index>(i), indices[i], count);
    }
  }

  void ValidateKinds() const {
    for (std::size_t p = 0; p < tensors_.point_kind.size(); ++p) {
      const int kind = tensors_.point_kind[p];
      if (kind >= 0 && kind <= static_cast<int>(PointKind::kBorder)) continue;
      check_.FailEntry("point_kind", static_cast<Eigen::Index>(p),
                       "is " + std::to_string(kind) + "; expected 0 (material), 1 (surface) or 2 (border)");
    }
  }

  void ValidateBarycentric() const {
    for (Eigen::Index i = 0; i < tensors_.barycentric.cols(); ++i) {
      if (!check_.SumsToOne(tensors_.barycentric.col(i).sum())) {
        check_.Fail("barycentric", "row " + std::to_string(i) + " does not sum to 1");
      }
    }
  }

  void ValidateHandles() const {
    std::set<int> seen;
    for (const int node : tensors_.handle_index) {
      if (!seen.insert(node).second) check_.Fail("handle_index", "node " + std::to_string(node) + " is listed twice");
    }
    for (Eigen::Index t = 0; t < tensors_.handle_positions.cols(); ++t) {
      if (!tensors_.handle_positions.col(t).allFinite()) {
        check_.Fail("handle_positions", (tensors_.handle_times.size() > 0 ? "time " : "frame ") + std::to_string(t) +
                                            " is not finite; a handle's path must have no gap");
      }
    }
  }

  void ValidateClouds() const {
    if (!std::isfinite(tensors_.cloud_sigma) || tensors_.cloud_sigma < 0.0) {
      check_.Fail("cloud_sigma", "is not a number > 0");
    }
    if (tensors_.clouds.empty()) {
      if (tensors_.cloud_sigma > 0.0) check_.Fail("cloud_positions", "is missing; expected beside cloud_sigma");
      return;
    }
    check_.ExpectClouds("cloud_positions", "cloud_offsets", tensors_.clouds, tensors_.times.size(),
                        Largest(tensors_.single_precision_clouds));
  }

  const MotionTensors& tensors_;
  const std::string& path_;
  NumberChecks check_;
};

class MotionValidator {
 public:
  explicit MotionValidator(const RecordedMotion& motion)
      : motion_(motion), check_(NumberChecks::Kind::kRecording, motion.name) {}

  void Validate() const {
    ValidateMesh(motion_.scene.mesh, motion_.name);
    ValidateTimes();
    ValidatePositions();
    for (int p = 0; p < motion_.num_points(); ++p) ValidatePoint(p);
    if (motion_.sigma.size() > 0) check_.ExpectSize("sigma", motion_.sigma.size(), motion_.num_points());
    check_.ExpectPositive("sigma", motion_.sigma);
    if (!std::isfinite(motion_.cloud_sigma) || motion_.cloud_sigma < 0.0) {
      check_.Fail("cloud_sigma", "expected a number > 0, or 0 where it is not known");
    }
    if (!motion_.clouds.empty()) {
      check_.ExpectClouds("clouds", "clouds", motion_.clouds, motion_.times.size(), DBL_MAX);
    }
    ValidateScenePart();
    ValidateHandleForces();
  }

 private:
  void ValidateTimes() const {
    if (motion_.num_frames() == 0) check_.Fail("times", "expected at least one frame");
    if (!(motion_.scene.time_step > 0.0)) check_.Fail("scene.time_step", "expected a number > 0");
    check_.ExpectIncreasing("times", motion_.times);
    ValidateSteps("times", motion_.times);
  }

  void ValidateSteps(const std::string& field, const Eigen::VectorXd& times) const {
    const double time_step = motion_.scene.time_step, start = motion_.scene.start_time;
    for (Eigen::Index i = 0; i < times.size(); ++i) {
      const double steps = (times[i] - start) / time_step;
      std::ostringstream message;
      if (!(steps >= -kSameTime)) {
        message << "lies before the start of the scene (" << start << " s)";
      } else if (!(steps <= kMaxRecordedSteps)) {
        message << "lies " << steps << " steps of " << time_step
                << " s behind the start of the scene; expected at most " << kMaxRecordedSteps;
      } else {
        continue;
      }
      check_.FailEntry(field, i, message.str());
    }
  }

  void ValidateHandleForces() const {
    const ForceReadings& forces = motion_.forces;
    ValidateForces(forces, motion_.scene.mesh.num_nodes(), check_);
    if (forces.is_empty()) return;
    ValidateSteps("force_times", forces.times);
    const std::vector<int>& handles = motion_.scene.handles.nodes;
    if (handles.empty()) check_.Fail("handle_forces", "the scene has no handles at which forces act");
    for (const std::vector<int>& group : forces.groups) {
      for (const int node : group) {
        if (std::find(handles.begin(), handles.end(), node) == handles.end()) {
          check_.Fail("force_nodes", "node " + std::to_string(node) + " is no handle of the scene");
        }
      }
    }
  }

  void ValidatePositions() const {
    if (motion_.num_points() == 0 && motion_.clouds.empty()) check_.Fail("points", "expected at least one point");
    const auto shape = [](Eigen::Index rows, Eigen::Index columns) {
      return "[" + std::to_string(rows) + " x " + std::to_string(columns) + "]";
    };
    const Eigen::Index rows = 3 * static_cast<Eigen::Index>(motion_.num_points());
    if (motion_.positions.rows() != rows || motion_.positions.cols() != motion_.num_frames()) {
      check_.Fail("positions", "expected " + shape(rows, motion_.num_frames()) + " for the points and times, found " +
                                   shape(motion_.positions.rows(), motion_.positions.cols()));
    }
    check_.ExpectPositions("positions", motion_.positions, DBL_MAX);
  }

  void ValidatePoint(int p) const {
    const ObservedPoint& point = motion_.points[p];
    if (point.num_nodes != 1 && point.num_nodes != 3) {
      check_.FailEntry("points", p, "has " + std::to_string(point.num_nodes) + " nodes; expected 1 or 3");
    }
    double sum = 0.0;
    for (int k = 0; k < point.num_nodes; ++k) {
      check_.ExpectIndex("points[" + std::to_string(p) + "].nodes", k, point.nodes[k], motion_.scene.mesh.num_nodes());
      sum += point.weights[k];
    }
    if (!check_.SumsToOne(sum)) {
      check_.FailEntry("points", p, "has weights that sum to " + std::to_string(sum) + "; expected 1");
    }
  }

  // What predictions take from the scene before a simulator has looked at it.
  void ValidateScenePart() const {
    const Scene& scene = motion_.scene;
    const Eigen::Index size = 3 * static_cast<Eigen::Index>(scene.mesh.num_nodes());
    check_.ExpectSize("scene.initial_positions", scene.initial_positions.size(), size);
    check_.ExpectSize("scene.initial_velocities", scene.initial_velocities.size(), size);
    for (std::size_t i = 0; i < scene.handles.nodes.size(); ++i) {
      check_.ExpectIndex("scene.handles.nodes", static_cast<Eigen::Index>(i), scene.handles.nodes[i],
                         scene.mesh.num_nodes());
    }
  }

  const RecordedMotion& motion_;
  NumberChecks check_;
};

}  // namespace

void ValidateMotion(const RecordedMotion& motion) { MotionValidator(motion).Validate(); }

void ValidateMotionTensors(const MotionTensors& tensors, const std::string& path) {
  TensorValidator(tensors, path).Validate();
}

}  // namespace clothid

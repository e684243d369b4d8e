#include "identify/base/fingerprint.h"

#include <Eigen/Core>
#include <algorithm>
#include <ios>
#include <locale>
#include <sstream>
#include <string_view>

#include "datasets/files/sha256.h"
#include "identify/base/version.h"

namespace clothid {
namespace {

std::string Digest(const Eigen::MatrixXd& numbers) {
  return Sha256Hex({std::string_view(reinterpret_cast<const char*>(numbers.data()), numbers.size() * sizeof(double))});
}

// Nothing where all points are material.
void DescribeKinds(const RecordedMotion& motion, std::ostream* text) {
  const auto is_material = [](const ObservedPoint& point) { return point.kind == PointKind::kMaterial; };
  if (std::all_of(motion.points.begin(), motion.points.end(), is_material)) return;
  *text << "kinds";
  for (const ObservedPoint& point : motion.points) *text << " " << static_cast<int>(point.kind);
  *text << "\n";
}

// Nothing where there are no clouds.
void DescribeClouds(const RecordedMotion& motion, std::ostream* text) {
  for (const Eigen::Matrix3Xd& cloud : motion.clouds) *text << "cloud " << cloud.cols() << " " << Digest(cloud) << "\n";
  if (!motion.clouds.empty()) *text << "cloud sigma " << motion.cloud_sigma << "\n";
}

// Likewise.
void DescribeForces(const ForceReadings& forces, std::ostream* text) {
  if (forces.is_empty()) return;
  *text << "forces " << Digest(forces.times) << " " << Digest(forces.values) << " " << Digest(forces.sigma);
  for (const std::vector<int>& group : forces.groups) {
    *text << " :";
    for (const int node : group) *text << " " << node;
  }
  *text << "\n";
}

// Nothing of a mesh that has only nodes and faces.
std::string DescribeSewing(const Mesh& mesh) {
  std::ostringstream text;
  text << std::hexfloat;
  if (mesh.has_corner_rest()) text << " " << Digest(mesh.corner_rest);
  for (const auto& [low, high] : mesh.folds) text << " fold " << low << " " << high;
  for (const SeamLink& link : mesh.links) {
    text << " link " << link.node << " " << link.edge[0] << " " << link.edge[1] << " " << link.share << " "
         << link.stiffness << " " << link.closing_time;
  }
  return text.str();
}

}  // namespace

void DescribeProgram(std::ostream* text) {
  text->imbue(std::locale::classic());
  *text << std::hexfloat << "clothid " << Version() << " " << GitHash() << "\n";
}

void DescribeMotion(const RecordedMotion& motion, std::ostream* text) {
  const Scene& scene = motion.scene;
  *text << "recording " << motion.sha256 << " " << Digest(motion.times) << " " << Digest(motion.positions) << " "
        << Digest(motion.sigma) << (motion.centroid ? " " + Digest(*motion.centroid) : "") << "\n"
        << "scene " << Sha256Hex({motion.scene_text}) << " " << IntegratorName(scene.integrator) << " "
        << scene.time_step << " " << scene.start_time << " " << scene.duration << "\n"
        << "mesh " << Digest(scene.mesh.rest_positions) << " " << Digest(scene.mesh.faces.cast<double>())
        << DescribeSewing(scene.mesh) << "\n"
        << "start " << Digest(scene.initial_positions) << " " << Digest(scene.initial_velocities) << "\n"
        << "handles " << Digest(scene.handles.path.times()) << " " << Digest(scene.handles.path.positions()) << "\n"
        << "solver " << scene.solver.step_tolerance << " " << scene.solver.adjoint_tolerance << " "
        << scene.solver.max_newton_iterations << " " << scene.solver.max_substep_halvings << "\n";
  DescribeKinds(motion, text);
  DescribeClouds(motion, text);
  DescribeForces(motion.forces, text);
  if (!IsUnknown(motion.start_source)) return;
  const HandleMeasurements& handles = motion.handle_measurements;
  *text << "unknown start " << static_cast<int>(motion.start_source) << " " << Digest(handles.times) << " "
        << Digest(handles.deviations) << " " << Digest(handles.sigma) << "\n";
}

std::string FitFingerprint(const std::vector<RecordedMotion>& motions, const std::vector<ParameterBlock>& blocks,
                           const FitOptions& options) {
  std::ostringstream text;
  DescribeProgram(&text);
  for (const RecordedMotion& motion : motions) DescribeMotion(motion, &text);
  for (const ParameterBlock& block : blocks) {
    text << "parameter " << block.name << " " << static_cast<int>(block.scale) << " " << block.start << " "
         << block.unit << " " << block.lower_bound << " " << block.upper_bound << " " << block.frozen;
    if (block.prior.is_given()) text << " prior " << block.prior.center << " " << block.prior.spread;
    if (block.is_linked()) text << " linked " << block.linked_to << " " << block.link_spread;
    text << "\n";
  }
  text << "adjoint " << static_cast<int>(options.adjoint.method) << " " << options.adjoint.threshold.value_or(0.0)
       << "\n";
  text << "fit " << JacobianMethodName(options.jacobian) << " " << static_cast<int>(options.precision) << " "
       << static_cast<int>(options.loss.kind) << " " << options.loss.scale << " " << options.max_iterations << " "
       << options.function_tolerance << " " << options.parameter_tolerance << " " << options.num_starts << " "
       << options.seed << " " << options.estimate_uncertainty << " " << options.check_interval << "\n";
  if (options.assimilate.is_on()) {
    text << "assimilate " << static_cast<int>(options.assimilate.kind) << " " << options.assimilate.given.memory << " "
         << options.assimilate.given.smoothing.value_or(-1.0) << "\n";
  }
  return Sha256Hex({text.str()});
}

}  // namespace clothid

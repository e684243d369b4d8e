#include "identify/report.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <iomanip>
#include <locale>
#include <map>
#include <nlohmann/json.hpp>
#include <sstream>

#include "identify/version.h"
#include "sim/error.h"

namespace clothid {
namespace {

using Json = nlohmann::ordered_json;

// A number in its shortest form that reads back exactly.
std::string ExactNumber(double value) { return std::isfinite(value) ? Json(value).dump() : std::string(); }

Json ParametersJson(const std::vector<FittedParameter>& parameters) {
  Json json = Json::object();
  for (const FittedParameter& parameter : parameters) {
    const bool has_no_influence = parameter.has_influence && !*parameter.has_influence;
    json[parameter.name] = {{"value", parameter.value},
                            {"std", nullptr},
                            {"lower95", nullptr},
                            {"upper95", nullptr},
                            {"start", parameter.start},
                            {"at_bound", parameter.at_bound},
                            {"identifiable", has_no_influence ? Json(false) : Json(nullptr)}};
  }
  return json;
}

Json HoldoutJson(const std::optional<Holdout>& holdout) {
  if (!holdout) return nullptr;
  return {{"rmse_m", holdout->rmse}, {"nominal_rmse_m", holdout->nominal_rmse}};
}

Json GradientCheckJson(const std::optional<GradientCheck>& check) {
  if (!check) return nullptr;
  return {{"adjoint_vs_sensitivity", check->adjoint_vs_sensitivity}, {"adjoint_vs_fd", check->adjoint_vs_fd}};
}

Json ProvenanceJson(const RunRecord& run, const std::vector<RecordedMotion>& motions) {
  std::string sha256;
  for (const RecordedMotion& motion : motions) sha256 += (sha256.empty() ? "" : ",") + motion.sha256;
  return {{"version", Version()}, {"git", GitHash()}, {"input_sha256", sha256},
          {"flags", run.flags},   {"seed", run.seed}, {"threads", run.num_threads}};
}

bool IsUnidentifiable(const FittedParameter& parameter) {
  return parameter.at_bound || (parameter.has_influence && !*parameter.has_influence);
}

// The face of every barycentric point: its nodes in the face's order.
std::vector<int> FaceIndices(const RecordedMotion& motion) {
  std::map<std::array<int, 3>, int> face_of_nodes;
  const Eigen::Matrix3Xi& faces = motion.scene.mesh.faces;
  for (int f = 0; f < faces.cols(); ++f) face_of_nodes[{faces(0, f), faces(1, f), faces(2, f)}] = f;
  std::vector<int> indices;
  for (const ObservedPoint& point : motion.points) {
    const auto it = face_of_nodes.find({point.nodes[0], point.nodes[1], point.nodes[2]});
    if (point.num_nodes != 3 || it == face_of_nodes.end()) {
      throw Error(ErrorKind::kBadData, motion.name + ": an observed point lies on no triangle of the mesh");
    }
    indices.push_back(it->second);
  }
  return indices;
}

void SetPoints(const RecordedMotion& motion, MotionTensors* tensors) {
  const bool all_nodes = std::all_of(motion.points.begin(), motion.points.end(),
                                     [](const ObservedPoint& point) { return point.num_nodes == 1; });
  if (all_nodes) {
    for (const ObservedPoint& point : motion.points) tensors->node_index.push_back(point.nodes[0]);
    return;
  }
  tensors->face_index = FaceIndices(motion);
  tensors->barycentric.resize(3, motion.num_points());
  for (int p = 0; p < motion.num_points(); ++p) {
    for (int k = 0; k < 3; ++k) tensors->barycentric(k, p) = motion.points[p].weights[k];
  }
}

void SetHandles(const RecordedMotion& motion, MotionTensors* tensors) {
  const Handles& handles = motion.scene.handles;
  if (handles.nodes.empty() || handles.path.num_handles() == 0) return;
  tensors->handle_index = handles.nodes;
  tensors->handle_positions.resize(3 * handles.path.num_handles(), motion.num_frames());
  for (int i = 0; i < motion.num_frames(); ++i) tensors->handle_positions.col(i) = handles.path.At(motion.times[i]);
}

std::string Millimetres(double metres) {
  std::ostringstream text;
  text << std::setprecision(4) << 1e3 * metres << " mm";
  return text.str();
}

std::string Remark(const FittedParameter& parameter) {
  if (parameter.frozen) return "frozen";
  if (parameter.has_influence && !*parameter.has_influence) return "not identifiable: no influence on the recording";
  return parameter.at_bound ? "at its bound" : "";
}

}  // namespace

ExitCode FitExitCode(const FitSummary& summary, const RunRecord& run) {
  if (summary.status == FitStatus::kInterrupted) return kExitInterrupted;
  if (summary.status != FitStatus::kConverged) return kExitNotConverged;
  if (std::any_of(summary.parameters.begin(), summary.parameters.end(), IsUnidentifiable)) return kExitNotIdentifiable;
  if (run.holdout && std::isnan(run.holdout->rmse)) return kExitHoldoutFailed;
  return kExitFitted;
}

std::string ResultJson(const FitSummary& summary, const RunRecord& run, const std::vector<RecordedMotion>& motions) {
  Json json;
  json["schema"] = "clothid.result/1";
  json["status"] = FitStatusName(summary.status);
  json["exit_code"] = static_cast<int>(FitExitCode(summary, run));
  json["parameters"] = ParametersJson(summary.parameters);
  json["rmse_m"] = summary.error.rmse();
  json["fit_percent"] = summary.error.fit_percent();
  json["holdout"] = HoldoutJson(run.holdout);
  json["cost"] = summary.cost;
  json["jacobian"] = JacobianMethodName(run.jacobian);
  json["iterations"] = summary.num_iterations();
  json["rollouts"] = summary.statistics.rollouts;
  json["sweeps"] = summary.statistics.sweeps;
  json["failed_steps"] = summary.statistics.counts.failed_steps;
  json["gradient_check"] = GradientCheckJson(run.gradient_check);
  json["seconds"] = {{"total", summary.total_seconds},
                     {"rollout", summary.statistics.rollout_seconds},
                     {"derivative", summary.statistics.derivative_seconds},
                     {"solver", summary.solver_seconds}};
  json["provenance"] = ProvenanceJson(run, motions);
  return json.dump(2) + "\n";
}

std::string ConvergenceCsv(const FitSummary& summary) {
  std::ostringstream csv;
  csv << "iteration,seconds,cost";
  for (const FittedParameter& parameter : summary.parameters) csv << "," << parameter.name;
  csv << ",gradient_norm,rollouts\n";
  for (const FitIteration& row : summary.iterations) {
    csv << row.iteration << "," << ExactNumber(row.seconds) << "," << ExactNumber(row.cost);
    for (Eigen::Index i = 0; i < row.values.size(); ++i) csv << "," << ExactNumber(row.values[i]);
    csv << "," << ExactNumber(row.gradient_norm) << "," << row.rollouts << "\n";
  }
  return csv.str();
}

MotionTensors PredictedMotion(const RecordedMotion& motion, const Eigen::MatrixXd& predicted,
                              const std::vector<FittedParameter>& parameters) {
  MotionTensors tensors;
  tensors.times = motion.times;
  tensors.positions = predicted;
  tensors.single_precision = false;
  tensors.mesh = motion.scene.mesh;
  SetPoints(motion, &tensors);
  SetHandles(motion, &tensors);
  tensors.scene_text = motion.scene_text;
  tensors.provenance = "predicted by identify " + Version() + " (git " + GitHash() +
                       ") for the recording with sha256 " + motion.sha256 + " at";
  for (const FittedParameter& parameter : parameters) {
    tensors.provenance += " " + parameter.name + "=" + ExactNumber(parameter.value);
  }
  return tensors;
}

void WriteReport(const FitSummary& summary, const RunRecord& run, const std::vector<RecordedMotion>& motions,
                 OutputFolder* folder) {
  folder->Write("result.json", ResultJson(summary, run, motions));
  folder->Write("convergence.csv", ConvergenceCsv(summary));
  for (std::size_t r = 0; r < motions.size(); ++r) {
    const std::string name = r == 0 ? "predicted.bin" : "predicted_" + std::to_string(r + 1) + ".bin";
    WriteMotion(PredictedMotion(motions[r], summary.predicted[r], summary.parameters), folder->TemporaryPath(name));
  }
  folder->Commit();
}

std::string ResultTable(const FitSummary& summary, const RunRecord& run) {
  std::ostringstream table;
  table << std::left << std::setw(16) << "parameter" << std::setw(16) << "estimate"
        << "start\n";
  for (const FittedParameter& parameter : summary.parameters) {
    table << std::left << std::setw(16) << parameter.name << std::setw(16) << std::setprecision(8) << parameter.value
          << std::setprecision(6) << std::setw(10) << parameter.start << Remark(parameter) << "\n";
  }
  table << "rmse            " << Millimetres(summary.error.rmse()) << " (" << summary.error.rmse()
        << " m), at the start " << Millimetres(summary.start_error.rmse()) << "\n";
  if (std::isfinite(summary.error.fit_percent())) {
    table << "fit             " << std::setprecision(5) << summary.error.fit_percent() << " %, at the start "
          << summary.start_error.fit_percent() << " %\n";
  }
  if (run.holdout) {
    table << "holdout rmse    " << Millimetres(run.holdout->rmse) << " (" << std::setprecision(6) << run.holdout->rmse
          << " m), at the start " << Millimetres(run.holdout->nominal_rmse) << "\n";
  }
  if (run.gradient_check) {
    table << "gradient check  adjoint against sensitivity " << std::setprecision(3)
          << run.gradient_check->adjoint_vs_sensitivity << ", against central differences "
          << run.gradient_check->adjoint_vs_fd << "\n";
  }
  table << "status          " << FitStatusName(summary.status) << " after " << summary.num_iterations()
        << " iterations, " << summary.statistics.rollouts << " rollouts, " << summary.statistics.sweeps << " sweeps\n";
  if (summary.statistics.counts.substeps > 0) {
    table << "note            " << summary.statistics.counts.substeps
          << " substeps were taken: each makes the cost jump a little\n";
  }
  return table.str();
}

}  // namespace clothid

#include "identify/report/report.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <iomanip>
#include <limits>
#include <map>
#include <nlohmann/json.hpp>
#include <sstream>
#include <string_view>

#include "datasets/importing/handle_tracks.h"
#include "datasets/motion/scene_text.h"
#include "identify/base/join_words.h"
#include "identify/base/version.h"
#include "identify/card/card_of_fit.h"
#include "identify/card/card_page.h"
#include "identify/export/export.h"
#include "identify/report/interval_text.h"
#include "identify/report/repetition_report.h"
#include "identify/report/report_page.h"
#include "identify/report/report_replay.h"
#include "identify/report/transfer_report.h"
#include "identify/result/repetition_json.h"
#include "identify/result/result_json.h"
#include "identify/verdict/model_error_text.h"
#include "sim/base/error.h"
#include "sim/scene/material_field.h"

namespace clothid {
namespace {

constexpr char kReportName[] = "report.html", kCardPageName[] = "card.html";

// A number in its shortest form that reads back exactly.
std::string ExactNumber(double value) { return std::isfinite(value) ? nlohmann::json(value).dump() : std::string(); }

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

// A recording with points that are compared with the surface is predicted by its nodes, below the tracked points.
void SetPrediction(const RecordedMotion& motion, const Eigen::MatrixXd& predicted, MotionTensors* tensors) {
  if (predicted.rows() > 3 * motion.num_points()) {
    tensors->positions = predicted.bottomRows(3 * motion.scene.mesh.num_nodes());
    return;
  }
  tensors->positions = predicted;
  SetPoints(motion, tensors);
}

std::string CloudRow(const CloudError& error, const CloudError& start) {
  const auto percent = [](const CloudError& of) { return NumberText(100.0 * of.num_far / of.num_points, 3) + " %"; };
  std::string rows;
  if (error.num_tracked > 0.0) {
    rows = "surface         " + MillimetreText(error.rmse()) + " (nodes " + MillimetreText(error.node_rmse());
    if (error.num_border > 0.0) rows += ", border " + MillimetreText(error.border_rmse());
    rows += ")";
  } else {
    rows = "cloud           " + MillimetreText(error.rmse());
  }
  return rows + " from points to the surface (root mean square), at the start " + MillimetreText(start.rmse()) +
         "; farther than " + NumberText(kFarFromSurface, 2) + " sigma " + percent(error) + ", at the start " +
         percent(start) + "\n";
}

std::string ForceRow(const ForceError& error, const ForceError& start) {
  return "force           " + NumberText(error.rms(), 4) + " N (root mean square of a component), at the start " +
         NumberText(start.rms(), 4) + " N\n";
}

// Of positions, where any were measured, of clouds and of forces.
std::string ErrorRows(const FitSummary& summary) {
  const PredictionError &error = summary.error, &start = summary.start_error;
  std::ostringstream rows;
  if (std::isfinite(error.rmse())) {
    rows << "rmse            " << MillimetreText(error.rmse()) << " (" << error.rmse() << " m), at the start "
         << MillimetreText(start.rmse()) << "\n";
  }
  if (error.force.num_components > 0.0) rows << ForceRow(error.force, start.force);
  if (error.cloud.num_points > 0.0) rows << CloudRow(error.cloud, start.cloud);
  return rows.str();
}

std::string Interval(const FitSummary& summary, const FitChecks& checks, int index) {
  if (HasExcludedSide(summary, checks, index)) return RangeText(summary.uncertainty->parameters[index]);
  if (!HasInterval(summary, checks, index)) return "-";
  const ParameterUncertainty& uncertainty = summary.uncertainty->parameters[index];
  return IntervalText(summary.parameters[index].value, uncertainty.total_std(), uncertainty.lower95,
                      uncertainty.upper95);
}

// Of rollouts that the recordings correct, or why they were asked to and do not; else nothing.
std::string MemoryRow(const FitSummary& summary, const FitChecks& checks) {
  if (!summary.why_not_assimilated.empty()) {
    return "memory          none: " + summary.why_not_assimilated + ", and corrects no rollouts\n";
  }
  if (!summary.assimilation.is_on()) return {};
  std::string row = "memory          " + NumberText(summary.assimilation.memory, 3) +
                    " s of rollouts that the recordings correct: errors are those of predictions in between";
  if (checks.uncorrected_error) {
    row += "; of rollouts without corrections " + MillimetreText(checks.uncorrected_error->rmse());
  }
  return row + "\n";
}

std::string ModelErrorRow(const RecordingFit& recording, std::size_t num_recordings) {
  const std::string misses = ModelErrorText(recording.model_error);
  if (misses.empty()) return {};
  return "model misses    " + (num_recordings > 1 ? recording.name + ": " : std::string()) + misses +
         " (root mean square)\n";
}

std::string StartRow(const StartEstimate& start) {
  const auto with_std = [](double value, double std) {
    return NumberText(1e3 * value, 3) + " +- " + NumberText(1e3 * std, 3);
  };
  std::string row = "start           recording " + std::to_string(start.recording + 1) +
                    ": estimated, cloth moved by " + with_std(start.moved, start.position_std) + " mm";
  if (start.handle_std > 0.0) row += ", handles by " + with_std(start.handles_moved, start.handle_std) + " mm";
  if (start.velocity_std > 0.0) row += ", velocity by " + with_std(start.speed_change, start.velocity_std) + " mm/s";
  return row + " (root mean square of a coordinate)\n";
}

std::string WindRows(const WindResult& result) {
  std::string rows;
  for (const FittedWind& wind : result.winds) {
    const std::string recording = result.profiles.size() > 1 ? std::to_string(wind.recording + 1) + ": " : "";
    rows += "wind            " + recording + DescribeFittedWind(wind) + "\n";
  }
  if (result.smoothness > 0.0) {
    rows += "smoothness      " + NumberText(result.smoothness, 3) + " m/s in a second, " +
            SmoothnessWords(result.smoothness_source) + "\n";
  }
  return rows;
}

std::string PredictionName(std::size_t recording) {
  return recording == 0 ? "predicted.bin" : "predicted_" + std::to_string(recording + 1) + ".bin";
}

// The constants of the cloth for other simulators.
void WriteExports(const FitSummary& summary, const std::optional<Repetitions>& repetitions, const Scene& scene,
                  const FabricCard* card, const std::vector<std::string>& simulators, OutputFolder* folder) {
  if (simulators.empty()) return;
  ExportedEstimates estimates;
  for (const FittedParameter& parameter : summary.parameters) estimates.values[parameter.name] = parameter.value;
  if (repetitions) estimates.TakeMeans(*repetitions);
  for (const ExportedFile& file :
       ExportCloth(scene, ParametersOfEstimates(estimates.values, scene), simulators, estimates.remarks, card)) {
    folder->Write(file.name, file.text);
  }
}

// Of every recording where the nodes of its cloth are at the estimate [3N x T] m; empty where nobody knows.
std::vector<Eigen::MatrixXd> FittedNodes(const FitSummary& summary, const FitChecks& checks,
                                         const std::vector<RecordedMotion>& motions) {
  std::vector<Eigen::MatrixXd> nodes(motions.size());
  for (std::size_t r = 0; r < motions.size(); ++r) {
    const Eigen::MatrixXd& predicted = summary.predicted[r];
    const Eigen::Index num_rows = 3 * motions[r].scene.mesh.num_nodes();
    if (r < checks.predicted_nodes.size() && checks.predicted_nodes[r].size() > 0) {
      nodes[r] = checks.predicted_nodes[r];
    } else if (PointsAreNodes(motions[r]) || predicted.rows() == 3 * motions[r].num_points() + num_rows) {
      nodes[r] = predicted.bottomRows(num_rows);
    }
  }
  return nodes;
}

// All or none of them.
void WriteLargeFiles(const FitSummary& summary, const FitChecks& checks, const std::vector<RecordedMotion>& motions,
                     const std::string& card_page, OutputFolder* folder, const ReportOptions& options) {
  try {
    for (std::size_t r = 0; r < motions.size(); ++r) {
      const MotionTensors tensors = PredictedMotion(motions[r], summary.predicted[r], summary.parameters,
                                                    r < summary.forces.size() ? summary.forces[r] : Eigen::MatrixXd());
      WriteMotion(tensors, folder->TemporaryPath(PredictionName(r)));
    }
    if (!options.page) return;
    folder->Write(kCardPageName, card_page);
    folder->Write(kReportName, ReportHtml(summary, checks, motions));
  } catch (const Error&) {
    for (std::size_t r = 0; r < motions.size(); ++r) folder->Drop(PredictionName(r));
    folder->Drop(kCardPageName);
    folder->Drop(kReportName);
    throw;
  }
}

}  // namespace

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

std::string ProfileCsv(const FitSummary& summary, const FitChecks& checks) {
  std::ostringstream csv;
  csv << "parameter,value,cost_rise";
  for (const FittedParameter& parameter : summary.parameters) csv << "," << parameter.name;
  csv << "\n";
  for (const Profile& profile : checks.profiles) {
    for (const ProfilePoint& point : profile.points) {
      csv << profile.parameter << "," << ExactNumber(point.value) << "," << ExactNumber(point.cost_rise);
      for (const double value : point.values) csv << "," << ExactNumber(value);
      csv << "\n";
    }
  }
  return csv.str();
}

MotionTensors PredictedMotion(const RecordedMotion& motion, const Eigen::MatrixXd& predicted,
                              const std::vector<FittedParameter>& parameters, const Eigen::MatrixXd& forces) {
  MotionTensors tensors;
  tensors.times = motion.times;
  tensors.single_precision = false;
  tensors.mesh = motion.scene.mesh;
  SetPrediction(motion, predicted, &tensors);
  SetHandlePaths(motion.scene.handles, &tensors);
  tensors.sequences = SequencesOf(motion.scene);
  if (forces.cols() > 0) {
    tensors.forces = motion.forces;
    tensors.forces.values = forces;
  }
  tensors.scene_text = motion.scene_text;
  tensors.provenance = "predicted by identify " + Version() + " (git " + GitHash() +
                       ") for the recording with sha256 " + motion.sha256 + " at";
  for (const FittedParameter& parameter : parameters) {
    tensors.provenance += " " + parameter.name + "=" + ExactNumber(parameter.value);
  }
  return tensors;
}

bool IsReportFile(const std::string& name) {
  static constexpr std::array<std::string_view, 10> kNames = {
      "result.json", kFabricCardName, "convergence.csv",     "profile.csv",      "predicted.bin",
      kCardPageName, kReportName,     "field_k_stretch.npy", "field_k_bend.npy", "field_density.npy"};
  if (std::find(kNames.begin(), kNames.end(), name) != kNames.end() || IsExportedFile(name)) return true;
  static constexpr std::string_view kBegin = "predicted_", kEnd = ".bin";
  if (name.size() <= kBegin.size() + kEnd.size() || name.compare(0, kBegin.size(), kBegin) != 0) return false;
  const std::size_t end = name.size() - kEnd.size();
  return name.compare(end, kEnd.size(), kEnd) == 0 && name.find_first_not_of("0123456789", kBegin.size()) == end;
}

void WriteReport(const FitSummary& summary, const FitChecks& checks, const std::vector<RecordedMotion>& motions,
                 OutputFolder* folder, const ReportOptions& options) {
  folder->RemoveOthers(IsReportFile);
  folder->Write("result.json", ResultJson(summary, checks, motions));
  const std::vector<Eigen::MatrixXd> nodes = FittedNodes(summary, checks, motions);
  const FabricCard card = CardOfFit(summary, checks, motions, nodes);
  folder->Write(kFabricCardName, FabricCardJson(card));
  folder->Write("convergence.csv", ConvergenceCsv(summary));
  if (summary.fields) {
    for (const FittedField& field : summary.fields->fields) {
      folder->Write("field_" + field.request.name + ".npy", FieldValuesNpy(field.values));
    }
  }
  if (!checks.profiles.empty()) folder->Write("profile.csv", ProfileCsv(summary, checks));
  WriteExports(summary, checks.repetitions, motions.front().scene, &card, options.simulators, folder);
  try {
    WriteLargeFiles(summary, checks, motions, CardHtml(card, summary, motions, nodes), folder, options);
  } catch (const Error& error) {
    folder->KeepJournals();
    folder->Commit();
    throw Error(error.kind(), error.what() + std::string("; result.json is written, without predictions and report"));
  }
  folder->Commit();
}

void WritePooledReport(const FitSummary& summary, const FitChecks& checks, const Verdict& verdict, const Scene* scene,
                       const FabricCard* card, OutputFolder* folder, const ReportOptions& options) {
  folder->RemoveOthers(IsReportFile);
  folder->Write("result.json", PooledResultJson(summary, checks, verdict));
  if (card != nullptr) folder->Write(kFabricCardName, FabricCardJson(*card));
  if (scene != nullptr) WriteExports(summary, checks.repetitions, *scene, card, options.simulators, folder);
  if (card != nullptr && options.page) folder->Write(kCardPageName, CardHtml(*card, summary, {}, {}));
  if (options.page) folder->Write(kReportName, PooledHtml(summary, checks, verdict));
  folder->Commit();
}

std::string PooledTable(const FitChecks& checks, const Verdict& verdict) {
  std::string table = RepetitionRows(*checks.repetitions);
  for (const std::string& line : verdict.Lines()) table += "verdict         " + line + "\n";
  return table;
}

std::string ResultTable(const FitSummary& summary, const FitChecks& checks) {
  std::ostringstream table;
  const auto print_row = [&](const std::string& name, const std::string& estimate, const std::string& interval,
                             const std::string& start, const std::string& remark) {
    // Small negative numbers fill their column.
    table << std::left << std::setw(15) << name << ' ' << std::setw(13) << estimate << " " << std::setw(28) << interval
          << (remark.empty() ? start : start + "  " + remark) << "\n";
  };
  print_row("parameter", "estimate", "95 % interval", "start", "");
  for (int i = 0; i < static_cast<int>(summary.parameters.size()); ++i) {
    const FittedParameter& parameter = summary.parameters[i];
    if (checks.wind && IsWindKnot(parameter.id)) continue;
    print_row(parameter.name, NumberText(parameter.value, 8), Interval(summary, checks, i),
              NumberText(parameter.start, 6), ParameterRemark(summary, checks, i));
  }
  for (int i = 0; i < static_cast<int>(summary.parameters.size()); ++i) {
    const std::string prior = PriorRemark(summary, i);
    if (!prior.empty()) table << "prior           " << summary.parameters[i].name << " " << prior << "\n";
  }
  table << ErrorRows(summary);
  if (std::isfinite(summary.error.fit_percent())) {
    table << "fit             " << std::setprecision(5) << summary.error.fit_percent() << " %, at the start "
          << summary.start_error.fit_percent() << " % (0 %: no better than a cloth at rest)\n";
  }
  table << MemoryRow(summary, checks);
  if (!checks.lead_times.empty()) table << "predicts        " << LeadTimesText(checks.lead_times) << "\n";
  for (const RecordingFit& recording : checks.recordings) table << ModelErrorRow(recording, checks.recordings.size());
  for (const StartEstimate& start : summary.starts) table << StartRow(start);
  if (summary.fields) {
    for (const FittedField& field : summary.fields->fields) table << "field           " << DescribeField(field) << "\n";
  }
  if (checks.wind) table << WindRows(*checks.wind);
  if (checks.gradient_check) {
    table << "gradient check  adjoint against sensitivity " << std::setprecision(3)
          << checks.gradient_check->adjoint_vs_sensitivity << ", against central differences "
          << checks.gradient_check->adjoint_vs_fd << "\n";
  }
  if (checks.step_choice) table << "time step       " << StepChoiceText(*checks.step_choice) << "\n";
  table << "status          " << FitStatusName(summary.status) << " after " << summary.num_iterations()
        << " iterations, " << summary.statistics.rollouts - summary.lead.rollouts << " rollouts, "
        << summary.statistics.sweeps - summary.lead.sweeps << " sweeps";
  if (summary.lead.rollouts > 0) {
    table << "; before them " << summary.lead.rollouts << " rollouts, " << summary.lead.sweeps
          << " sweeps of the first frames";
  }
  table << "\n";
  if (summary.statistics.counts.substeps > 0) {
    table << "note            " << summary.statistics.counts.substeps
          << " substeps were taken: each makes the cost jump a little\n";
  }
  if (checks.repetitions) table << RepetitionRows(*checks.repetitions);
  if (checks.transfer) table << TransferRows(*checks.transfer);
  for (const std::string& line : Judge(summary, checks).Lines()) table << "verdict         " << line << "\n";
  return table.str();
}

}  // namespace clothid

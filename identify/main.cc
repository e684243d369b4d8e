// identify: binds the command line to the options of a fit and runs it.
#include <gflags/gflags.h>
#include <glog/logging.h>
#include <sys/ioctl.h>
#include <unistd.h>

#include <iostream>
#include <string>
#include <vector>

#include "identify/base/command_line.h"
#include "identify/base/options.h"
#include "identify/base/parallel_for.h"
#include "identify/base/progress.h"
#include "identify/base/version.h"
#include "identify/export/result_export.h"
#include "identify/fit/fit.h"
#include "identify/run.h"
#include "identify/run_flags.h"
#include "sim/base/error.h"
#include "sim/base/program.h"
#include "sim/base/text_file.h"

DEFINE_string(target, "", "recordings to fit, separated by commas");
DEFINE_string(scene, "", "scene.json to use instead of the one in each recording");
DEFINE_string(fabric, "", "kind of cloth whose measured constants stand in for those that the scene does not give");
DEFINE_string(fit, "", "parameters to fit; empty: mu, where there are obstacles, and k_stretch, or k_warp,k_weft");
DEFINE_string(each, "", "parameters to fit of which every recording has its own");
DEFINE_string(field, "", "constants that vary over the cloth, NAME:ROWSxCOLUMNS[,...]");
DEFINE_double(field_weight, 0.0, "weight of the smoothness of fields; 0: chosen by the marginal likelihood");
DEFINE_string(wind_profile, "", "knots of a wind that changes over the time of every recording, KNOTS[:AXES]");
DEFINE_double(wind_smoothness, 0.0, "how far the wind wanders, m/s in a second; 0: chosen by the marginal likelihood");
DEFINE_string(start, "", "starting values, NAME=VALUE[,...]");
DEFINE_string(lower, "", "lower bounds, NAME=VALUE[,...]");
DEFINE_string(upper, "", "upper bounds, NAME=VALUE[,...]");
DEFINE_string(prior, "", "what is believed of parameters beforehand, NAME=MEDIAN:FACTOR or NAME=MEAN:STD[,...]");
DEFINE_string(jacobian, "adjoint", "adjoint, sensitivity or numeric");
DEFINE_string(adjoint, "reduced", "how reverse sweeps solve their linear systems, METHOD[:THRESHOLD]");
DEFINE_string(precision, "adaptive", "adaptive or full");
DEFINE_string(loss, "none", "none, huber:A or cauchy:A");
DEFINE_string(sigma, "recorded", "standard deviation of a coordinate: recorded, auto or a number in m");
DEFINE_string(initial, "estimated",
              "where the cloth starts if the scene does not say: estimated, rest, moving, smoothed or first");
DEFINE_bool(check, true, "check the recordings before the fit, as motion check does");
DEFINE_bool(check_gradients, false, "compare adjoint, sensitivities and finite differences at the start");
DEFINE_int32(max_iterations, 50, "iterations before the fit counts as not converged");
DEFINE_int32(threads, 1, "recordings and fits side by side");
DEFINE_string(output, "clothid_result", "folder for the results");
DEFINE_int32(starts, 1, "number of starting points");
DEFINE_uint64(seed, 0, "seed of the starting points");
DEFINE_string(profile, "", "parameters whose profile likelihood is wanted");
DEFINE_string(landscape, "", "folders that `landscape` wrote, to show in report.html");
DEFINE_string(discretization, "", "what intervals are to count with besides noise: step, mesh or all");
DEFINE_string(time_step, "", "of the simulation, in s, or auto; empty: the scene's");
DEFINE_string(holdout, "", "recordings that are not fitted, to judge the estimates on");
DEFINE_string(holdout_frames, "", "frames A:B of every recording that are not fitted, to judge the estimates on");
DEFINE_string(horizon, "growing", "growing: fits of the first frames lead to the start; full: all frames at once");
DEFINE_bool(resume, false, "continue a fit that was killed: replays the evaluations journaled in --output");
DEFINE_bool(report, true, "write report.html");
DEFINE_string(export, "", "simulators for which the constants are written to --output");
DEFINE_string(result, "", "result.json of an earlier fit to --export");
DEFINE_double(step_tolerance, 0.0, "relative residual of a time step; 0: the scene's");

namespace clothid {
namespace {

constexpr char kHelp[] = R"(identify: fits friction and stiffness of cloth to recorded motion.

  identify --target FILE[,FILE...] [flags]

  --target FILES      motion.bin recordings, fitted jointly
  --scene FILE        scene.json to use instead of the one in each recording
  --fabric NAME       light, medium, heavy, knit or denim: measured constants in place of those that the scene does not
                      give, and bounds
  --fit NAMES         of mu, mu.OBSTACLE, k_stretch, k_bend, density, drag, damping (mu,k_stretch; k_stretch without
                      obstacles), where the scene has warp and weft of k_warp, k_weft, k_shear, k_poisson in place of
                      k_stretch and bend_warp, bend_weft, bend_twist in place of k_bend (mu,k_warp,k_weft), of the air
                      drag_normal, drag_tangential, added_mass, wind.x, .y, .z, gust.x, .y, .z, gust.frequency,
                      gust.phase, gust.wave.x, .., wind.shear.x, .. and wind.x.1, .. of a wind profile, size.x, size.y
                      (what the cloth at rest is larger by than the scene says), and of the parameters of a recording
                      itself:
                      time_offset  s, added to the recording's times to meet the clock of the scene and its handles
                      shift, turn  m and rad about the centroid of the measured points, added to the prediction to
                                   meet the recording: what its frame of reference is off (align: both)
                      v0           m/s, added to the velocity of every free node at the start
                      handle_shift m, added to the path of all handles: what the tool that moves them is off;
                                   handle_shift1, handle_shift2, .. of each group of handles by itself
                      handle_turn  rad, turns all handles about their middle at every time
                      force_bias   N, added to the predicted forces of the first group of handles, force_bias2 of the
                                   second: what a gauge is off at zero
                      each of the last six is x, y and z, as shift.x. predicted.bin is in the recording's frame
  --each NAMES        to fit as well, but one per recording: drag becomes drag@1, drag@2, ... in the order of --target
  --field LIST        constants that vary over the cloth, of k_stretch, k_bend and density, each on a control grid:
                      NAME:ROWSxCOLUMNS, as k_stretch:8x8. They are fitted with the parameters of --fit, among which
                      k_stretch is then the geometric mean over the cloth. Writes field_NAME.npy, which
                      `simulate --set_field` reads
  --field_weight W    of the smoothness of fields: W/2 times the integral of the squared Laplacian of the logarithm, the
                      control grid being a unit square; 0: chosen by the marginal likelihood (0)
  --wind_profile K[:AXES]  a wind that changes over time, piecewise linear between K knots evenly over each recording,
                      which has its own; from the wind of the scene. AXES: its components that change, as in 8:xy (xyz).
                      The wind is believed to change little from knot to knot
  --wind_smoothness S  by S sqrt(h) m/s (standard deviation) between knots h s apart, where residuals are as large as
                      sigma; 0: chosen by the marginal likelihood (0). Without --wind_profile: of fitted wind.x.1, ..
  --start LIST        starting values, NAME=VALUE[,...] (the scene's nominal values; of a recording's own parameters 0)
  --lower, --upper    bounds, NAME=VALUE[,...] (the scene's; else mu 0..2, time_offset +-2 frames, shift +-1/4 of the
                      cloth's size, turn +-0.2, v0 +-2, handle_shift +-1/10 of the size, handle_turn +-0.2,
                      force_bias +-the largest force, size.x and size.y a factor of 1.25, k_poisson +-sqrt(k_warp k_weft), drag and damping start/1e4..start*1e4, the others 100
                      times beyond what was measured of any cloth); drag is that of every recording, drag@2 goes
                      before it, shift stands for x, y and z
  --prior LIST        what is believed beforehand: NAME=MEDIAN:FACTOR[,...], as k_bend=1e-5:2, a normal distribution of
                      the logarithm; of mu, k_poisson and a recording's own parameters NAME=MEAN:STD, as mu=0.3:0.1.
                      It is one more residual, once for all recordings. The verdict says what they add to it.
                      Without: size 1:1.03, handle_shift 0:0.01, handle_turn 0:0.05, and nothing of all others
  --jacobian KIND     adjoint, sensitivity or numeric (adjoint)
  --adjoint HOW       linear systems of --jacobian adjoint: reduced, lu, fixed_point or gmres, with a
                      threshold as in gmres:1e-6 (reduced, the scene's adjoint_tolerance)
  --precision KIND    adaptive: points far from the solution are simulated loosely; full: none (adaptive)
  --loss LOSS         none, huber:A or cauchy:A per observed point, A in standard deviations (none). Where sigma is not
                      known, one is taken as 1e-3 of the cloth's size: see --sigma
  --sigma SIGMA       standard deviation of a measured coordinate: recorded: that of the recording, if it has one;
                      auto: where it has none, estimated from the scatter of its points in time; a number in m:
                      that of every point of every recording (recorded)
  --initial START     where the cloth starts if the scene does not say: rest, moving: that is estimated with the
                      parameters, the handles' places with it, released at rest or with a velocity of its own:
                      intervals count with what nobody knows of the start; estimated: moving, unless the first frames
                      show no velocity; smoothed: at a shape without noise, near the first frames and outside of
                      obstacles, with their velocity; first: at the first frame, noise and all (estimated)
  --check=false       fit without a look at the recordings: else what `motion check` warns of is told before the fit,
                      and what it calls a problem, such as mm for m, ends the run with exit code 2
  --check_gradients   compare adjoint, sensitivities and central differences at the start
  --max_iterations N  (50)
  --horizon KIND      growing: fits of the first eighth, quarter and half of the recordings lead to where the fit of all
                      of them starts, past minima that only whole motions have; full: all frames at once (growing)
  --threads N         recordings, and fits of --starts, side by side; what is left over shares the work of a rollout.
                      The result does not depend on it (1)
  --starts N          fit from N starting points: the own one and a Latin hypercube around it (1)
  --seed S            of the starting points (0)
  --profile NAMES     profile likelihood of these parameters: intervals of costs that are not quadratic
  --landscape DIRS    folders that `landscape` wrote of a recording of --target, over two parameters of the fit:
                      report.html shows them as maps, with the estimate and the way to it
  --discretization PARTS  step: fit again at half and twice the time step; mesh: fit again on a mesh of twice the
                      density; all: both. Intervals are widened by the errors that this shows, and the verdict says
                      what is the largest: noise, time step or mesh
  --time_step H       of the simulation, in s (the scene's); auto: from the scene's to the coarsest whose error is at
                      most the standard deviation that noise leaves of each estimate, with its error in the intervals
  --holdout FILES     recordings that are not fitted: their error at the estimates and at the nominal parameters; of
                      --each they take none, their own parameters stay nominal and those of a recording zero
  --holdout_frames A:B  the same for frames A to B - 1 of every recording
  --step_tolerance X  relative residual of a time step (the scene's)
  --resume            continue a fit that was killed, ending in the same bytes: keeps a journal in DIR while it runs
  --output DIR        result.json, convergence.csv, predicted.bin, profile.csv, report.html (clothid_result)
  --export LIST       mujoco, newton, arcsim, blender, ppf or all: writes the constants to DIR for these simulators, as
                      export_mujoco.xml and the like, with formula, unit and source, and what does not map
  --result FILE       no fit: exports the estimates of this result.json for the cloth of --target, or of the
                      predicted.bin beside it
  --report=false      no report.html, a page that any browser shows, with a 3D replay
  -h, --help; --version

Lists may be given in parts: --fit mu --fit k_stretch.

Ctrl-C saves the best point so far. Exit codes: 0 fitted; 1 usage, or a file that cannot be opened or written;
2 bad data; 3 not converged; 4 a parameter is not identifiable, hardly told, or at its bound; 5 the estimates predict
what was held out worse than the nominal parameters; 6 no estimate must be used: the error is of the size of the cloth
or larger than the motion, the start is elsewhere, or the fit passed by a lower point; 70 internal error;
130 interrupted. Where several apply: 70, 130, 1, 2, 3, 6, 4, 5.

Example:
  identify --target datasets/drape.motion.bin --fit mu,k_stretch --output /tmp/drape
)";

const ListFlags kLists = {{"target", ','},  {"fit", ','},       {"field", ','},   {"each", ','},
                          {"start", ','},   {"lower", ','},     {"upper", ','},   {"prior", ','},
                          {"profile", ','}, {"landscape", ','}, {"holdout", ','}, {"export", ','}};

RunFlags FlagsOfCommandLine() {
  RunFlags flags;
  flags.target = FLAGS_target;
  flags.scene = FLAGS_scene;
  flags.fabric = FLAGS_fabric;
  flags.fit = FLAGS_fit;
  flags.each = FLAGS_each;
  flags.field = FLAGS_field;
  flags.field_weight = FLAGS_field_weight;
  flags.wind_profile = FLAGS_wind_profile;
  flags.wind_smoothness = FLAGS_wind_smoothness;
  flags.start = FLAGS_start;
  flags.lower = FLAGS_lower;
  flags.upper = FLAGS_upper;
  flags.prior = FLAGS_prior;
  flags.jacobian = FLAGS_jacobian;
  flags.adjoint = FLAGS_adjoint;
  flags.precision = FLAGS_precision;
  flags.loss = FLAGS_loss;
  flags.sigma = FLAGS_sigma;
  flags.initial = FLAGS_initial;
  flags.check = FLAGS_check;
  flags.check_gradients = FLAGS_check_gradients;
  flags.max_iterations = FLAGS_max_iterations;
  flags.threads = FLAGS_threads;
  flags.output = FLAGS_output;
  flags.starts = FLAGS_starts;
  flags.seed = FLAGS_seed;
  flags.profile = FLAGS_profile;
  flags.landscape = FLAGS_landscape;
  flags.discretization = FLAGS_discretization;
  flags.time_step = FLAGS_time_step;
  flags.holdout = FLAGS_holdout;
  flags.holdout_frames = FLAGS_holdout_frames;
  flags.horizon = FLAGS_horizon;
  flags.exports = FLAGS_export;
  flags.resume = FLAGS_resume;
  flags.report = FLAGS_report;
  flags.step_tolerance = FLAGS_step_tolerance;
  return flags;
}

RunOptions OptionsFromFlags(const std::string& command_line) {
  if (FLAGS_target.empty()) throw Error(ErrorKind::kUsage, "--target: expected a recording; see identify --help");
  if (FLAGS_output.empty()) throw Error(ErrorKind::kUsage, "--output: expected a folder");
  RunOptions options = ParseRunFlags(FlagsOfCommandLine());
  options.command_line = command_line;
  return options;
}

std::string CommandLine(int argc, char** argv) {
  std::string line;
  for (int i = 1; i < argc; ++i) line += (i > 1 ? " " : "") + std::string(argv[i]);
  return line;
}

// 0 where stderr is no terminal.
int TerminalColumns() {
  winsize size = {};
  return ::ioctl(STDERR_FILENO, TIOCGWINSZ, &size) == 0 ? size.ws_col : 0;
}

// Has the run tell on stderr where it stands.
void ShowProgress(ProgressPrinter* printer, std::vector<std::string>* names, RunOptions* options) {
  options->on_finding = [](const std::string& recording, const Finding& finding) {
    std::cerr << "identify: " << recording << ": warning: " << finding.what << ": " << finding.value << "; "
              << finding.hint << "\n";
  };
  options->on_problem = [names](const std::vector<std::string>& of_problem) { *names = of_problem; };
  options->fit.on_progress = [printer](const EvaluationProgress& progress) { printer->Print(progress); };
  options->fit.on_iteration = [printer, names](const FitIteration& iteration) { printer->Print(*names, iteration); };
  options->fit.on_start = [printer, num_starts = options->fit.num_starts](int start) {
    printer->PrintStart(start, num_starts);
  };
  options->on_fitted = [printer](const FitSummary&) { printer->EndFit(); };
  options->on_examined = [printer](const FitSummary& summary) {
    printer->EndFit();
    if (summary.status != FitStatus::kConverged) std::cerr << "identify: " << summary.message << "\n";
  };
}

int IdentifyFromFlags(const std::vector<std::string>& arguments, const std::string& command_line) {
  if (!arguments.empty()) {
    throw Error(ErrorKind::kUsage, "'" + Printable(arguments.front()) + "': expected flags only; see identify --help");
  }
  if (!FLAGS_result.empty()) {
    ExportResult(FLAGS_result, FLAGS_target, FLAGS_export, FLAGS_output);
    return kExitSuccess;
  }
  RunOptions options = OptionsFromFlags(command_line);
  options.fit.cancel = &CatchInterrupts();
  ProgressPrinter printer(&std::cerr, isatty(STDERR_FILENO) != 0, options.fit.max_iterations, {}, TerminalColumns);
  std::vector<std::string> names;
  ShowProgress(&printer, &names, &options);
  int output_code = kExitSuccess;
  options.on_table = [&output_code](const std::string& table) {
    std::cout << table;
    output_code = FinishOutput("identify", kExitSuccess);
    std::cout.clear();  // that was told
  };
  const ExitCode exit_code = Identify(options).exit_code;
  return output_code == kExitSuccess || exit_code == kExitInterrupted ? exit_code : output_code;
}

}  // namespace
}  // namespace clothid

int main(int argc, char** argv) {
  // Ceres logs through glog: to stderr, and only what is fatal unless -v asks for more.
  FLAGS_logtostderr = true;
  FLAGS_minloglevel = google::GLOG_FATAL;
  const std::string version = "identify (clothid) " + clothid::Version() + " git " + clothid::GitHash();
  return clothid::RunCommandLine({"identify", clothid::kHelp, version, clothid::kLists}, argc, argv,
                                 [&](const std::vector<std::string>& arguments) {
                                   if (FLAGS_v > 0) FLAGS_minloglevel = google::GLOG_INFO;
                                   google::InitGoogleLogging(argv[0]);
                                   return clothid::IdentifyFromFlags(arguments, clothid::CommandLine(argc, argv));
                                 });
}

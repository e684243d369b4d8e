// What `benchmark --help` prints, and what it says of each mode.
#ifndef CLOTHID_TOOLS_BENCHMARK_BENCHMARK_HELP_H_
#define CLOTHID_TOOLS_BENCHMARK_BENCHMARK_HELP_H_

namespace clothid {

inline constexpr char kBenchmarkHelp[] = R"(benchmark: accuracy, cost and time of the methods against each other.

  benchmark jacobian  --scene FILE --set LIST   fits with each kind of Jacobian
  benchmark coverage  --scene FILE --set LIST   how often intervals are right
  benchmark fields    --scene FILE              fits of constants that vary
  benchmark forward                             the time of a step
  benchmark backprop                            the time of a reverse sweep
  benchmark accuracy                            error against run time
  benchmark stability                           where simulation fails

Everyday flags, each of those modes that `benchmark --help all` lists:
  --scene FILE    scene.json; of forward and below names, as wind,slope
  --set LIST      the fitted parameters and their true values, NAME=VALUE[,...]
  --nodes LIST    nodes along an axis of the meshes
  --settings LIST what is varied: see each mode
  --methods LIST  those to compare (all)
  --repeats N     repetitions, of which tables give medians (3)
  --seed S        of the noise (1)
  --threads N     fits or cells side by side; only seconds depend on it (1)
  --output DIR    writes MODE.csv there, one row per fit, sweep or cell
  --help, --version

Example:
  benchmark forward --scene wind,sphere --nodes 24,48
)";

inline constexpr char kJacobianHelp[] =
    R"(benchmark jacobian: fits two parameters to a synthetic recording, without and with noise, from a grid of starts
(friction 0.02 to 0.58, others 0.1 to 10 times the truth) with each method. Prints how many fits reached the minimum,
rollouts, sweeps, failed steps, processor seconds (medians), and these relative to `sensitivity`.

  --scene FILE      scene.json; parameters that are not set have its nominal values
  --set LIST        two parameters and their true values, NAME=VALUE,NAME=VALUE
  --noise SHARE     standard deviation of noise relative to the cloth's size; 0: none (0.01)
  --starts N        N x N starts, N even (4)
  --methods LIST    of adjoint, sensitivity, numeric (all); the linear solver of the first can be added as in
                    adjoint:fixed_point:1e-4, see identify --adjoint
  --precision KIND  of the fits: adaptive or full; see identify --help (adaptive)
  --seed S          of the noise (1)
  --threads N       fits side by side (1)
  --output DIR      jacobian.csv, one row per fit
)";

inline constexpr char kCoverageHelp[] =
    R"(benchmark coverage: fits recordings that differ by their noise and prints how many 95 % intervals contain the truth, and
the reported standard deviation beside that of the estimates. With --sensor the truth is simulated on a grid of twice
the density at a quarter of the time step, seen by that camera and gripper, imported, checked, and fitted together with
the clock, which is 10 ms off. With --initial rest and others the fits do not know the scene's start, and the table
also gives: fits without an interval (refused), the mean error over the reported standard deviation, that over the one
that it would be if the start were known, and rollouts per fit.

  --scene FILE, --set LIST, --seed S (of the first recording), --threads N  as of jacobian
  --settings LIST   full: every point in every frame; half: half of the points missing; third: every third frame; with
                    --sensor: clean: without its faults; faults: with them; outliers: with 5 % of the points far off;
                    huber: the same and the loss huber:2; markers: 5 % of the nodes seen (all)
  --seeds N         recordings per setting (40)
  --noise SHARE     as of jacobian; --sigma M: the same in m
  --start_factor X  the fits start from the true values times this (1.05)
  --frame_rate HZ   frames per second; `third` has a third of them (one per step)
  --markers N       free nodes seen, other ones with every seed; not with --initial first; 0: all nodes (0)
  --initial START   what fits start from: scene (its own start), or first, smoothed, rest, moving as in identify --help;
                    rest is true of a scene that starts at rest, without --cut (scene)
  --cut SECONDS     the recording begins so much after the scene's start, in motion (0)
  --handle_sigma M  standard deviation of noise in m on the path of handles that move (0)
  --truth_steps N   steps of the truth per step of the scene (1)
  --truth_levels N  so often the mesh of the truth is refined, every time to twice the density (0)
  --discretization PARTS  the intervals count with the errors of step, mesh or all, see identify --help
  --field NAME:RxC[,...]  the fits have fields for unknowns; the truth is that of the scene's `fields`
  --wind_profile N[:AXES] and a wind that changes, of N knots; the truth is that of the scene's wind.profile
  --force_sigma N   a gauge holds the handles, with this standard deviation of noise in N
  --sensor FILE     sensor.json (datasets/README.md)
  --output DIR      coverage.csv, one row per fit
)";

inline constexpr char kFieldsHelp[] =
    R"(benchmark fields: fits a k_stretch that varies over the cloth by a factor of 2 or so. Prints the error of log k over all
control nodes, the share of those that the verdict calls determined and their error, iterations, rollouts, sweeps,
processor seconds, those of an iteration without the standard deviations at the end, and what a Jacobian by differences
takes.

  --scene FILE      scene.json with a grid
  --set k_stretch=K the level of the truth, N/m (70)
  --nodes N         along the first axis of the grid (24)
  --settings LIST   nodes a side of the control grids (4,8,16,32)
  --sigma M         standard deviation of noise, m (0.001)
  --seed S          of field and noise (1)
  --output DIR      fields.csv, one row per fit
)";

inline constexpr char kForwardHelp[] =
    R"(benchmark forward: simulates scenes on square grids and prints the time of a step and its phases, the factorisation beside
its floating-point operations at the speed of dgemm, the growth with the number of nodes, and the memory of a rollout
per node and step. Processor time.

  --scene LIST      of wind, slope, sphere (wind,slope)
  --integrator LIST of euler, sdirk2 (both)
  --nodes LIST      along both axes (12,24,48)
  --steps N         steps of a rollout (100)
  --repeats N       repetitions, of which the table gives medians (3)
  --output DIR      forward.csv, one row per scene, size and integrator
)";

inline constexpr char kBackpropHelp[] =
    R"(benchmark backprop: the reverse sweep by each of its linear solvers on the same rollouts. Prints processor time per step
and its parts, iterations, steps in which LU stepped in, the largest error of the gradient against LU, and how many
times faster than LU; 8 right-hand sides relative to one; relative to the rollout.

  --scene LIST      of wind, slope, sphere (all)
  --settings LIST   soft: k = 20 N/m, steps of 5 ms; realistic: 1000 N/m, 10 ms; stiff: 1e5 N/m, 5 ms (soft,realistic)
  --nodes LIST      along both axes (12,24,48)
  --steps N         that are differentiated (20 on 12 x 12 nodes, down to 4)
  --methods LIST    of umfpack, fixed_point:1e-4, fixed_point:1e-6, gmres:1e-4, gmres:1e-6, reduced, kept: reduced, with
                    the factors that the rollout kept (all)
  --repeats N       repetitions, of which the table gives medians (3)
  --output DIR      backprop.csv, one row per case, method and repetition
)";

inline constexpr char kAccuracyHelp[] =
    R"(benchmark accuracy: error against run time, on the scenes of backprop. Trajectories over time step and step tolerance
against SDIRK2 at h/64 on the same mesh and on one of twice the density; gradients over the linear solver of the reverse
sweep and its threshold. Prints errors and ms.

  --scene LIST, --settings LIST  as of backprop (all)
  --quantities LIST of forward, gradient (all)
  --integrator LIST of the trajectories, of euler, sdirk2 (both)
  --nodes N         along both axes (17)
  --repeats N       repetitions, of which the table gives medians (3)
  --output DIR      accuracy.csv, one row per point, which tools/plots/plot_accuracy draws
)";

inline constexpr char kStabilityHelp[] =
    R"(benchmark stability: where the simulation fails or gains energy: a cloth dropped on a sphere, on one
that moves and turns, on a slope, folded on itself, in a gusty wind for 0.3 s, and extreme scenes one at a time. Every
solve is evaluated again from what the rollout recorded: one that does not meet its tolerance or the contact law
although it says so is a silent failure. A cloth that meets itself is looked at after every step: triangles that cut
each other, and how near its parts come.

  --settings LIST   of grid, extremes, and names of extremes (grid,extremes)
  --scene LIST      of drape, push, slope, fold, wind (all)
  --integrator LIST of euler, sdirk2 (both)
  --contact LIST    of gap, velocity (both); fold has gap alone
  --k_stretch LIST  stretch stiffness, N/m (1,10,..,1e7)
  --steps LIST      per second (1000,200,60,30)
  --mu LIST         friction coefficients (0,0.1,0.35,0.8,2); of fold mu.self
  --nodes N         along both axes (12)
  --threads N       cells side by side (1)
  --output DIR      stability.csv, one row per cell, which tools/plots/plot_stability draws, and extreme
)";

// Beyond that of the modes.
inline constexpr char kBenchmarkMore[] =
    R"(Exit codes: 0 done, whatever the table says; 1 usage, or a file that cannot be opened or written; 2 bad content;
70 internal error; 130 interrupted.
)";

}  // namespace clothid

#endif  // CLOTHID_TOOLS_BENCHMARK_BENCHMARK_HELP_H_

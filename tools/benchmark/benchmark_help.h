// What `benchmark --help` prints, and what it says of each mode.
#ifndef CLOTHID_TOOLS_BENCHMARK_BENCHMARK_HELP_H_
#define CLOTHID_TOOLS_BENCHMARK_BENCHMARK_HELP_H_

namespace clothid {

inline constexpr char kBenchmarkHelp[] =
    R"(benchmark: accuracy, time and stability of the simulation and its derivatives.

  benchmark forward      the time of a step
  benchmark backprop     the time of a reverse sweep
  benchmark accuracy     error against run time
  benchmark stability    where simulation fails

Everyday flags, each of those modes that `benchmark --help all` lists:
  --scene LIST    names of scenes, as wind,slope
  --nodes LIST    nodes along an axis of the meshes
  --settings LIST what is varied: see each mode
  --methods LIST  those to compare (all)
  --repeats N     repetitions, of which tables give medians (3)
  --output DIR    writes MODE.csv there, one row per sweep, point or cell
  --help, --version

Example:
  benchmark forward --scene wind,sphere --nodes 24,48
)";

inline constexpr char kForwardHelp[] =
    R"(benchmark forward: simulates scenes on square grids and prints the time of a step and its phases, the factorisation beside
its floating-point operations at the speed of dgemm, the growth with the number of nodes, and the memory of a rollout
per node and step. Processor time.

  --scene LIST      of wind, slope, sphere, fold, fold_through: the same
                    without contact of the cloth with itself (wind,slope)
  --integrator LIST of euler, sdirk2 (both)
  --nodes LIST      along both axes (12,24,48)
  --steps N         steps of a rollout; all of a fold are 240 (100)
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
  --stiffening S    the grid with a membrane of yarns that stiffen by S: k_warp and
                    k_weft are k_stretch, k_shear is half of it (0: isotropic)
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

#include "tools/benchmark/benchmark_help.h"

namespace clothid {

const char kBenchmarkHelp[] = R"(benchmark: accuracy, cost and time of the methods against each other.

  benchmark jacobian       --scene FILE --set LIST [--noise] [--starts] [--methods] [--precision] [--seed] [--threads]
                           [--output]
  benchmark coverage       --scene FILE --set LIST [--sensor] [--initial] [--cut] [--seeds] [--settings] [--noise]
                           [--sigma] [--frame_rate] [--markers] [--start_factor] [--seed] [--threads] [--output]
  benchmark fields         --scene FILE [--set] [--nodes] [--settings] [--sigma] [--seed] [--output]
  benchmark forward        [--scene LIST] [--integrator] [--bending] [--nodes] [--steps] [--repeats] [--output]
  benchmark backprop       [--scene] [--settings] [--nodes] [--steps] [--methods] [--repeats] [--output]
  benchmark accuracy       [--scene] [--settings] [--quantities] [--integrator] [--nodes] [--repeats] [--output]
  benchmark stability      [--settings] [--scene LIST] [--integrator] [--contact] [--k_stretch] [--steps] [--mu] [--nodes]
                           [--nogradients] [--seed] [--threads] [--output]

jacobian: fits two parameters to a synthetic recording, without and with noise, from a grid of starts (friction 0.02 to
0.58, others 0.1 to 10 times the truth) with each method, and prints how many fits reached the minimum, rollouts, sweeps,
failed steps, processor seconds (medians), and these relative to `sensitivity` (median over the starts).

coverage: fits recordings that differ by their noise and prints how many 95 % intervals contain the truth, and the
reported standard deviation beside that of the estimates: with every point in every frame (full), with half the points
missing (half), with every third frame (third). With --sensor the truth is simulated on a grid of twice the density at a
quarter of the time step and seen by that camera and gripper, imported, checked, and fitted together with the clock, which
is 10 ms off: without the sensor's faults (clean), with them (faults), with 5 % of the points far off and the loss huber:2
(huber), the same without a loss (outliers), with 5 % of the nodes seen, as markers (markers). With --initial rest and
others the fits do not know the scene's start, as of a recording that was imported (see identify --help), and the table
also gives: fits without an interval (refused), the mean error over the reported standard deviation, that over the one
that it would be if the start were known, and rollouts per fit.

fields: fits a k_stretch that varies over the cloth by a factor of 2 or so about --set k_stretch (70 N/m), with noise of
--sigma (1 mm), on control grids of --settings nodes a side (4, 8, 16, 32). Prints the error of log k over all control nodes, the share of
those that the verdict calls determined and their error, iterations, rollouts, sweeps, processor seconds, those of an
iteration without the standard deviations at the end, and what a Jacobian by differences takes.

forward: simulates the scenes wind, slope and sphere on square grids with either integrator and prints the time of a step and its phases, the
factorisation beside its floating-point operations at the speed of dgemm, the growth with the number of nodes, and the
memory of a rollout per node and step. Processor time, medians over the repeats.

backprop: the reverse sweep by each of its linear solvers on the same rollouts of a cloth in the wind, on a slope, on a
sphere, with k = 20 N/m and steps of 5 ms (soft) and with 1000 N/m and 10 ms (realistic): processor time per step and its
parts, iterations, steps in which LU stepped in, the largest error of the gradient against LU, and how many times faster
than the direct solvers; 8 right-hand sides relative to one; relative to the rollout.

accuracy: error against run time. Trajectories over time step and step tolerance, with either integrator, against SDIRK2 at
h/64 on the same mesh and on one of twice the density, and over the mesh; gradients over the
linear solver of the reverse sweep and its threshold, and over the step tolerance; fits, iteration by iteration, with
each Jacobian. On the scenes of `backprop`, from soft to stiff (k = 1e5 N/m). Prints the curves and what is cheapest for
an error of at most 0.1, 0.01, ..; tools/plots/plot_accuracy draws curve.csv.

stability: where the simulation fails, gains energy or has a wrong gradient: a cloth dropped on a sphere, on a slope, in
a gusty wind for 0.3 s over integrator, stiffness, time step, friction and contact mode (the wind, without an obstacle,
without the last two), and extreme scenes one at a time. Every solve is evaluated again from what the rollout
recorded: one that does not meet its tolerance, the contact law or the balance of energy although it says so is a silent
failure. Gradients of the adjoint sweep beside central differences where both sides take the same contact branches and
the differences settle. tools/plots/plot_stability draws its CSV.

  --scene FILE      scene.json; parameters that are not set have its nominal values
                    forward: of wind, slope, sphere (wind,slope); backprop, accuracy: likewise
                    (all); stability: of drape, slope, wind (all)
  --set LIST        the parameters to fit (jacobian: two) and their true values, NAME=VALUE[,...]
  --noise SHARE     standard deviation of noise relative to the cloth's size; jacobian: 0 for none (0.01)
  --sigma M         coverage: standard deviation of noise in m, in place of --noise
  --initial START   coverage: what fits start from: scene (its own start), or first, smoothed, rest, moving as in
                    identify --help; rest is true of a scene that starts at rest, without --cut (scene)
  --cut SECONDS     coverage: the recording begins so much after the scene's start, in motion (0)
  --handle_sigma M  coverage: standard deviation of noise in m on the path of handles that move (0)
  --frame_rate HZ   coverage: frames per second; `third` has a third of them (one per step)
  --markers N       coverage: free nodes seen, other ones with every seed; not with --initial first; 0: all nodes (0)
  --truth_steps N   coverage: steps of the truth per step of the scene (1)
  --truth_levels N  coverage: so often the mesh of the truth is refined, every time to twice the density (0)
  --discretization PARTS  coverage: the intervals count with the errors of step, mesh or all, see identify --help
  --start_factor X  coverage: the fits start from the true values times this (1.05)
  --starts N        N x N starts, N even (4)
  --methods LIST    (all) jacobian: of adjoint, sensitivity, numeric; the linear solver of the first can be added as in adjoint:fixed_point:1e-4, see identify --adjoint
                    backprop: of umfpack, fixed_point:1e-4, fixed_point:1e-6, gmres:1e-4, gmres:1e-6, reduced,
                    kept (reduced, with the factors that the rollout kept)
  --precision KIND  of the fits: adaptive or full; see identify --help (adaptive)
  --seed S          of the noise; coverage: the first; stability: of the scalars whose
                    gradients are checked (1)
  --nodes LIST      forward, backprop: nodes along both axes (12,24,48); fields: one number, along the first axis (24);
                    accuracy: one of 5, 9, 13, .. (17); stability: one number (12)
  --steps LIST      forward: the number of steps (100); backprop: likewise (20 on 12 x 12 nodes, down to 4);
                    stability: steps per second (1000,200,60,30)
  --repeats N       repetitions, of which the table gives medians (3)
  --seeds N         recordings per setting (40)
  --sensor FILE     sensor.json (datasets/README.md)
  --settings LIST   of full, half, third, with --sensor of clean, faults, huber, outliers, markers (all);
                    backprop: of soft, realistic, stiff (soft,realistic); accuracy: likewise (all); stability: of grid, extremes, and names of extremes (grid,extremes)
  --quantities LIST of forward, gradient, fit (all)
  --contact LIST    of gap, velocity (both)
  --bending LIST    forward: laws of bending with their k_bend in N m that take turns, of edges:K_BEND and
                    patches:K_BEND (the scenes' own)
  --integrator LIST of euler, sdirk2 (both)
  --k_stretch LIST  stretch stiffness, N/m (1,10,..,1e7)
  --mu LIST         friction coefficients (0,0.1,0.35,0.8,2)
  --nogradients     leaves out the check of gradients, most of the time
  --threads N       fits or cells side by side; only the seconds depend on it (1)
  --output DIR      writes COMMAND.csv, one row per fit, sweep, or scene and size; accuracy: curve.csv, one per point;
                    stability: one per cell, and stability_extremes.csv
  --help, --version

Exit codes: 0 done, whatever the table says; 1 usage, or a file that cannot be opened or written; 2 bad content;
70 internal error; 130 interrupted.

Examples:
  benchmark jacobian --scene datasets/drape.scene.json --set mu=0.3,k_stretch=100 --output /tmp/jacobian
  benchmark coverage --scene datasets/drape.scene.json --set mu=0.24,k_stretch=70 --threads 2
  benchmark coverage --scene datasets/drape.scene.json --set mu=0.24,k_stretch=70 --settings full \
      --initial rest --frame_rate 30 --sigma 0.002 --start_factor 1.5 --seeds 6
  benchmark forward --nodes 24,48,96,192 --steps 10
  benchmark backprop --scene wind,slope --nodes 48 --output /tmp/backprop
  benchmark accuracy --scene sphere --settings realistic --output /tmp/accuracy
  benchmark stability --scene drape --contact gap --k_stretch 1e4,1e5 --mu 0.35 --output /tmp/stability
)";

}  // namespace clothid

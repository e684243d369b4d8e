// What `simulate --help` prints, and `simulate --help all` after it.
#ifndef CLOTHID_TOOLS_SIMULATE_SIMULATE_HELP_H_
#define CLOTHID_TOOLS_SIMULATE_SIMULATE_HELP_H_

namespace clothid {

inline constexpr char kHelp[] = R"(simulate: makes a recording with known parameters from a scene.

  simulate --scene FILE --output FILE [flags]

  --scene FILE       scene.json (every key: datasets/scene.md)
  --output FILE      motion.bin to write, a name that ends in .bin
  --view FILE        a page that replays it, as `motion view` writes it, a
                     name that ends in .html
  --fabric NAME      light, medium, heavy, knit or denim: measured constants in
                     place of those that the scene does not give. The
                     recording's scene names it. Or the fabric.json of a fit:
                     the constants of that cloth, in place of the scene's
  --set LIST         true parameters in place of the scene's, as
                     mu=0.3,k_stretch=300; written nowhere in the recording
  --noise SIGMA      Gaussian noise on every coordinate, standard deviation
                     in m (0)
  --frame_rate HZ    frames per second; 0: one per time step (0)
  --drop FRACTION    chance of a point to be missing in a frame, [0, 1) (0)
  --markers N        N free nodes are seen, chosen by the seed; 0: all of
                     them (0)
  --cloud N          an unordered cloud of N points per frame anywhere on the
                     surface is seen in place of the nodes; with --markers,
                     both (0)
  --forces           the forces at the handles, too: those on the cloth, as a
                     sensor at the gripper tells them
  --force_sigma S    Gaussian noise on every component of them, standard
                     deviation, N (0)
  --result FILE      the result.json of a fit predicts this motion, with bands:
                     see --help all
  --seed S           of markers, noise, drops, clouds, forces and draws (1)
  --threads N        that share the work of a step, a gain from some thousand
                     nodes on; the motion does not depend on it (1)
  --help all         every flag, the names of parameters, exit codes
  --version

Example:
  simulate --scene datasets/drape.scene.json --set mu=0.3,k_stretch=300 \
    --noise 0.001 --output /tmp/drape.motion.bin
)";

inline constexpr char kMoreHelp[] = R"(
The truth:
  --set LIST         names: mu, mu.OBSTACLE, k_stretch, k_bend, density, drag, damping; where the scene has warp and
                     weft k_warp, k_weft, k_shear, k_poisson, stiffening_warp, stiffening_weft, bend_warp, bend_weft,
                     bend_twist; drag_normal,
                     drag_tangential, added_mass, pressure, size.x, size.y, wind.x and the like (costs/README.md)
  --set_field LIST   likewise, constants that vary over the cloth, NAME=FILE.npy of stiffnesses and density: their
                     values on a control grid, as `identify --field` writes them (field_NAME.npy)

The recording:
  --float32          positions in single precision: half the size, truth recoverable to about 1e-7 m
  --force_rate HZ    readings per second; 0: one per frame (0)
  --force_bias X,Y,Z what every sensor is off by, N (0,0,0)
  --force_nodes LIST the handles that each sensor holds, as in 0,1:4,5 (all of them one sensor)

A prediction:
  --result FILE      rollouts with parameters drawn from what a fit knows of them, with the force that its model lacks,
                     the error of step and mesh, and what starts and handles were off by; --output gets their median.
                     With --scene, --output, --view, --fabric, --frame_rate, --seed and --threads, which run rollouts
                     side by side
  --draws N          so many rollouts (50)
  --sources LIST     what spreads them beside parameters (force,step,mesh,start,handles); parameters: nothing
  --of LIST          bands of what else comes of it: point:NODE, area (m^2, covered, seen from above), strain (the
                     largest), force (N, of every gripper on the cloth), slip (s, when it begins)
  --view FILE        the page shows cloths that may be, bands over time and what dominates them
  --bands FILE       the quantiles 5, 25, 50, 75 and 95 % of every node and time, bands.npz for NumPy
  --keep_draws       .. and all rollouts, which tell how much of a motion right bands hold (clothid.leave_one_out)

  simulate --scene other.scene.json --result fit/result.json --bands bands.npz --output predicted.bin

A laboratory:
  --sensor FILE      writes what its camera would have seen instead of a recording: the cloth simulated on a grid of
                     twice the density at a quarter of the time step, with the frames, noise, faults, clock and frame of
                     reference of sensor.json (datasets/README.md). The name of --output gives the format, as for
                     `motion convert`. Without the flags above but --scene, --output, --set and --seed
  --handles_output F the path of the handles as the gripper tells it, CSV
  --forces_output F  the forces on the handles as their sensor tells them, CSV

  simulate --scene datasets/capture/scene.json --sensor datasets/capture/sensor.json --set mu=0.3,k_stretch=30 \
    --output /tmp/points.csv --handles_output /tmp/gripper.csv

Exit codes: 0 written; 1 usage, or a file that cannot be opened or written; 2 bad content; 3 a time step did not
converge, 70 internal error, 130 interrupted: nothing is written.
)";

}  // namespace clothid

#endif  // CLOTHID_TOOLS_SIMULATE_SIMULATE_HELP_H_

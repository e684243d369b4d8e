// What `identify --help` prints, and `identify --help all` after it.
#ifndef CLOTHID_IDENTIFY_HELP_H_
#define CLOTHID_IDENTIFY_HELP_H_

namespace clothid {

inline constexpr char kHelp[] = R"(identify: fits friction and stiffness of cloth to recorded motion.

  identify --target FILE[,FILE...] [flags]

  --target FILES      recordings (motion.bin), fitted jointly
  --repeat            they repeat one experiment: their scatter, their mean, the
                      next specimen
  --transfer          each is fitted alone, too: how well it predicts the others
  --scene FILE        scene.json to use instead of the one in each recording
  --fabric NAME       light, medium, heavy, knit or denim: measured constants in
                      place of those that the scene does not give, and bounds;
                      or the fabric.json of a fit: constants and priors
  --fit NAMES         parameters, as mu, k_stretch, k_bend, density, drag (mu
                      and k_stretch; without obstacles, k_stretch)
  --start LIST        starting values, NAME=VALUE[,...] (the scene's)
  --lower, --upper    bounds, NAME=VALUE[,...]
  --prior LIST        what is believed beforehand, NAME=MEDIAN:FACTOR[,...], as
                      k_bend=1e-5:2
  --sigma SIGMA       standard deviation of a measured coordinate, m; recorded:
                      that of the recording; auto: estimated (recorded)
  --loss LOSS         none, huber:A or cauchy:A, against points that are far
                      off; A in standard deviations (none)
  --starts N          fits from N starting points (1)
  --holdout FILES     recordings that are not fitted, to judge the estimates on
  --discretization P  step, mesh or all: intervals count with what fits tell of
                      the error of the time step, the mesh or both
  --threads N         recordings and fits side by side; no result depends on
                      it (1)
  --output DIR        folder of the results, report.html among them
                      (clothid_result)
  --export LIST       constants for mujoco, newton, arcsim, blender, ppf or all
  --help all          every flag, the names of parameters, exit codes
  --version

Lists may be given in parts: --fit mu --fit k_stretch. Ctrl-C saves the best
point so far.

Example:
  identify --target datasets/drape.motion.bin --fit mu,k_stretch \
    --output /tmp/drape
)";

inline constexpr char kMoreHelp[] = R"(
Parameters, of --fit, --each, --start, --lower, --upper, --prior and --profile:
  mu, mu.OBSTACLE, mu.self of the cloth against itself, k_stretch, k_bend, density, drag, damping
  where the scene has warp and weft k_warp, k_weft, k_shear, k_poisson in place of k_stretch and bend_warp, bend_weft,
                      bend_twist in place of k_bend; --fit is then mu,k_warp,k_weft where it is not given. Of yarns
                      also stiffening_warp, stiffening_weft
  of the air          drag_normal, drag_tangential, added_mass, pressure, wind.x, .y, .z, gust.x, .y, .z,
                      gust.frequency, gust.phase, gust.wave.x, .., wind.shear.x, .. and wind.x.1, .. of a wind profile
  size.x, size.y      what the cloth at rest is larger by than the scene says
  OBSTACLE.time_offset, OBSTACLE.shift.x, .., OBSTACLE.turn.x, ..
                      s, m and rad: what the path of an obstacle is off
  of a recording itself, 0 at the start; each but time_offset is x, y and z, as shift.x:
  time_offset         s, added to the recording's times to meet the clock of the scene and its handles
  shift, turn         m and rad about the centroid of the measured points, added to the prediction to meet the
                      recording: what its frame of reference is off (align: both). predicted.bin is in the recording's
                      frame
  v0                  m/s, added to the velocity of every free node at the start
  handle_shift        m, added to the path of all handles: what the tool that moves them is off; handle_shift1,
                      handle_shift2, .. of each group of handles by itself
  handle_turn         rad, turns all handles about their middle at every time
  force_bias          N, added to the predicted forces of the first group of handles, force_bias2 of the second: what a
                      gauge is off at zero
  --each NAMES        to fit as well, but one per recording: drag becomes drag@1, drag@2, ... in the order of --target

Bounds and priors:
  --lower, --upper    (the scene's; else mu 0..2, time_offset +-2 frames, shift +-1/4 of the cloth's size, turn +-0.2,
                      v0 +-2, handle_shift +-1/10 of the size, handle_turn +-0.2, force_bias +-the largest force, size.x
                      and size.y a factor of 1.25, k_poisson +-sqrt(k_warp k_weft), drag and damping
                      start/1e4..start*1e4, the others 100 times beyond what was measured of any cloth); drag is that of
                      every recording, drag@2 goes before it, shift stands for x, y and z
  --prior LIST        NAME=MEDIAN:FACTOR is a normal distribution of the logarithm; of mu, k_poisson and a recording's
                      own parameters it is NAME=MEAN:STD, as mu=0.3:0.1. It is one more residual, once for all
                      recordings. The verdict says what they add to it. Without: size 1:1.03, handle_shift 0:0.01,
                      handle_turn 0:0.05, and nothing of all others

Constants that vary over the cloth:
  --field LIST        of stiffnesses and density, each on a control grid: NAME:ROWSxCOLUMNS, as k_stretch:8x8.
                      They are fitted with the parameters of --fit, to which the level of each belongs, named there or
                      not: k_stretch is then the geometric mean over the cloth. Writes field_NAME.npy, which
                      `simulate --set_field` reads
  --field_weight W    of the smoothness of fields: W/2 times the integral of the squared Laplacian of the logarithm, the
                      control grid being a unit square; 0: chosen by the marginal likelihood (0)

Wind that changes over time:
  --wind_profile K[:AXES]  piecewise linear between K knots evenly over each recording, which has its own; from the wind
                      of the scene. AXES: its components that change, as in 8:xy (xyz). The wind is believed to change
                      little from knot to knot
  --wind_smoothness S by S sqrt(h) m/s (standard deviation) between knots h s apart, where residuals are as large as
                      sigma; 0: chosen by the marginal likelihood (0). Without --wind_profile: of fitted wind.x.1, ..

Noise and start:
  --sigma SIGMA       recorded: that of the recording, if it has one; auto: where it has none, estimated from the
                      scatter of its points in time; a number in m: that of every point of every recording
  --loss LOSS         per observed point. Where sigma is not known, one is taken as 1e-3 of the cloth's size
  --initial START     where the cloth starts if the scene does not say: rest, moving: that is estimated with the
                      parameters, the handles' places with it, released at rest or with a velocity of its own:
                      intervals count with what nobody knows of the start; estimated: moving, unless the first frames
                      show no velocity; smoothed: at a shape without noise, near the first frames and outside of
                      obstacles, with their velocity; first: at the first frame, noise and all (estimated)
  --check=false       fit without a look at the recordings: else what `motion check` warns of is told before the fit,
                      and what it calls a problem, such as mm for m, ends the run with exit code 2

The way of the fit:
  --horizon KIND      growing: fits of the first eighth, quarter and half of the recordings lead to where the fit of all
                      of them starts, past minima that only whole motions have; full: all frames at once (growing)
  --assimilate HOW    off: a rollout explains a whole recording; auto: where that leaves more than noise, the recordings
                      correct the rollouts, with a memory that grows from two frames to a third of their time, and what
                      is predicted between corrections is fitted; MEMORY[:LENGTH]: with that memory in s, waves shorter
                      than 6 LENGTH m corrected less (auto)
  --starts N          the own starting point and a Latin hypercube around it
  --seed S            of the starting points (0)
  --max_iterations N  (50)
  --jacobian KIND     adjoint, sensitivity or numeric (adjoint)
  --adjoint HOW       linear systems of --jacobian adjoint: reduced, lu, fixed_point or gmres, with a
                      threshold as in gmres:1e-6 (reduced, the scene's adjoint_tolerance)
  --check_gradients   compare adjoint, sensitivities and central differences at the start
  --precision KIND    adaptive: points far from the solution are simulated loosely; full: none (adaptive)
  --time_step H       of the simulation, in s (the scene's); auto: from the scene's to the coarsest whose error is at
                      most the standard deviation that noise leaves of each estimate, with its error in the intervals
  --step_tolerance X  relative residual of a time step (the scene's)
  --threads N         recordings, and fits of --starts, side by side; what is left over shares the work of a rollout
  --resume            continue a fit that was killed, ending in the same bytes: keeps a journal in DIR while it runs

Beside the fit:
  --profile NAMES     profile likelihood of these parameters: intervals of costs that are not quadratic
  --discretization P  step: fit again at half and twice the time step; mesh: fit again on a mesh of twice the density.
                      Intervals are widened by the errors that this shows, and the verdict says what is the largest:
                      noise, time step or mesh
  --holdout FILES     their error at the estimates and at the nominal parameters, and how often bands of 90 % hold them;
                      of --each they take the mean of the fitted recordings
  --holdout_frames A:B  the same for frames A to B - 1 of every recording
  --holdout_draws N   rollouts that make these bands, at least 19; 0: no bands (20)
  --calibrate_bands   finds one factor on the force that the model lacks by which they hold 90 %, for the bands of other
                      motions
  --landscape DIRS    folders that `landscape` wrote of a recording of --target, over two parameters of the fit:
                      report.html shows them as maps, with the estimate and the way to it

Repetitions:
  --repeat            fits each recording of --target for itself, too, and pools what they share: scatter between
                      recordings, mean, next specimen, which does not fit the others. --target may be folders of
                      finished fits, or folders of such, which are pooled without a fit: --fit chooses parameters,
                      --each leaves out
  --transfer          fits each recording of --target for itself, too, and predicts the others by bands of
                      --holdout_draws rollouts: what they hold, what their median misses, until when it is worth
                      more than the cloth at rest

Files:
  --output DIR        result.json, fabric.json, convergence.csv, predicted.bin, profile.csv, card.html, report.html
  --report=false      no card.html and no report.html, a page that any browser shows, with a 3D replay
  --export LIST       writes export_mujoco.xml and the like to DIR, with formula, unit and source, and what does not map
  --result FILE       no fit: exports the estimates of this result.json for the cloth of --target, or of the
                      predicted.bin beside it

Exit codes: 0 fitted; 1 usage, or a file that cannot be opened or written; 2 bad data; 3 not converged; 4 a parameter is
not identifiable, hardly told, or at its bound; 5 the estimates predict what was held out worse than the nominal
parameters; 6 no estimate must be used: the error is of the size of the cloth or larger than the motion, the start is
elsewhere, or the fit passed by a lower point; 70 internal error; 130 interrupted. Where several apply: 70, 130, 1, 2,
3, 6, 4, 5.
)";

}  // namespace clothid

#endif  // CLOTHID_IDENTIFY_HELP_H_

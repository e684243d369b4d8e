// What `plan --help` prints, and `plan --help all` after it.
#ifndef CLOTHID_TOOLS_PLAN_PLAN_HELP_H_
#define CLOTHID_TOOLS_PLAN_PLAN_HELP_H_

namespace clothid {

inline constexpr char kHelp[] = R"(plan: tells before the laboratory which motion would tell which parameter.

  plan --scenes FILE[,FILE...] --fit NAMES --sigma SIGMA [flags]

  --scenes FILES      candidates, scene.json each (every key:
                      datasets/scene.md), with what is known of the cloth
  --predict FILE      another scene.json: how wide its prediction would be by
                      what each motion tells, and which narrows it the most
  --fit NAMES         parameters, as mu, k_stretch, k_bend, density, drag
  --prior LIST        what is believed of them, NAME=MEDIAN:FACTOR[,...], as
                      k_bend=1e-5:2
  --start LIST        nominal values of the cloth, NAME=VALUE[,...] (the
                      scenes')
  --lower, --upper    bounds, NAME=VALUE[,...], as of identify
  --sigma SIGMA       standard deviation of a measured coordinate, m
  --frame_rate HZ     frames per second; 0: one per time step (0)
  --markers N         free nodes that are seen; 0: every node (0)
  --forces            the forces on the handles, too, in all, at every frame
  --force_sigma S     standard deviation of a component of them, N (0.01)
  --initial START     scene: the start is known to be the scene's; estimated,
                      rest or moving: it is estimated with the parameters
                      (estimated)
  --draws N           cloths beside the nominal one, drawn from what is
                      believed of it (8)
  --seed S            of draws and markers (1)
  --threads N         cloths side by side; no result depends on it (1)
  --output DIR        folder of plan.json and of plan.html, a page with the
                      motions in the colours of what they tell; empty: none
  --help all          every flag, the names of parameters, exit codes
  --version

Example:
  plan --scenes datasets/drape.scene.json,datasets/wind.scene.json \
    --fit k_stretch,k_bend --sigma 0.002 --frame_rate 30
)";

inline constexpr char kMoreHelp[] = R"(
The cloth:
  --fit NAMES         mu, mu.OBSTACLE, k_stretch, k_bend, density, drag, damping, and the others that `identify --help
                      all` names. A candidate takes those that its scene has
  --each NAMES        to fit as well, but in a pair one per recording
  --lower, --upper    an interval that is hardly narrower than the bounds tells nothing
  --prior LIST        as of identify. Without one the cloths that are drawn have the nominal value times 1.5^z with a
                      standard normal z; wind, k_poisson and what belongs to a recording itself stay nominal

The recording:
  --handle_sigma S    standard deviation of a coordinate of the measured path of handles that move, m; 0: exact (0).
                      Handles that stand still are seen as the other nodes are, or not where there are markers

It prints, for every candidate and the best pairs, the 95 % interval that a fit is expected to have, with its parts of noise
and of the time step, what is not told and what could make up for it, and how much narrower intervals would be with
twice the frame rate, half the noise, a gauge at the gripper, twice the markers, half as long again, a known start, half
the time step, or another candidate as well. identify/experiment/experiment_plan.h has the keys of plan.json.

Exit codes: 0 done, even where candidates failed; 1 usage, or a file that cannot be opened or written; 2 bad content;
3 no candidate could be simulated, 70 internal error, 130 interrupted: nothing is written.
)";

}  // namespace clothid

#endif  // CLOTHID_TOOLS_PLAN_PLAN_HELP_H_

// What `landscape --help` prints, and `landscape --help all` after it.
#ifndef CLOTHID_TOOLS_LANDSCAPE_LANDSCAPE_HELP_H_
#define CLOTHID_TOOLS_LANDSCAPE_LANDSCAPE_HELP_H_

namespace clothid {

inline constexpr char kHelp[] = R"(landscape: scans the cost of a recording over two parameters.

  landscape --target FILE --x AXIS --y AXIS [flags]
  landscape merge DIR... --output DIR
                      the shards of a scan as one, in the bytes of a scan that
                      was not divided
  landscape plot DIR  landscape.html, a page for any browser; landscape.png,
                      needs matplotlib

  --target FILE       recording (motion.bin)
  --scene FILE        scene.json to use instead of the one in the recording
  --x, --y AXIS       NAME=LOWER:UPPER:CELLS, evenly spaced with both ends, or
                      NAME=LOWER:UPPER:CELLS:log; names as mu and k_stretch
  --zoom LIST         a window of as many cells for each of these shares of the
                      axes
  --zoom_around LIST  their center, NAME=VALUE,NAME=VALUE; windows at the edge
                      are moved inside
  --set LIST          true parameters, NAME=VALUE[,...]: what they move is
                      compared with instead of what was measured
  --sigma SIGMA       standard deviation of a measured coordinate, as of
                      identify: recorded, auto or a number in m (recorded)
  --resume            continues a scan that was stopped, ending in the same
                      bytes; starts one that was not
  --threads N         cells side by side; the result does not depend on it (1)
  --output DIR        landscape.csv, a row per cell; timing.csv; plan.json;
                      summary.json: minimum, roughness and contact events of
                      every window (landscape_result)
  --help all          every flag, the names of parameters, exit codes
  --version

Every cell is on disk once it is done: Ctrl-C or kill lose no more than the
cells under way.

Example:
  landscape --target datasets/drape.motion.bin --x mu=0:0.6:13 \
    --y k_stretch=20:700:9:log --output /tmp/cost
)";

inline constexpr char kMoreHelp[] = R"(
The cells:
  --x, --y AXIS       names: mu, mu.OBSTACLE, k_stretch, k_bend, density, drag, damping, and where the scene has warp
                      and weft k_warp, k_weft, k_shear, k_poisson, stiffening_warp, stiffening_weft, bend_warp,
                      bend_weft, bend_twist; drag_normal,
                      drag_tangential, added_mass, pressure, size.x, size.y, wind.x and the like (costs/README.md)
  --zoom_only         leaves out the whole of the axes
  --sweep LIST        KEY=NUMBER[,NUMBER...][;KEY=...]: every combination is a setting. Keys are paths into the scene:
                      NAME.key of an obstacle, else from the top; x, y, z or an index pick from an array
  --contact MODE      gap, velocity, or both for every setting in either (the scene's own)
  --shard I/N         only the cells I, I + N, I + 2 N, .., 0 <= I < N

The cost:
  --set LIST          those on the axes and others, which are held at them: in every setting and mode their own rollout
                      is compared with
  --sigma SIGMA       recorded: that of the recording, if it has one; auto: where it has none, estimated from the
                      scatter of its points in time; a number in m: that of every point
  --initial START     where the cloth starts if the scene does not say, as of identify: rest, moving, estimated: where
                      the estimate of the start begins; smoothed; first (estimated). With the same --sigma and
                      --initial, costs are those of an identify that starts there
  --assimilate HOW    MEMORY[:LENGTH]: the recording corrects the rollouts of the cells with this memory in s, as of
                      identify (off)
  --result FILE       result.json of a fit of this recording, whose cost is scanned: frames are weighed by its error of
                      the model, other parameters held at its estimates; an unknown start stays where its estimate begins
  --gradients         the adjoint gradient at every cell, on a log axis by the logarithm

Exit codes: 0 done, even with failed cells, which have no cost; 1 usage, or a file that cannot be opened or written;
2 bad data; 70 internal error; 130 interrupted.
)";

}  // namespace clothid

#endif  // CLOTHID_TOOLS_LANDSCAPE_LANDSCAPE_HELP_H_

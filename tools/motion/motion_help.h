// What `motion --help` prints, and each of its commands; `motion --help all` prints all of them.
#ifndef CLOTHID_TOOLS_MOTION_MOTION_HELP_H_
#define CLOTHID_TOOLS_MOTION_MOTION_HELP_H_

namespace clothid {

inline constexpr char kHelp[] = R"(motion: looks at recordings, checks and converts them.

  motion info FILE                           tensors, times, points, scene,
                                             provenance
  motion check FILE [--json]                 what is wrong or doubtful before
                                             any fit, with a hint each
  motion view FILE [--output PAGE]           a page that replays a recording,
                                             or a scene.json, which is
                                             simulated first (view.html)
  motion convert IN OUT [flags]              from a file of another program, or
                                             a motion.bin, to another
  motion convert_clouds FOLDER OUT [flags]   from point clouds, a .npy or .ply
                                             per frame
  motion convert_curve FILE OUT [flags]      from force over elongation, as a
                                             testing machine exports it
  motion convert_cantilever FILE OUT [flags] from a strip that sags at an edge
  motion friction FILE [--json]              mu from angles of a tilted plate

Everyday flags of convert:
  --scene FILE         scene.json; OUT, a name ending in .bin, needs it
  --grid NXxNY:WxH     the mesh, if the scene has none: nodes and size in m, as
                       8x8:0.3x0.3
  --faces OBJ          the mesh likewise, m
  --map HOW            what point i is: nodes: node i; nearest: the nearest
                       node; markers: the nearest place; or a FILE (nodes)
  --scale S            multiplies positions: 0.001 from mm (1)
  --transform FILE     rigid, applied after --scale
  --frame_rate HZ      of the frames; --times FILE: their times
  --start_at T         puts the first frame at T s
  --sigma S            standard deviation of a coordinate, m
  --handle_nodes LIST  nodes that are held; --handles FILE: their paths
  --forces FILE        forces at the handles; --force_sigma S: their noise, N

`motion COMMAND --help` lists all flags of a command, `motion --help all` those
of all and the exit codes; --version.

Example: points of a camera, 8 x 8 down the columns, held at two corners
  motion convert mesh.csv cloth.bin --scene scene.json --grid 8x8:0.3x0.3 \
    --transpose --start_at 0 --handle_nodes 0,56 --sigma 0.004
  motion check cloth.bin
)";

inline constexpr char kCheckHelp[] =
    R"(motion check FILE [--json]: what is wrong or doubtful in a recording before any fit.

Gaps, missing, jumping and reordered points, noise, unit, start, handles, contact, gravity, clock, frame of reference,
clouds; a verdict and a hint each. --json: as JSON. Exit code 2 where the recording cannot be fitted as it is.
)";

inline constexpr char kConvertHelp[] =
    R"(motion convert IN OUT [flags]: from a file of another program or a motion.bin to another.

Points and clock:
  --missing LIST       positions, in the numbers of IN, that stand for points not seen, as in 0,0,0 or, of all three
                       coordinates, -1e6; several separated by colons
  --scale S            multiplies positions: 0.001 from mm (1)
  --transform FILE     rigid, applied after --scale: JSON {"matrix": 4 x 4} or {"rotation": [qx, qy, qz, qw],
                       "translation": [x, y, z]} in m, or a ROS CSV of poses, of which the last row counts
  --invert_transform   the inverse of it
  --times FILE         times of the frames in s: one per line, or .npy; `names`: those in the names of the files of a
                       sequence, in s, or of 13, 16 or 19 digits in ms, us or ns since 1970
  --frame_rate HZ      the same for frames at equal intervals
  --time_scale S       multiplies times: 0.001 from ms (1)
  --start_at T         puts the first frame kept at T s
  --frames A:B         frames A to B - 1 alone
  --skip_frames LIST   without these, as `motion check` names them

Cloth; a motion.bin from another program needs --scene and a mesh, in the scene or by one of these:
  --scene FILE         scene.json (every key: datasets/scene.md)
  --faces OBJ          the mesh at rest, m
  --grid NXxNY:WxH     a flat mesh of NX x NY nodes and W x H m, the nodes in the order of the points: along x first
  --transpose          along y first
  --map HOW            nodes: point i is node i; nearest: the nearest node, or markers: the nearest place on a triangle,
                       of a rest shape that lies near the points; FILE: CSV id,node or id,face,b0,b1,b2 (nodes)
  --map_distance D     of nearest and markers, m: how far a point may be off its place (half an edge)
  --as_surface         the points lie on the cloth, but are other points of it in every frame
  --borders            with it: those of the mesh's border lie on the border of the cloth
  --corners            with it: those of its corners are the corners of the cloth
  --sigma S            standard deviation of a coordinate, m (not known)

Handles:
  --handle_nodes LIST[:clamp]   nodes with a prescribed path: that of their measured points, gaps filled, or of a
                       file; `:clamp`: they hold the slope of the cloth, too, as a jaw does
  --handles FILE       CSV time,x0,y0,z0,x1,.. (s, m) or ROS poses of a tool, resampled to the frames
  --handle_offsets FILE   JSON {"NODE": [x, y, z], ..}: where the tool holds each node, m, in its own axes
  --handle_transform FILE   of the handles' frame of reference, as --transform
  --handle_time_offset S   the clock of FILE minus that of the recording, before --start_at, s (0)

Obstacles that move:
  --obstacle LIST      NAME=FILE,..: the path of an obstacle of the scene, CSV time,x,y,z,qx,qy,qz,qw (s, m), ROS poses
                       or .trc markers on it; or the vertices of one that deforms, .npy, .pc2, .obj or .ply
  --obstacle_transform FILE   of the frame of reference of their paths, as --transform
  --obstacle_time_offset S   the clock of FILE minus that of the recording, before --start_at, s (0)

Forces:
  --forces FILE        forces on the cloth at its handles, N: CSV time,x,y,z (or time,x0,y0,z0,x1,.. of several groups;
                       columns that are not there were not measured) or .npy of shape (F, 3), (F, G, 3) or (F)
  --force_sigma S      standard deviation of a component, N; needed
  --force_nodes LIST   the handles that each sensor holds, as in 0,1:4,5 (all of them one sensor)
  --force_axis A       x, y or z: the component of a .npy of shape (F)
  --force_times FILE   times of a .npy in s, another .npy (those of the frames, where there are as many)
  --force_scale S      multiplies forces: -1 where the force on the gripper was measured (1)
  --force_time_offset S   the clock of FILE minus that of the recording, before --start_at, s (0)

Example: a cloth seen by a camera, its 8 x 8 points down the columns, held at two corners
  motion convert mesh.csv cloth.bin --scene scene.json --grid 8x8:0.3x0.3 --transpose --transform camera_pose.csv \
      --start_at 0 --handle_nodes 0,56 --sigma 0.004
)";

inline constexpr char kConvertCloudsHelp[] =
    R"(motion convert_clouds FOLDER OUT [flags]: a motion.bin from point clouds.

Every .npy or .ply in FOLDER, or of a pattern, is a frame, in the order of the names; or a single .npy holds all. Arrays
have the shape (M, 3) or (H, W, 3), further columns and what else a PLY holds are not looked at. The scene gives mesh,
start, handles and obstacles.
  --scene FILE         scene.json; needed
  --frame_rate HZ, --times FILE   one of them is needed, as of convert; also --time_scale, --start_at
  --missing LIST       positions, in the numbers of the files, that are no points, as in 0,0,0, or -1e6 of all three
                       coordinates; several separated by colons. NaN never is one
  --scale S            multiplies positions: 0.001 from mm (1)
  --transform FILE, --invert_transform   as of convert, applied after --scale
  --box x0,y0,z0,x1,y1,z1   leaves out points outside of it, m, in the axes of the scene, which --transform leads to;
                       -inf or inf: no bound
  --sigma S            standard deviation of a coordinate, m (not known)
  --voxel SIZE         keeps the mean of the points in every cube of this side, m (all points)
  --max_points N       keeps N points per frame, chosen by --seed S (all; 1)
  --obstacle LIST, --obstacle_transform FILE, --obstacle_time_offset S   as of convert
  --fit_pose           moves the mesh as a rigid body onto the first cloud, from where the scene has it
  --float64            clouds in double precision
)";

inline constexpr char kConvertCurveHelp[] =
    R"(motion convert_curve FILE OUT [flags]: a motion.bin with its scene from the curve of a tensile test.

FILE is a table with a column of force (N, kN, cN, gf, or per width N/m, N/cm, N/mm) and one of extension, displacement
(mm, cm, m) or strain (%, 1), units in brackets behind the names or in a row below; lines about the test may stand
above. The recording is a strip between two clamps, the upper one pulled up, with the forces there.
  --direction D        warp, weft or bias (at 45 degrees to both): along which the cloth was pulled; needed
  --specimen WxL       width and length between the clamps, mm, as in 50x200 (those of the lines Width, Gauge length)
  --gauge L            length over which the elongation was measured, mm (that between the clamps)
  --preload F          force that ends the slack, N (0.5 % of the largest force)
  --strain FROM:TO     keeps these strains, as in 0.02:0.25 (all of the first loading)
  --force_sigma S      standard deviation of the forces of the recording, N (their scatter)
  --membrane LAW       yarn: stiffens with strain; or orthotropic (yarn)
  --nodes NXxNY        of the strip, across and along the pull (9x9; of bias 9 and as many as make cells square)

Example: a knit, pulled along its wales, and the fit of its curve
  motion convert_curve wales.csv wales.bin --specimen 95.9x45.2 --direction warp --strain 0:0.25
  identify --target wales.bin --fit k_warp,stiffening_warp
A bias curve tells k_shear where curves along warp and weft tell the rest:
  identify --target warp.bin,weft.bin,bias.bin --fit k_warp,k_weft,k_shear,stiffening_warp,stiffening_weft
)";

inline constexpr char kConvertCantileverHelp[] =
    R"(motion convert_cantilever FILE OUT [flags]: a motion.bin with its scene from a cantilever test.

FILE is a table with a specimen a row: its overhang (mm, cm, m) and the angle (deg, rad) of the line from the edge to
the tip below the level, 41.5 degrees where there is no such column; or with columns x and z of points of one sagging
strip, from the edge of the clamp at 0,0 on. Units as of convert_curve. The recording is a strip that is clamped at one
end and sags, with the tip or the profile at rest. The rigidity of the heavy elastica is printed, too.
  --density D          mass per area, kg/m^2; needed
  --direction D        warp, weft or bias: along which the strips were cut; the scene then has bend_warp, bend_weft and
                       bend_twist (k_bend)
  --sigma S            standard deviation of a coordinate, m (from the scatter of the rows; of one row, or of a profile,
                       1 mm)
  --overhang L         of the strip of a profile, from the edge to the tip, mm (the line through its points)

Example: three strips, and the fit
  motion convert_cantilever overhangs.csv bend.bin --density 0.15
  identify --target bend.bin --fit k_bend
)";

inline constexpr char kFrictionHelp[] =
    R"(motion friction FILE [--json]: mu from the angles at which specimens start to slide down a plate that is tilted.

FILE is a table with a column of the angle to the level (deg, rad), a test a row. mu is tan(angle): mean, 95 % interval
of the mean, standard deviation, and what a fit of another specimen may take as --prior. --json: as JSON.
)";

inline constexpr char kMoreHelp[] = R"(
Exit codes: 0 valid or written; 1 usage, file cannot be opened or written; 2 bad content, or a recording that cannot be
fitted as it is; 3 a time step of a viewed scene did not converge; 70 internal error; 130 interrupted.
)";

}  // namespace clothid

#endif  // CLOTHID_TOOLS_MOTION_MOTION_HELP_H_

// motion: looks at recordings, checks and converts them.
#include <string>
#include <vector>

#include "sim/base/error.h"
#include "tools/base/command_line.h"
#include "tools/motion/motion_clouds.h"
#include "tools/motion/motion_commands.h"

namespace clothid {
namespace {

constexpr char kHelp[] = R"(motion: looks at recordings, checks and converts them.

  motion info FILE                  tensors, times, points, scene, provenance
  motion check FILE [--json]        what is wrong or doubtful before any fit: gaps, missing, jumping and reordered
                                    points, noise, unit, start, handles, contact, gravity, clock, frame of reference,
                                    clouds; a verdict and a hint each
  motion convert IN OUT [flags]     from a file of another program or a motion.bin (a name ending in .bin) to another

  convert, points and clock:
  --scale S            multiplies positions: 0.001 from mm (1)
  --transform FILE     rigid, applied after --scale: JSON {"matrix": 4 x 4} or {"rotation": [qx, qy, qz, qw],
                       "translation": [x, y, z]} in m, or a ROS CSV of poses, of which the last row counts
  --invert_transform   the inverse of it
  --times FILE         times of the frames in s: one per line, or .npy
  --frame_rate HZ      the same for frames at equal intervals
  --time_scale S       multiplies times: 0.001 from ms (1)
  --start_at T         puts the first frame kept at T s
  --frames A:B         frames A to B - 1 alone
  --skip_frames LIST   without these, as `motion check` names them

  convert, cloth; a motion.bin from another program needs --scene and a mesh, in the scene or by one of these:
  --scene FILE         scene.json (every key: datasets/README.md)
  --faces OBJ          the mesh at rest, m
  --grid NXxNY:WxH     a flat mesh of NX x NY nodes and W x H m, the nodes in the order of the points: along x first
  --transpose          along y first
  --map HOW            nodes: point i is node i; nearest: the nearest node, or markers: the nearest place on a triangle,
                       of a rest shape that lies near the points; FILE: CSV id,node or id,face,b0,b1,b2 (nodes)
  --map_distance D     m: how far a point may be off its place (half an edge)
  --as_surface         the points lie on the cloth, but are other points of it in every frame
  --borders            with it: those of the mesh's border lie on the border of the cloth
  --corners            with it: those of its corners are the corners of the cloth
  --sigma S            standard deviation of a coordinate, m (not known)

  convert, handles:
  --handle_nodes LIST  nodes with a prescribed path: that of their measured points, gaps filled, or of a file
  --handles FILE       CSV time,x0,y0,z0,x1,.. (s, m) or ROS poses of a tool, resampled to the frames
  --handle_offsets FILE   JSON {"NODE": [x, y, z], ..}: where the tool holds each node, m, in its own axes
  --handle_transform FILE   of the handles' frame of reference, as --transform
  --handle_time_offset S   the clock of FILE minus that of the recording, before --start_at, s (0)

  convert, forces:
  --forces FILE        forces on the cloth at its handles, N: CSV time,x,y,z (or time,x0,y0,z0,x1,.. of several groups;
                       columns that are not there were not measured) or .npy of shape (F, 3), (F, G, 3) or (F)
  --force_sigma S      standard deviation of a component, N; needed
  --force_nodes LIST   the handles that each sensor holds, as in 0,1:4,5 (all of them one sensor)
  --force_axis A       x, y or z: the component of a .npy of shape (F)
  --force_times FILE   times of a .npy in s, another .npy (those of the frames, where there are as many)
  --force_scale S      multiplies forces: -1 where the force on the gripper was measured (1)
  --force_time_offset S   the clock of FILE minus that of the recording, before --start_at, s (0)

  motion convert_clouds FOLDER OUT --scene FILE (--frame_rate HZ | --times FILE) [--scale S] [--sigma S] [flags]
                       from point clouds: every .npy of shape (M, 3) in FOLDER, or of a pattern, is a frame, in the order
                       of the names; the scene gives mesh, start, handles and obstacles
  --voxel SIZE         keeps the mean of the points in every cube of this side, m (all points)
  --max_points N       keeps N points per frame, chosen by --seed S (all; 1)
  --fit_pose           moves the mesh as a rigid body onto the first cloud, from where the scene has it
  --float64            clouds in double precision
  --help, --version

Exit codes: 0 valid or written; 1 usage, file cannot be opened or written; 2 bad content, or a recording that cannot be
fitted as it is; 70 internal error.

Example: a cloth seen by a camera, its 8 x 8 points down the columns, held at two corners
  motion convert mesh.csv cloth.bin --scene scene.json --grid 8x8:0.3x0.3 --transpose --transform camera_pose.csv \
      --start_at 0 --handle_nodes 0,56 --sigma 0.004
  motion check cloth.bin
)";

int Info(const std::vector<std::string>& files) {
  if (files.size() != 1) throw Error(ErrorKind::kUsage, "info: expected one file");
  return MotionInfo(files.front());
}

int Check(const std::vector<std::string>& files) {
  if (files.size() != 1) throw Error(ErrorKind::kUsage, "check: expected one file");
  return MotionCheck(files.front());
}

int Convert(const std::vector<std::string>& files) {
  if (files.size() != 2 || files[0].empty() || files[1].empty())
    throw Error(ErrorKind::kUsage, "convert: expected a file to read and one to write");
  return MotionConvert(files[0], files[1]);
}

struct Subcommand {
  const char* name;
  const char* flags;  // that it takes, separated by blanks
  int (*run)(const std::vector<std::string>& arguments);
};

constexpr Subcommand kSubcommands[] = {
    {"info", "", Info},
    {"check", "json", Check},
    {"convert",
     "scene map map_distance as_surface borders corners sigma handle_nodes handles handle_offsets handle_transform "
     "handle_time_offset faces grid transpose transform invert_transform scale times frame_rate time_scale start_at "
     "skip_frames frames "
     "forces force_times force_sigma force_nodes force_axis force_scale force_time_offset",
     Convert},
    {"convert_clouds", "scene frame_rate times scale sigma voxel max_points seed fit_pose float64", ConvertClouds},
};

int Run(const std::vector<std::string>& arguments) {
  if (arguments.empty()) {
    throw Error(ErrorKind::kUsage, "a command is missing: info, check, convert or convert_clouds; see motion --help");
  }
  std::vector<CommandFlags> flags;
  for (const Subcommand& each : kSubcommands) flags.push_back({each.name, each.flags});
  for (const Subcommand& command : kSubcommands) {
    if (arguments.front() != command.name) continue;
    RejectOtherFlags(command.name, flags);
    return command.run({arguments.begin() + 1, arguments.end()});
  }
  throw Error(ErrorKind::kUsage,
              "unknown command '" + arguments.front() + "': expected info, check, convert or convert_clouds");
}

}  // namespace
}  // namespace clothid

int main(int argc, char** argv) { return clothid::RunCommand("motion", clothid::kHelp, argc, argv, clothid::Run); }

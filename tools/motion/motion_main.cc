// motion: looks at recordings, checks and converts them.
#include "identify/base/command_line.h"
#include "tools/motion/motion_commands.h"
#include "tools/motion/motion_help.h"

int main(int argc, char** argv) {
  using clothid::FlagRule;
  clothid::Program program = {"motion", clothid::kHelp, clothid::kMoreHelp};
  program.commands = {{"info", {"one file"}, "", clothid::MotionInfo},
                      {"check", {"one file"}, "json", clothid::MotionCheck, clothid::kCheckHelp},
                      {"view", {"one file"}, "output", clothid::MotionView},
                      {"convert",
                       {"a file to read", "one to write"},
                       clothid::ConvertFlags(),
                       clothid::MotionConvert,
                       clothid::kConvertHelp},
                      {"convert_clouds",
                       {"a folder or pattern of .npy or .ply files", "a file to write"},
                       "scene frame_rate times time_scale start_at missing scale transform invert_transform box sigma "
                       "voxel max_points seed obstacle obstacle_transform obstacle_time_offset fit_pose float64",
                       clothid::MotionConvertClouds,
                       clothid::kConvertCloudsHelp},
                      {"convert_curve",
                       {"a table of a testing machine", "a file to write"},
                       "specimen direction gauge strain preload membrane nodes force_sigma",
                       clothid::MotionConvertCurve,
                       clothid::kConvertCurveHelp},
                      {"convert_cantilever",
                       {"a table of a cantilever test", "a file to write"},
                       "density direction overhang sigma",
                       clothid::MotionConvertCantilever,
                       clothid::kConvertCantileverHelp},
                      {"friction", {"a table of angles"}, "json", clothid::MotionFriction, clothid::kFrictionHelp}};
  program.rules = {{"grid", FlagRule::kWithout, "faces"},
                   {"transpose", FlagRule::kWith, "grid"},
                   {"invert_transform", FlagRule::kWith, "transform"},
                   {"map_distance", FlagRule::kWith, "map", {"nearest", "markers"}},
                   {"borders corners", FlagRule::kWith, "as_surface"},
                   {"handles", FlagRule::kWith, "handle_nodes"},
                   {"handle_offsets handle_transform handle_time_offset", FlagRule::kWith, "handles"},
                   {"obstacle_transform obstacle_time_offset", FlagRule::kWith, "obstacle"},
                   {"force_times force_nodes force_axis force_scale force_time_offset", FlagRule::kWith, "forces"},
                   {"seed", FlagRule::kWith, "max_points"}};
  clothid::RunCommandLine(program, argc, argv);
}

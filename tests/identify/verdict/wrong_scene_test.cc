// Recordings and scenes that do not belong together: the fit converges all the same, and its verdict says that nothing
// of it must be used.
#include <algorithm>

#include "identify/run.h"
#include "tests/costs/synthetic_motion.h"

namespace clothid::wrong_scene_test {
namespace {

RecordedMotion Recorded(const Scene& scene = SwingScene()) {
  MotionOptions options;
  options.frame_interval = 0.01;
  options.true_values = {{"k_stretch", 150.0}};
  options.noise = options.sigma = 1e-3;
  return MakeMotion(scene, options);
}

RunResult RunFit(const RecordedMotion& motion) {
  RunOptions options;
  options.targets = {motion};
  options.fit.parameters = {"k_stretch"};
  options.fit.jacobian = JacobianMethod::kSensitivity;
  return Identify(options);
}

bool Says(const RunResult& result, const std::string& words) {
  const std::vector<std::string> lines = result.verdict.Lines();
  return std::any_of(lines.begin(), lines.end(),
                     [&](const std::string& line) { return line.find(words) != std::string::npos; });
}

TEST(WrongSceneTest, TheRightOneIsUsable) {
  Scene scene = SwingScene();
  scene.time_step /= 8.0;  // of whose error the noise hides enough
  const RunResult result = RunFit(Recorded(scene));
  EXPECT_EQ(result.exit_code, kExitSuccess) << result.table;
  EXPECT_EQ(result.verdict.overall, Usability::kUsable) << result.table;
  EXPECT_EQ(result.verdict.line, "usable: every fitted parameter is identifiable");
}

TEST(WrongSceneTest, YTakenForZ) {
  RecordedMotion motion = Recorded();
  for (int point = 0; point < motion.num_points(); ++point) {
    motion.positions.row(3 * point + 1).swap(motion.positions.row(3 * point + 2));
  }
  const RunResult result = RunFit(motion);
  EXPECT_EQ(result.exit_code, kExitDoNotUse) << result.table;
  EXPECT_EQ(result.verdict.overall, Usability::kDoNotUse);
  EXPECT_EQ(result.verdict.parameters, (std::vector<Usability>{Usability::kDoNotUse}));
  EXPECT_EQ(result.verdict.line.rfind("do not use: ", 0), 0u) << result.verdict.line;
  EXPECT_TRUE(Says(result, "the fit is negative (-")) << result.table;
  EXPECT_TRUE(Says(result, "the error is of the size of the cloth: rmse ")) << result.table;
}

TEST(WrongSceneTest, AStartThatIsElsewhere) {
  RecordedMotion motion = Recorded();
  for (int node = 0; node < motion.scene.mesh.num_nodes(); ++node) {
    const std::vector<int>& handles = motion.scene.handles.nodes;
    if (std::find(handles.begin(), handles.end(), node) != handles.end()) continue;
    motion.scene.initial_positions[3 * node + 1] += 0.06;
  }
  const RunResult result = RunFit(motion);
  EXPECT_EQ(result.exit_code, kExitDoNotUse) << result.table;
  EXPECT_TRUE(Says(result, "the scene's start is not where the first frame shows the cloth: ")) << result.table;
}

}  // namespace
}  // namespace clothid::wrong_scene_test

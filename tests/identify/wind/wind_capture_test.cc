// A real cloth in the wind of a fan (CLOTHID_RECORDINGS in tests/README.md): 928 material points on a mesh of 88 nodes.
// A fit goes on from where a longer one ended, and predicts the last frames.
#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdlib>
#include <filesystem>
#include <nlohmann/json.hpp>
#include <sstream>
#include <string>
#include <utility>
#include <vector>

#include "sim/base/npy_file.h"
#include "sim/base/text_file.h"
#include "sim/mesh/obj_file.h"
#include "tests/tools/tool_test.h"

namespace clothid::wind_capture_test {
namespace {

constexpr int kPointColumns = 32, kPointRows = 29;
constexpr int kNumPoints = kPointColumns * kPointRows, kNumFrames = 50, kNumFitted = 36;
constexpr int kColumns = 11, kRows = 8;  // of the mesh

// Where the `index`-th of `count` nodes stands among `points` points.
int PointOf(int index, int count, int points) {
  return static_cast<int>(std::lround((points - 1.0) * index / (count - 1.0)));
}

// The cell of nodes that a point is in, and how far it is across.
std::pair<int, double> CellOf(int point, int count, int points) {
  int cell = 0;
  while (cell < count - 2 && PointOf(cell + 1, count, points) <= point) ++cell;
  const double first = PointOf(cell, count, points), next = PointOf(cell + 1, count, points);
  return {cell, (point - first) / (next - first)};
}

class WindCaptureTest : public ToolTest {
 protected:
  void SetUp() override {
    const char* variable = std::getenv("CLOTHID_RECORDINGS");
    source_ = (variable != nullptr ? std::string(variable) : CLOTHID_SOURCE_DIR "/../shared/recordings") + "/wind_r1/";
    if (!std::filesystem::exists(source_ + "positions.npy")) {
      GTEST_SKIP() << source_ << "positions.npy is not there; set CLOTHID_RECORDINGS to its folder";
    }
    WriteMesh();
    WriteHandles();
    WriteMap();
    nlohmann::ordered_json scene = nlohmann::ordered_json::parse(kScene);
    for (int i = 0; i < kColumns; ++i) scene["handles"]["nodes"].push_back(i);
    WriteScene(scene);
    ExpectSuccess("motion convert '" + source_ + "positions.npy' r1.bin --scene scene.json --times '" + source_ +
                  "times.npy' --map map.csv --handle_nodes 0,1,2,3,4,5,6,7,8,9,10 --handles handles.csv --sigma 0.001");
  }

  // Two more iterations from `start`.
  nlohmann::json Fit(const std::string& start, const std::string& flags) const {
    const ToolResult fit =
        Run("identify --target r1.bin --check=false --initial smoothed --horizon full --jacobian sensitivity "
            "--max_iterations 2 --report=false --output r --fit drag_normal,added_mass,wind.x,wind.y,gust.y,"
            "gust.frequency,gust.phase,gust.wave.x --start " +
            start + " " + flags);
    EXPECT_TRUE(fit.exit_code == 0 || fit.exit_code == 3 || fit.exit_code == 4) << fit.exit_code << fit.err << fit.out;
    return nlohmann::json::parse(ReadBytes(folder() / "r" / "result.json"));
  }

  // The root mean square distance of the last frames from where each point was seen last before them, m.
  double ErrorOfHeldShape() const {
    const NpyArray positions = ReadNpy(source_ + "positions.npy");
    const Eigen::Map<const Eigen::MatrixXd> points(positions.values.data(), 3 * kNumPoints, kNumFrames);
    double sum = 0.0, count = 0.0;
    for (int p = kPointColumns; p < kNumPoints; ++p) {
      Eigen::Vector3d last = Eigen::Vector3d::Constant(std::nan(""));
      for (int frame = 0; frame < kNumFrames; ++frame) {
        const Eigen::Vector3d seen = points.block<3, 1>(3 * p, frame);
        if (!seen.allFinite()) continue;
        if (frame < kNumFitted) last = seen;
        if (frame < kNumFitted || !last.allFinite()) continue;
        sum += (seen - last).squaredNorm();
        ++count;
      }
    }
    return std::sqrt(sum / count);
  }

  // Air by direction, air that moves along, and a gust that runs along the width. All but the mesh are guesses.
  static constexpr char kScene[] = R"({
    "clothid_scene": 2, "time_step": 0.0111111111, "duration": 1.6333333333,
    "mesh": {"obj": "rest.obj"}, "handles": {"nodes": [], "path": "handles.csv"},
    "wind": {"mean": [0, 0.5, 0], "gust": [0, 1, 0], "frequency": 1, "phase": 1.5, "wave_vector": [-3, 0, 0]},
    "materials": {"density": 0.13, "k_stretch": 300, "k_bend": 2e-4, "damping": 0.3, "drag_normal": 0.2,
                  "added_mass": 0.1},
    "solver": {"step_tolerance": 1e-7}})";

 private:
  // Squares of nodes, cut along diagonals that alternate.
  static std::vector<std::array<int, 3>> Triangles() {
    std::vector<std::array<int, 3>> triangles;
    for (int j = 0; j + 1 < kRows; ++j) {
      for (int i = 0; i + 1 < kColumns; ++i) {
        const int a = i + kColumns * j, b = a + 1, c = a + kColumns, d = c + 1;
        if ((i + j) % 2 == 1) {
          triangles.insert(triangles.end(), {{a, c, b}, {b, c, d}});
        } else {
          triangles.insert(triangles.end(), {{a, c, d}, {a, d, b}});
        }
      }
    }
    return triangles;
  }

  void WriteMesh() const {
    const Mesh fine = ReadObj(source_ + "rest.obj");
    std::ostringstream obj;
    for (int j = 0; j < kRows; ++j) {
      for (int i = 0; i < kColumns; ++i) {
        const int point = PointOf(i, kColumns, kPointColumns) + kPointColumns * PointOf(j, kRows, kPointRows);
        obj << "v " << fine.rest_positions.col(point).transpose() << "\n";
      }
    }
    for (const auto& nodes : Triangles()) {
      obj << "f " << nodes[0] + 1 << " " << nodes[1] + 1 << " " << nodes[2] + 1 << "\n";
    }
    WriteBytes(folder() / "rest.obj", obj.str());
  }

  // The columns of the upper row's nodes.
  void WriteHandles() const {
    std::istringstream lines(ReadBytes(source_ + "handles.csv"));
    std::string text;
    bool is_head = true;
    for (std::string line; std::getline(lines, line); is_head = false) {
      const std::vector<std::string> cells = Split(line, ',');
      text += cells[0];
      for (int i = 0; i < kColumns; ++i) {
        const int first = 1 + 3 * PointOf(i, kColumns, kPointColumns);
        for (int c = 0; c < 3; ++c) text += "," + (is_head ? "xyz"[c] + std::to_string(i) : cells[first + c]);
      }
      text += "\n";
    }
    WriteBytes(folder() / "handles.csv", text);
  }

  // Every point by its place on a triangle.
  void WriteMap() const {
    std::ostringstream map;
    map.precision(9);
    map << "id,face,b0,b1,b2\n";
    for (int point = 0; point < kNumPoints; ++point) {
      const auto [column, u] = CellOf(point % kPointColumns, kColumns, kPointColumns);
      const auto [row, w] = CellOf(point / kPointColumns, kRows, kPointRows);
      const int first = 2 * (column + (kColumns - 1) * row);  // of the cell's triangles
      map << point << ",";
      if ((column + row) % 2 == 1) {
        if (u + w <= 1.0) {
          map << first << "," << 1.0 - u - w << "," << w << "," << u << "\n";
        } else {
          map << first + 1 << "," << 1.0 - w << "," << 1.0 - u << "," << u + w - 1.0 << "\n";
        }
      } else if (w >= u) {
        map << first << "," << 1.0 - w << "," << w - u << "," << u << "\n";
      } else {
        map << first + 1 << "," << 1.0 - u << "," << w << "," << u - w << "\n";
      }
    }
    WriteBytes(folder() / "map.csv", map.str());
  }

  std::string source_;
};

TEST_F(WindCaptureTest, IsReproducedWithinEightMillimetres) {
  const nlohmann::json result =
      Fit("drag_normal=2.1047,added_mass=0.5962,wind.x=0.6031,wind.y=-0.01,gust.y=0.2156,gust.frequency=1.1591,"
          "gust.phase=1.7186,gust.wave.x=-6.5016",
          "");
  EXPECT_LT(result["rmse_m"].get<double>(), 0.008);
  EXPECT_GT(result["fit_percent"].get<double>(), 80.0);
}

TEST_F(WindCaptureTest, TheFirstFramesPredictTheLast) {
  const nlohmann::json result =
      Fit("drag_normal=0.0878,added_mass=0.3733,wind.x=9.1245,wind.y=-1.3071,gust.y=3.1727,gust.frequency=0.374,"
          "gust.phase=1.8973,gust.wave.x=-5.659",
          "--holdout_frames 36:50");
  const double error = result["holdout"]["rmse_m"];
  EXPECT_LT(error, result["holdout"]["nominal_rmse_m"].get<double>());
  EXPECT_LT(error, ErrorOfHeldShape());
}

}  // namespace
}  // namespace clothid::wind_capture_test

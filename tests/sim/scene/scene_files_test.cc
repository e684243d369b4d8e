// Scenes from files, and the files that they name.
#include <gtest/gtest.h>

#include <cstdint>

#include "sim/scene/scene_json.h"
#include "tests/expect_error.h"
#include "tests/temporary_folder.h"

namespace clothid::scene_files_test {
namespace {

constexpr ErrorKind kBadData = ErrorKind::kBadData;

// On a grid of 3 x 3 nodes, with `member` in line 2.
std::string SmallScene(const std::string& member) {
  return R"({"clothid_scene": 1, "duration": 1, "mesh": {"grid": {"nodes": [3, 3], "size": [0.2, 0.2]}},)"
         "\n" +
         member + "}";
}

std::string NpyBytes(const std::string& header, const std::string& data) {
  std::string text = header + "\n";
  std::string bytes = "\x93NUMPY";
  bytes += std::string("\x01\x00", 2);
  bytes += static_cast<char>(text.size() & 255);
  bytes += static_cast<char>(text.size() >> 8);
  return bytes + text + data;
}

template <typename T>
std::string RawNumbers(int count) {
  std::string bytes;
  for (int i = 0; i < count; ++i) {
    const T value = static_cast<T>(0.5 * i);
    bytes.append(reinterpret_cast<const char*>(&value), sizeof(T));
  }
  return bytes;
}

TEST(ReadScene, ReadsStartPositionsFromNpy) {
  const TemporaryFolder folder;
  const std::string scene = folder.Write("scene.json", SmallScene("\"initial\": {\"positions\": \"start.npy\"}"));
  folder.Write("start.npy",
               NpyBytes("{'descr': '<f8', 'fortran_order': False, 'shape': (9, 3), }", RawNumbers<double>(27)));
  EXPECT_EQ(ReadScene(scene).initial_positions[26], 13.0);
  folder.Write("start.npy",
               NpyBytes("{'descr': '<f4', 'fortran_order': False, 'shape': (9, 3), }", RawNumbers<float>(27)));
  EXPECT_EQ(ReadScene(scene).initial_positions[25], 12.5);
}

TEST(ReadScene, NamesWrongNpyFiles) {
  const TemporaryFolder folder;
  const std::string scene = folder.Write("scene.json", SmallScene("\"initial\": {\"positions\": \"start.npy\"}"));
  const auto expect = [&](const std::string& bytes, std::initializer_list<const char*> fragments) {
    folder.Write("start.npy", bytes);
    ExpectError([&] { ReadScene(scene); }, kBadData, fragments);
  };
  const std::string data = RawNumbers<double>(27);
  expect("hello", {"start.npy: is not a .npy file"});
  expect(NpyBytes("{'descr': '<f8', 'fortran_order': False, 'shape': (3, 9), }", data),
         {"scene.json:2: key 'initial.positions'", "(9, 3)"});
  expect(NpyBytes("{'descr': '<f8', 'fortran_order': 0, 'shape': (9, 3), }", data), {"start.npy", "True or False"});
  expect(NpyBytes("{'descr': '<i8', 'fortran_order': False, 'shape': (9, 3), }", data), {"start.npy", "'<i8'"});
  expect(NpyBytes("{'descr': '<f8', 'fortran_order': False, 'shape': (9, 3), }", data.substr(1)),
         {"start.npy", "216 bytes"});
  expect(NpyBytes("{'descr': '<f8', 'fortran_order': False, 'shape': (4000000000, 4000000000), }", data),
         {"start.npy: its shape is larger"});
  expect(NpyBytes("{'descr': '<f8', 'fortran_order': False}", data), {"start.npy: its header lacks 'shape':"});
  const std::string whole = NpyBytes("{'descr': '<f8', 'fortran_order': False, 'shape': (9, 3), }", data);
  for (std::size_t length = 0; length < whole.size(); ++length) expect(whole.substr(0, length), {"start.npy: "});
  std::string nan = whole;
  nan.replace(nan.size() - 8, 8, "\xff\xff\xff\xff\xff\xff\xff\x7f");
  expect(nan, {"scene.json:2: key 'initial.positions'", "finite"});
}

TEST(ReadScene, PutsHandlesOnTheirPath) {
  const TemporaryFolder folder;
  const std::string scene_path =
      folder.Write("scene.json", SmallScene("\"handles\": {\"nodes\": [4, 0], \"path\": \"handles.csv\"}"));
  folder.Write("handles.csv", "time,x0,y0,z0,x1,y1,z1\n0,1,2,3,4,5,6\n1,2,2,3,4,5,6\n");
  const Scene scene = ReadScene(scene_path);
  EXPECT_EQ(scene.handles.nodes, (std::vector<int>{4, 0}));
  EXPECT_EQ(scene.initial_positions.segment<3>(12), Eigen::Vector3d(1, 2, 3));
  EXPECT_EQ(scene.initial_positions.segment<3>(0), Eigen::Vector3d(4, 5, 6));
  EXPECT_EQ(scene.handles.path.At(0.5)[0], 1.5);
}

TEST(ReadScene, ReadsAnObjMeshAndNamesItsFaults) {
  const TemporaryFolder folder;
  const std::string scene =
      folder.Write("scene.json", R"({"clothid_scene": 1, "duration": 1, "mesh": {"obj": "cloth.obj"}})");
  ExpectError([&] { ReadScene(scene); }, ErrorKind::kIo, {"cloth.obj: cannot be read"});
  const std::string vertices = "v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\n";
  folder.Write("cloth.obj", vertices + "f 1 2 3 4\n");
  EXPECT_EQ(ReadScene(scene).mesh.num_faces(), 2);
  folder.Write("cloth.obj", vertices + "f 1 2 3\nf 1 4 3\n");
  ExpectError(
      [&] { ReadScene(scene); }, kBadData,
      {"cloth.obj:6: triangle 1 is inverted relative to triangle 0 (both run along edge 0-2 in the same direction)"});
  ExpectError([&] { ReadScene(folder.File("none.json")); }, ErrorKind::kIo, {"none.json: cannot be read"});
}

TEST(FilesOfScene, ListsTheSceneAndWhatItNames) {
  const TemporaryFolder folder;
  const std::string scene = folder.Write("scene.json", R"({
    "mesh": {"obj": "cloth.obj"},
    "handles": {"nodes": [4], "path": "/absolute/gripper.csv"},
    "initial": {"positions": "sub/start.npy"},
    "obstacles": [{"type": "mesh", "obj": "table.obj"}, {"name": "path"}]
  })");
  EXPECT_EQ(FilesOfScene(scene), (std::vector<std::string>{scene, folder.File("cloth.obj"), "/absolute/gripper.csv",
                                                           folder.File("sub/start.npy"), folder.File("table.obj")}));
  folder.Write("scene.json", R"({"mesh": 3, "handles": [0], "initial": {"positions": "rest"}})");
  EXPECT_EQ(FilesOfScene(scene), std::vector<std::string>{scene});
  folder.Write("scene.json", "{");
  ExpectError([&] { FilesOfScene(scene); }, kBadData, {"scene.json:1: not valid JSON"});
}

}  // namespace
}  // namespace clothid::scene_files_test

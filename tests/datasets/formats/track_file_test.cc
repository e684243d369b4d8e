// Every format at the entry: what it keeps, how it is recognised, and that nothing half-written stays.
#include "datasets/formats/track_file.h"

#include <gtest/gtest.h>
#include <nettle/base64.h>

#include <cmath>
#include <cstdint>
#include <cstring>
#include <filesystem>
#include <limits>
#include <set>
#include <string>
#include <vector>

#include "sim/base/frame_names.h"
#include "sim/base/npy_file.h"
#include "sim/base/text_file.h"
#include "tests/expect_error.h"
#include "tests/temporary_folder.h"

namespace clothid::track_file_test {
namespace {

namespace fs = std::filesystem;

constexpr double kNan = std::numeric_limits<double>::quiet_NaN();

// 12 frames of 5 points at irregular times, with numbers that need every digit.
PointTracks Tracks() {
  PointTracks tracks;
  tracks.name = "test";
  tracks.times.resize(12);
  tracks.positions.resize(15, 12);
  for (int i = 0; i < 12; ++i) {
    tracks.times[i] = 0.1 * i + 0.01 * std::sin(i);
    for (int row = 0; row < 15; ++row) tracks.positions(row, i) = std::sin(row + 0.7 * i) / 3.0;
  }
  tracks.faces.resize(3, 2);
  tracks.faces << 0, 1, 1, 3, 2, 4;
  return tracks;
}

void ExpectEqual(const Eigen::MatrixXd& found, const Eigen::MatrixXd& expected, double tolerance) {
  ASSERT_EQ(found.rows(), expected.rows());
  ASSERT_EQ(found.cols(), expected.cols());
  for (Eigen::Index i = 0; i < expected.size(); ++i) {
    const double difference = std::abs(found(i) - expected(i));
    EXPECT_TRUE(difference <= tolerance * std::abs(expected(i)) || (std::isnan(found(i)) && std::isnan(expected(i))))
        << "entry " << i << ": " << found(i) << ", expected " << expected(i);
  }
}

class TrackFileTest : public testing::Test {
 protected:
  std::set<std::string> Names() const {
    std::set<std::string> names;
    for (const auto& entry : fs::directory_iterator(folder_.path())) names.insert(entry.path().filename());
    return names;
  }
  std::string Text(const std::string& name) const { return ReadFile(folder_.File(name), 1 << 20); }
  PointTracks RoundTrip(const PointTracks& tracks, const std::string& name) const {
    WriteTracks(tracks, folder_.File(name));
    return ReadTracks(folder_.File(name));
  }

  TemporaryFolder folder_;
};

TEST_F(TrackFileTest, RoundTripsKeepPositionsToThePrecisionOfTheFormat) {
  const PointTracks tracks = Tracks();
  struct Case {
    const char* name;
    double tolerance;  // relative
    bool keeps_times, keeps_faces, keeps_missing;
  };
  const double single = std::ldexp(1.0, -24);
  for (const Case& format : {Case{"a.npy", 0.0, true, true, true}, Case{"a.CSV", 0.0, true, false, true},
                             Case{"a.trc", 0.0, true, false, true}, Case{"a_##.obj", 0.0, false, true, false},
                             Case{"a_##.ply", 0.0, false, true, true}, Case{"a.pc2", single, false, false, true}}) {
    SCOPED_TRACE(format.name);
    PointTracks measured = tracks;
    if (format.keeps_missing) {
      measured.positions.col(0).segment<3>(3).setConstant(kNan);
      measured.positions.col(5).setConstant(kNan);
    }
    const PointTracks again = RoundTrip(measured, format.name);
    ExpectEqual(again.positions, measured.positions, format.tolerance);
    if (format.keeps_times) {
      EXPECT_EQ(again.times, measured.times);
    } else {
      EXPECT_EQ(again.times.size(), 0);
    }
    if (format.keeps_faces) {
      EXPECT_EQ(again.faces, measured.faces);
    } else {
      EXPECT_EQ(again.faces.cols(), 0);
    }
    EXPECT_EQ(again.name, folder_.File(format.name));
  }
}

TEST_F(TrackFileTest, ReadsFoldersAndSingleFiles) {
  fs::create_directory(folder_.File("frames"));
  const PointTracks tracks = Tracks();
  for (const char* extension : {".obj", ".ply"}) {
    WriteTracks(tracks, folder_.File("frames/f#") + extension);
    EXPECT_TRUE(fs::exists(folder_.File("frames/f11") + extension));
    folder_.Write("frames/.hidden.obj", "no mesh");
    ExpectEqual(ReadTracks(folder_.File("frames")).positions, tracks.positions, 0.0);
    EXPECT_EQ(ReadTracks(folder_.File("frames/f3") + extension).positions, tracks.positions.col(3));
    if (extension == std::string(".obj")) {
      for (int i = 0; i < 12; ++i) fs::remove(folder_.File("frames/f" + std::to_string(i) + ".obj"));
    }
  }
  folder_.Write("frames/f0.obj", "v 0 0 0\n");
  ExpectError([&] { FormatOf(folder_.File("frames")); }, ErrorKind::kUsage, {"frames: holds .obj and .ply files"});
}

TEST_F(TrackFileTest, TakesNumberSignsOfFoldersAsTheyAre) {
  fs::create_directory(folder_.File("take #2"));
  WriteTracks(Tracks(), folder_.File("take #2/f#.ply"));
  EXPECT_EQ(ReadTracks(folder_.File("take #2")).num_frames(), 12);
  EXPECT_EQ(ReadTracks(folder_.File("take #2/f##.ply")).num_frames(), 12);
  EXPECT_EQ(ReadTracks(folder_.File("take #2/f7.ply")).num_frames(), 1);
}

TEST_F(TrackFileTest, OrdersFramesByNumber) {
  EXPECT_TRUE(NaturalLess("f9.obj", "f10.obj"));
  EXPECT_TRUE(NaturalLess("f09.obj", "f10.obj"));
  EXPECT_FALSE(NaturalLess("f10.obj", "f9.obj"));
  EXPECT_TRUE(NaturalLess("f99999999999999999999.obj", "f100000000000000000000.obj"));
  EXPECT_TRUE(NaturalLess("take2_f9", "take10_f1"));
  for (const char* name : {"f1.obj", "f02.obj", "f10.obj", "f_3.obj", "f.obj", "g4.obj"}) {
    folder_.Write(name, "v " + std::string(1, name[1]) + " 0 0\n");
  }
  folder_.Write("f1.obj", "v 1 0 0\nv 0 1 0\n");
  EXPECT_EQ(FramePaths(folder_.File("f##.obj"), ".obj"),
            (std::vector<std::string>{folder_.File("f1.obj"), folder_.File("f02.obj"), folder_.File("f10.obj")}));
  folder_.Write("f2.obj", "v 0 0 0\n");
  ExpectError([&] { ReadTracks(folder_.File("f#.obj")); }, ErrorKind::kBadData, {"f02.obj", "f2.obj", "same number"});
  ExpectError([&] { ReadTracks(folder_.File("h#.obj")); }, ErrorKind::kUsage, {"h#.obj: expected files", "none"});
  ExpectError([&] { ReadTracks(folder_.File("f#_#.obj")); }, ErrorKind::kUsage, {"f#_#.obj: expected one run"});
  ExpectError([&] { ReadTracks(folder_.File("absent/f#.obj")); }, ErrorKind::kIo, {"absent: cannot be read"});
}

TEST_F(TrackFileTest, NumbersOfFramesKeepTheirGaps) {
  using Numbers = std::vector<long long>;
  EXPECT_EQ(FrameNumbers({"f0.obj", "f1.obj", "f3.obj"}), (Numbers{0, 1, 3}));
  EXPECT_EQ(FrameNumbers({"take2/f010.obj", "take2/f020.obj", "take2/f50.obj"}), (Numbers{0, 1, 4}));
  EXPECT_EQ(FrameNumbers({"f0.obj", "f10.obj", "f20.obj"}), Numbers());
  EXPECT_EQ(FrameNumbers({"f7.obj"}), Numbers());
  EXPECT_EQ(FrameNumbers({"a.obj", "b3.obj"}), Numbers());
  EXPECT_EQ(FrameNumbers({"1_f0.obj", "2_f3.obj", "3_f4.obj"}), Numbers());
  EXPECT_EQ(FrameNumbers({"f1.obj", "f2.obj", "f99999999999999999999.obj"}), Numbers());

  fs::create_directory(folder_.File("frames"));
  WriteTracks(Tracks(), folder_.File("frames/f##.obj"));
  EXPECT_EQ(ReadTracks(folder_.File("frames")).frame_numbers, Numbers());
  fs::remove(folder_.File("frames/f02.obj"));
  const Numbers expected = {0, 1, 3, 4, 5, 6, 7, 8, 9, 10, 11};
  for (const char* name : {"frames", "frames/f#.obj"}) {
    EXPECT_EQ(ReadTracks(folder_.File(name)).frame_numbers, expected) << name;
  }
  WriteTracks(ReadTracks(folder_.File("frames")), folder_.File("g##.ply"));
  EXPECT_FALSE(fs::exists(folder_.File("g02.ply")));
  EXPECT_TRUE(fs::exists(folder_.File("g11.ply")));
}

TEST_F(TrackFileTest, AFolderIsOneSequence) {
  ExpectOneSequence("folder", {"a.obj", "b.obj", "c1.obj"});
  ExpectOneSequence("folder", {"take2_1.obj", "take2_02.obj"});
  fs::create_directory(folder_.File("frames"));
  WriteTracks(Tracks(), folder_.File("frames/f##.obj"));
  folder_.Write("frames/rest.obj", Text("frames/f00.obj"));
  ExpectError([&] { ReadTracks(folder_.File("frames")); }, ErrorKind::kUsage,
              {"frames: rest.obj is not numbered like f00.obj"});
  EXPECT_EQ(ReadTracks(folder_.File("frames/f#.obj")).num_frames(), 12);
  ExpectError(
      [] {
        ExpectOneSequence("folder", {"a1.obj", "b1.obj", "b2.obj"});
      },
      ErrorKind::kUsage, {"folder: a1.obj is not numbered like b1.obj; expected one sequence"});
}

TEST_F(TrackFileTest, ByteOrderMarksAreNoContent) {
  const std::string mark = "\xef\xbb\xbf", obj = mark + "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n";
  EXPECT_EQ(ReadTracks(folder_.Write("a.obj", obj)).num_points(), 3);
  WriteTracks(Tracks(), folder_.File("b.trc"));
  EXPECT_EQ(ReadTracks(folder_.Write("c.trc", mark + Text("b.trc"))).num_points(), 5);
  EXPECT_EQ(ReadTracks(folder_.Write("d.csv", mark + "t,id,x,y,z\n0,a,1,2,3\n")).labels[0], "a");
  EXPECT_EQ(FormatOf(folder_.Write("e.csv", mark + "%time,field.size\n")), TrackFormat::kRosCsv);
}

TEST_F(TrackFileTest, ListsItsFiles) {
  EXPECT_EQ(TrackPaths("a.npy"), (std::vector<std::string>{"a.npy", "a.times.npy", "a.faces.npy"}));
  EXPECT_EQ(TrackPaths("a.bin"), std::vector<std::string>{"a.bin"});
  EXPECT_EQ(TrackPaths("absent/a_#.obj"), std::vector<std::string>{"absent/a_#.obj"});
  folder_.Write("a_1.obj", "");
  folder_.Write("a_20.obj", "");
  const std::vector<std::string> frames = {folder_.File("a_1.obj"), folder_.File("a_20.obj")};
  EXPECT_EQ(TrackPaths(folder_.File("a_##.obj")), frames);
  EXPECT_EQ(TrackPaths(folder_.path()), frames);
}

TEST_F(TrackFileTest, RefusesMixedSequences) {
  folder_.Write("f1.obj", "v 0 0 0\nv 1 0 0\n");
  folder_.Write("f2.obj", "v 0 0 0\n");
  ExpectError([&] { ReadTracks(folder_.File("f#.obj")); }, ErrorKind::kBadData,
              {"f2.obj: has 1 vertices; expected 2 as in ", "f1.obj"});
  folder_.Write("f2.obj", "v 0 0 0\nv 1 nan 0\n");
  ExpectError([&] { ReadTracks(folder_.File("f#.obj")); }, ErrorKind::kBadData, {"f2.obj:2: "});
  const std::string points = "v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\n";
  folder_.Write("f1.obj", points + "f 1 2 3\nf 1 3 4\n");
  folder_.Write("f2.obj", points);
  EXPECT_EQ(ReadTracks(folder_.File("f#.obj")).num_frames(), 2);
  folder_.Write("f2.obj", points + "f 1 2 4\nf 2 3 4\n");
  ExpectError([&] { ReadTracks(folder_.File("f#.obj")); }, ErrorKind::kBadData,
              {"f2.obj: has other faces than ", "f1.obj"});
  folder_.Write("empty.obj", "# nothing\n");
  ExpectError([&] { ReadTracks(folder_.File("empty.obj")); }, ErrorKind::kBadData, {"empty.obj: holds no point"});
}

// An L and a square. In another frame the cloth is seen edge-on: no polygon has an area, and could be cut.
TEST_F(TrackFileTest, CutsThePolygonsOfASequenceOnce) {
  const std::string flat[] = {"0 0 0", ".2 0 0", ".2 .1 0", ".1 .1 0", ".1 .2 0", "0 .2 0", ".2 .2 0"};
  const auto obj = [&](const std::vector<std::string>& places) {
    std::string text;
    for (const std::string& place : places) text += "v " + place + "\n";
    return text + "f 3 4 5 6 1 2\nf 3 7 5 4\n";
  };
  const auto ply = [&](const std::vector<std::string>& places,
                       const std::string& faces = "6 2 3 4 5 0 1\n4 2 6 4 3\n") {
    std::string text =
        "ply\nformat ascii 1.0\nelement vertex 7\nproperty float x\nproperty float y\nproperty float z\n"
        "element face 2\nproperty list uchar int vertex_indices\nend_header\n";
    for (const std::string& place : places) text += place + "\n";
    return text + faces;
  };
  std::vector<std::string> whole(flat, flat + 7), edge_on = whole, hidden = whole;
  for (std::size_t i = 0; i < edge_on.size(); ++i) edge_on[i] = "." + std::to_string(i) + " 0 0";
  hidden[3] = "nan nan nan";
  folder_.Write("a0.obj", obj(whole));
  folder_.Write("a1.obj", obj(edge_on));
  folder_.Write("b0.ply", ply(whole));
  folder_.Write("b1.ply", ply(edge_on));
  const Eigen::Matrix3Xi faces = ReadTracks(folder_.File("a#.obj")).faces;
  EXPECT_EQ(faces.cols(), 6);
  EXPECT_EQ(ReadTracks(folder_.File("b#.ply")).faces, faces);
  // Cut as they lie where they are seen first; a fan where no frame shows them.
  folder_.Write("b0.ply", ply(hidden));
  folder_.Write("b1.ply", ply(whole));
  EXPECT_EQ(ReadTracks(folder_.File("b#.ply")).faces, faces);
  EXPECT_EQ(ReadTracks(folder_.File("b0.ply")).faces.col(1), Eigen::Vector3i(2, 4, 5));
  EXPECT_EQ(ReadTracks(folder_.File("b0.ply"), &faces).faces, faces);
  // A frame in which they cannot be cut tells nothing, unless there is no other.
  folder_.Write("b0.ply", ply(edge_on));
  EXPECT_EQ(ReadTracks(folder_.File("b#.ply")).faces, faces);
  ExpectError([&] { ReadTracks(folder_.File("b0.ply")); }, ErrorKind::kBadData,
              {"b0.ply:17: the polygon of 6 corners"});
  folder_.Write("b1.ply", ply(whole, "6 2 3 4 5 0 1\n4 2 6 3 4\n"));
  ExpectError([&] { ReadTracks(folder_.File("b#.ply")); }, ErrorKind::kBadData,
              {"b1.ply: has other faces than ", "b0.ply"});
}

TEST_F(TrackFileTest, KnowsFormatsByName) {
  EXPECT_EQ(FormatOf("a.npy"), TrackFormat::kNpy);
  EXPECT_EQ(FormatOf("a.csv"), TrackFormat::kTidyCsv);
  EXPECT_EQ(FormatOf("a.TRC"), TrackFormat::kTrc);
  EXPECT_EQ(FormatOf("a_####.obj"), TrackFormat::kObjSequence);
  EXPECT_EQ(FormatOf("a_####.ply"), TrackFormat::kPlySequence);
  EXPECT_EQ(FormatOf("a.pc2"), TrackFormat::kPc2);
  EXPECT_EQ(FormatOf("a.pvd"), TrackFormat::kVtp);
  EXPECT_EQ(FormatOf("a.vtp"), TrackFormat::kVtp);
  EXPECT_EQ(FormatOf(folder_.Write("ros.csv", "%time,field.header.seq\n1,2\n")), TrackFormat::kRosCsv);
  EXPECT_EQ(FormatOf(folder_.Write("tidy.csv", "z,y,x,id,t\n")), TrackFormat::kTidyCsv);
  EXPECT_EQ(FormatOf(folder_.Write("quoted.csv", "\"%time\",\"field.size\"\n")), TrackFormat::kRosCsv);
  ExpectError([&] { ReadTracks(folder_.Write("other.csv", "time,x0\n")); }, ErrorKind::kBadData,
              {"other.csv:1: ", "'time,x0'"});
  ExpectError([] { FormatOf("a.fbx"); }, ErrorKind::kUsage, {"a.fbx: unknown format; known are .npy"});
  ExpectError([] { FormatOf("frames"); }, ErrorKind::kUsage, {"frames: unknown format"});
  ExpectError([&] { FormatOf(folder_.path()); }, ErrorKind::kUsage, {"holds no sequence; known are .npy"});
  ExpectError([] { ReadTracks("a.pvd"); }, ErrorKind::kUsage, {"a.pvd: ", "written, never read"});
  ExpectError([] { ReadTracks("absent.trc"); }, ErrorKind::kIo, {"absent.trc: cannot be read"});
}

TEST_F(TrackFileTest, RefusesWhatAFormatCannotHold) {
  PointTracks tracks = Tracks();
  tracks.positions(7, 3) = kNan;
  const auto expect = [&](const std::string& name, ErrorKind kind, std::initializer_list<const char*> fragments) {
    ExpectError([&] { WriteTracks(tracks, folder_.File(name)); }, kind, fragments);
  };
  expect("a_##.obj", ErrorKind::kUsage, {"test: frame 3, point 2 is not seen, and OBJ has no word for that"});
  expect("a.obj", ErrorKind::kUsage, {"frame 3, point 2"});
  tracks.positions(7, 3) = 0.0;
  expect("a.obj", ErrorKind::kUsage, {"a.obj: expected '#'", "a_####.obj"});
  tracks.times.resize(0);
  expect("a.trc", ErrorKind::kUsage, {"test: has no times, and TRC needs them"});
  expect("a.csv", ErrorKind::kUsage, {"test: has no times, and CSV needs them"});
  tracks.positions(7, 3) = HUGE_VAL;
  expect("a.npy", ErrorKind::kBadData, {"test: frame 3, point 2: expected finite numbers"});
  tracks = Tracks();
  tracks.times[4] = tracks.times[3];
  expect("a.npy", ErrorKind::kBadData, {"test: the time of frame 4"});
  tracks = Tracks();
  tracks.faces(1, 1) = 5;
  expect("a.npy", ErrorKind::kBadData, {"test: triangle 1 refers to point 5; expected 0 to 4"});
  tracks = Tracks();
  tracks.labels = {"one"};
  expect("a.npy", ErrorKind::kBadData, {"test: has 1 labels for 5 points"});
  tracks.positions.resize(0, 0);
  expect("a.npy", ErrorKind::kBadData, {"test: holds no point"});
  EXPECT_TRUE(Names().empty());
}

TEST_F(TrackFileTest, ReadsWhatStandsBesideAnArray) {
  PointTracks tracks = Tracks();
  WriteTracks(tracks, folder_.File("a.npy"));
  EXPECT_EQ(Names(), (std::set<std::string>{"a.npy", "a.times.npy", "a.faces.npy"}));
  folder_.Write("a.times.npy", Text("a.faces.npy"));
  ExpectError([&] { ReadTracks(folder_.File("a.npy")); }, ErrorKind::kBadData, {"a.times.npy: expected elements"});
  folder_.Write("a.times.npy", Text("a.npy"));
  ExpectError([&] { ReadTracks(folder_.File("a.npy")); }, ErrorKind::kBadData,
              {"a.times.npy: expected an array of shape (T), times, found (12, 5, 3)"});
  folder_.Write("a.times.npy", NpyBytes(NpyArray{{12}, {0, 1, 2, 3, 4, 4, 6, 7, 8, 9, 10, 11}}));
  ExpectError([&] { ReadTracks(folder_.File("a.npy")); }, ErrorKind::kBadData,
              {"a.times.npy: the time of frame 5, 4 s, is not after"});
  ExpectError([&] { ReadTracks(folder_.File("a.faces.npy")); }, ErrorKind::kBadData, {"a.faces.npy: expected"});
  tracks.times.resize(0);
  tracks.faces.resize(3, 0);
  const PointTracks again = RoundTrip(tracks, "a.npy");
  EXPECT_EQ(Names(), std::set<std::string>{"a.npy"});
  EXPECT_EQ(again.times.size(), 0);
  EXPECT_EQ(again.faces.cols(), 0);
}

TEST_F(TrackFileTest, RefusesToMixSequences) {
  PointTracks tracks = Tracks();
  WriteTracks(tracks, folder_.File("a_##.obj"));
  const std::string frame = Text("a_00.obj");
  tracks.positions *= 2.0;
  tracks.positions.conservativeResize(Eigen::NoChange, 11);
  tracks.times.conservativeResize(11);
  ExpectError([&] { WriteTracks(tracks, folder_.File("a_##.obj")); }, ErrorKind::kUsage, {"a_11.obj would count"});
  EXPECT_EQ(Text("a_00.obj"), frame);
  fs::remove(folder_.File("a_11.obj"));
  WriteTracks(tracks, folder_.File("a_##.obj"));
  EXPECT_NE(Text("a_00.obj"), frame);
  EXPECT_EQ(Names().size(), 11u);
}

TEST_F(TrackFileTest, LeavesNothingWhereWritingFails) {
  const PointTracks tracks = Tracks();
  fs::create_directory(folder_.File("a_05.ply"));
  ExpectError([&] { WriteTracks(tracks, folder_.File("a_##.ply")); }, ErrorKind::kIo, {"a_05.ply: cannot be written"});
  fs::create_directory(folder_.File("b.pvd"));
  ExpectError([&] { WriteTracks(tracks, folder_.File("b.vtp")); }, ErrorKind::kIo, {"b.pvd: cannot be written"});
  fs::create_directory(folder_.File("c.times.npy"));
  ExpectError([&] { WriteTracks(tracks, folder_.File("c.npy")); }, ErrorKind::kIo, {"c.times.npy: cannot be written"});
  EXPECT_EQ(Names(), (std::set<std::string>{"a_05.ply", "b.pvd", "c.times.npy"}));
  for (const char* name : {"absent/a_##.ply", "absent/a.pvd", "absent/a.npy", "absent/a.trc"}) {
    ExpectError([&] { WriteTracks(tracks, folder_.File(name)); }, ErrorKind::kIo, {"cannot be written"});
  }
}

// The Float64 numbers of the first DataArray in a .vtp file.
std::vector<double> FirstArray(const std::string& text) {
  const std::size_t begin = text.find('>', text.find("<DataArray type=\"Float64\"")) + 1;
  const std::string encoded = text.substr(begin, text.find('<', begin) - begin);
  std::vector<std::uint8_t> bytes(BASE64_DECODE_LENGTH(encoded.size()));
  std::size_t count = bytes.size();
  base64_decode_ctx context;
  nettle_base64_decode_init(&context);
  EXPECT_EQ(nettle_base64_decode_update(&context, &count, bytes.data(), encoded.size(), encoded.data()), 1);
  EXPECT_EQ(nettle_base64_decode_final(&context), 1);
  std::uint64_t length = 0;
  std::memcpy(&length, bytes.data(), sizeof(length));
  EXPECT_EQ(length, count - sizeof(length));
  std::vector<double> values(length / sizeof(double));
  std::memcpy(values.data(), bytes.data() + sizeof(length), length);
  return values;
}

TEST_F(TrackFileTest, WritesACollectionForParaView) {
  PointTracks tracks = Tracks();
  tracks.positions(4, 1) = kNan;
  WriteTracks(tracks, folder_.File("a & b.pvd"));
  EXPECT_EQ(Names().size(), 13u);
  const std::string collection = Text("a & b.pvd");
  EXPECT_NE(collection.find("<VTKFile type=\"Collection\""), std::string::npos);
  EXPECT_NE(collection.find("<DataSet timestep=\"" + ShortestText(tracks.times[11]) +
                            "\" group=\"\" part=\"0\" file=\"a &amp; b_0011.vtp\"/>"),
            std::string::npos);
  const std::string frame = Text("a & b_0001.vtp");
  EXPECT_NE(frame.find("<Piece NumberOfPoints=\"5\" NumberOfVerts=\"0\" NumberOfLines=\"0\" NumberOfStrips=\"0\" "
                       "NumberOfPolys=\"2\">"),
            std::string::npos);
  const std::vector<double> values = FirstArray(frame);
  ExpectEqual(Eigen::Map<const Eigen::VectorXd>(values.data(), static_cast<Eigen::Index>(values.size())),
              tracks.positions.col(1), 0.0);
  // Two triangles 0 1 2, 1 3 4 as Int32: 24 bytes, and where they end.
  EXPECT_NE(frame.find("<DataArray type=\"Int32\" Name=\"connectivity\" format=\"binary\">"
                       "GAAAAAAAAAAAAAAAAQAAAAIAAAABAAAAAwAAAAQAAAA=</DataArray>"),
            std::string::npos)
      << frame;
  EXPECT_NE(frame.find("Name=\"offsets\" format=\"binary\">CAAAAAAAAAADAAAABgAAAA==<"), std::string::npos) << frame;
  tracks.times.resize(0);
  tracks.faces.resize(3, 0);
  WriteTracks(tracks, folder_.File("b.vtp"));
  EXPECT_NE(Text("b.pvd").find("timestep=\"11\" group=\"\" part=\"0\" file=\"b_0011.vtp\""), std::string::npos);
  EXPECT_NE(Text("b_0000.vtp").find("NumberOfVerts=\"5\""), std::string::npos);
}

}  // namespace
}  // namespace clothid::track_file_test

// PLY files as other programs write them.
#include "datasets/formats/ply_file.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <string>
#include <vector>

#include "tests/expect_error.h"
#include "tests/temporary_folder.h"

namespace clothid::ply_file_test {
namespace {

// Bytes of numbers of any type, in either order.
class Numbers {
 public:
  explicit Numbers(bool is_big_endian) : is_big_endian_(is_big_endian) {}
  template <typename T>
  Numbers& Add(std::initializer_list<T> values) {
    for (const T value : values) {
      std::string number(reinterpret_cast<const char*>(&value), sizeof(T));
      if (is_big_endian_) std::reverse(number.begin(), number.end());
      bytes_ += number;
    }
    return *this;
  }
  const std::string& bytes() const { return bytes_; }

 private:
  bool is_big_endian_;
  std::string bytes_;
};

std::string Header(const std::string& format, const std::string& rest) {
  return "ply\nformat " + format + " 1.0\n" + rest + "end_header\n";
}

constexpr char kTriangle[] =
    "element vertex 3\nproperty float x\nproperty float y\nproperty float z\n"
    "element face 1\nproperty list uchar int vertex_indices\n";

class PlyFileTest : public testing::Test {
 protected:
  Mesh Read(const std::string& bytes) const { return ReadPly(folder_.Write("mesh.ply", bytes)); }
  void ExpectRefused(const std::string& bytes, std::initializer_list<const char*> fragments) const {
    ExpectError([&] { Read(bytes); }, ErrorKind::kBadData, fragments);
  }

  TemporaryFolder folder_;
};

// The cube corner of the specification: comments, colours after the coordinates, a polygon, an element of edges.
TEST_F(PlyFileTest, ReadsAscii) {
  const Mesh mesh = Read(
      "ply\r\nformat ascii 1.0\r\ncomment made by hand\r\nobj_info more\r\nelement vertex 4\r\n"
      "property float32 x\r\nproperty uchar red\r\nproperty double y\r\nproperty float z\r\n"
      "element edge 1\r\nproperty int vertex1\r\nproperty int vertex2\r\n"
      "element face 2\r\nproperty uchar flags\r\nproperty list uint8 int32 vertex_index\r\nend_header\r\n"
      "0 255 0 0\r\n1 0 0 1e-1\r\n1 0 1 0\r\n0 9 nan NaN\r\n0 1\r\n7 4 0 1 2 3\r\n7 3 0 2 3\r\n");
  EXPECT_EQ(mesh.rest_positions.col(1), Eigen::Vector3d(1, 0, 0.1));
  EXPECT_TRUE(std::isnan(mesh.rest_positions(1, 3)));
  Eigen::Matrix3Xi faces(3, 3);
  faces << 0, 0, 0, 1, 2, 2, 2, 3, 3;
  EXPECT_EQ(mesh.faces, faces);
}

// Every type of number, an element before the vertices with a list in it, normals in between, an unknown list of faces.
TEST_F(PlyFileTest, ReadsBothByteOrders) {
  for (const bool is_big_endian : {false, true}) {
    const std::string header = Header(is_big_endian ? "binary_big_endian" : "binary_little_endian",
                                      "element camera 2\nproperty char a\nproperty list ushort short b\n"
                                      "element vertex 3\nproperty double x\nproperty float nx\nproperty float y\n"
                                      "property short z\nelement face 1\nproperty list uchar float texcoord\n"
                                      "property list int uint vertex_indices\nelement last 1\nproperty ushort c\n");
    Numbers numbers(is_big_endian);
    numbers.Add<std::int8_t>({1}).Add<std::uint16_t>({2}).Add<std::int16_t>({5, 6});
    numbers.Add<std::int8_t>({1}).Add<std::uint16_t>({0});
    for (const double x : {0.1, 0.2, 0.3}) {
      numbers.Add<double>({x}).Add<float>({9.0f, static_cast<float>(2 * x)}).Add<std::int16_t>({-300});
    }
    numbers.Add<std::uint8_t>({1}).Add<float>({0.5f}).Add<std::int32_t>({3}).Add<std::uint32_t>({2, 1, 0});
    numbers.Add<std::uint16_t>({1});
    const Mesh mesh = Read(header + numbers.bytes());
    EXPECT_EQ(mesh.rest_positions.col(2), Eigen::Vector3d(0.3, 0.6f, -300));
    EXPECT_EQ(mesh.faces, Eigen::Vector3i(2, 1, 0));
    const std::string whole = header + numbers.bytes();
    for (std::size_t length = header.size(); length < whole.size(); ++length) {
      ExpectRefused(whole.substr(0, length), {"mesh.ply"});
    }
    ExpectRefused(whole + "x", {"mesh.ply: byte ", "expected the file to end"});
  }
}

TEST_F(PlyFileTest, ReadsCloudsWithoutFaces) {
  const std::string vertex = "element vertex 1\nproperty float x\nproperty float y\nproperty float z\n";
  EXPECT_EQ(Read(Header("ascii", vertex) + "1 2 3").rest_positions.col(0), Eigen::Vector3d(1, 2, 3));
  EXPECT_EQ(Read(Header("ascii", vertex + "element face 0\nproperty list uchar int vertex_indices\n") + "1 2 3\n\n")
                .num_faces(),
            0);
  EXPECT_EQ(Read(Header("ascii", vertex + "element nothing 9000000000000000000\n") + "1 2 3\n").num_nodes(), 1);
}

double Area(const Mesh& mesh) { return TriangleAreas(mesh).sum(); }

// An L whose fan about five of its six corners is larger than it.
TEST_F(PlyFileTest, CutsPolygonsThatAreNotConvex) {
  const std::vector<double> places = {0, 0, 0.2, 0, 0.2, 0.1, 0.1, 0.1, 0.1, 0.2, 0, 0.2};
  const std::string vertex = "element vertex 6\nproperty double x\nproperty double y\nproperty double z\n";
  const std::string face = "element face 1\nproperty list uchar int vertex_indices\n";
  for (int first = 0; first < 6; ++first) {
    for (const bool is_reversed : {false, true}) {
      std::string vertices, corners = "6";
      Numbers little(false), big(true), little_face(false), big_face(true);
      for (Numbers* numbers : {&little_face, &big_face}) numbers->Add<std::uint8_t>({6});
      for (std::size_t i = 0; i < 6; ++i) {
        for (Numbers* numbers : {&little, &big}) numbers->Add<double>({places[2 * i], places[2 * i + 1], 0.5});
        vertices += std::to_string(places[2 * i]) + " " + std::to_string(places[2 * i + 1]) + " 0.5\n";
        const int corner = (is_reversed ? first + 6 - static_cast<int>(i) : first + static_cast<int>(i)) % 6;
        corners += " " + std::to_string(corner);
        for (Numbers* numbers : {&little_face, &big_face}) numbers->Add<std::int32_t>({corner});
      }
      for (const std::string& file :
           {Header("ascii", vertex + face) + vertices + corners + "\n",
            Header("ascii", face + vertex) + corners + "\n" + vertices,
            Header("binary_little_endian", vertex + face) + little.bytes() + little_face.bytes(),
            Header("binary_big_endian", face + vertex) + big_face.bytes() + big.bytes()}) {
        const Mesh mesh = Read(file);
        EXPECT_EQ(mesh.num_faces(), 4);
        EXPECT_NEAR(Area(mesh), 0.03, 1e-15);
        EXPECT_NO_THROW(ValidateMesh(mesh, "L"));
      }
    }
  }
}

TEST_F(PlyFileTest, RefusesPolygonsThatCrossThemselves) {
  const std::string counts = "element vertex 4\nproperty float x\nproperty float y\nproperty float z\n";
  const std::string faces = "element face 2\nproperty list uchar int vertex_indices\n";
  ExpectRefused(Header("ascii", counts + faces) + "0 0 0\n1 0 0\n1 1 0\n0 1 0\n4 0 1 2 3\n4 0 2 1 3\n",
                {"mesh.ply:15: the polygon of 4 corners crosses or touches itself, or has no area"});
  ExpectRefused(Header("ascii", faces + counts) + "4 0 1 2 3\n4 0 2 1 3\n0 0 0\n1 0 0\n1 1 0\n0 1 0\n",
                {"mesh.ply:11: the polygon of 4 corners"});
  Numbers numbers(false);
  numbers.Add<float>({0, 0, 0, 1, 0, 0, 1, 1, 0, 0, 1, 0});
  for (const std::vector<int>& corners : {std::vector<int>{0, 1, 2, 3}, std::vector<int>{0, 2, 1, 3}}) {
    numbers.Add<std::uint8_t>({4});
    for (const int corner : corners) numbers.Add<std::int32_t>({corner});
  }
  ExpectRefused(Header("binary_little_endian", counts + faces) + numbers.bytes(),
                {"mesh.ply: face 1: the polygon of 4 corners crosses or touches itself"});
}

// Whatever the faces are, and whatever stands beside x, y and z.
TEST_F(PlyFileTest, ReadsPointsAlone) {
  const std::string header = Header("ascii",
                                    "element vertex 4\nproperty float nx\nproperty float x\nproperty float y\n"
                                    "property float z\nproperty uchar red\nelement face 1\n"
                                    "property list uchar int vertex_indices\n");
  const std::string text = header + "nan 1 2 3 255\n-inf 4 5 6 0\n0 inf 0 0 0\n0 nan 0 0 0\n4 0 2 9 3\n";
  const Eigen::Matrix3Xd points = ReadPlyPoints(folder_.Write("cloud.ply", text));
  ASSERT_EQ(points.cols(), 4);
  EXPECT_EQ(points.col(1), Eigen::Vector3d(4, 5, 6));
  EXPECT_TRUE(std::isnan(points(0, 2)));
  EXPECT_TRUE(std::isnan(points(0, 3)));
  ExpectRefused(text, {"mesh.ply:14: vertex 2: expected finite numbers"});
}

TEST_F(PlyFileTest, WritesBinaryWithEveryDigit) {
  Eigen::Matrix3Xd positions(3, 4);
  positions << 0.1, 1, 1.0 / 3.0, -1e-300, 0, 2, 5, NAN, 0, 3, 6, 1;
  Eigen::Matrix3Xi faces(3, 2);
  faces << 0, 0, 1, 2, 2, 3;
  const Mesh mesh = Read(PlyBytes(positions, faces));
  EXPECT_TRUE(std::isnan(mesh.rest_positions(1, 3)));
  EXPECT_EQ(mesh.rest_positions.leftCols(3), positions.leftCols(3));
  EXPECT_EQ(mesh.faces, faces);
  EXPECT_EQ(Read(PlyBytes(positions, Eigen::Matrix3Xi(3, 0))).num_faces(), 0);
}

TEST_F(PlyFileTest, RefusesBadHeaders) {
  ExpectRefused("", {"mesh.ply:1: expected 'end_header'"});
  ExpectRefused("v 0 0 0\n", {"mesh.ply:1: is not a PLY file"});
  ExpectRefused("ply\nformat binary 1.0\n", {"mesh.ply:2: expected 'format'"});
  ExpectRefused("ply\nformat ascii 2.0\n", {"mesh.ply:2: expected version 1.0, found '2.0'"});
  ExpectRefused("ply\nformat ascii 1.0\nelement vertex 1\n", {"mesh.ply:4: expected 'end_header'"});
  ExpectRefused(Header("ascii", "elements\n"), {"mesh.ply:3: ", "found 'elements'"});
  ExpectRefused(Header("ascii", "property float x\n"), {"mesh.ply:3: expected an element before"});
  ExpectRefused(Header("ascii", "element vertex -1\n"), {"mesh.ply:3: ", "'-1'"});
  ExpectRefused(Header("ascii", "element vertex inf\n"), {"mesh.ply:3: ", "'inf'"});
  ExpectRefused(Header("ascii", "element vertex 1\nproperty real x\n"), {"mesh.ply:4: ", "'real'"});
  ExpectRefused(Header("ascii", "element vertex 1\nproperty float\n"), {"mesh.ply:4: expected a name"});
  ExpectRefused(Header("ascii", "element face 1\nproperty list float int vertex_index\n"), {"mesh.ply:4: ", "integer"});
  ExpectRefused(Header("ascii", "element vertex 1\nproperty float x\nproperty float y\n") + "0 0", {"lacks", "'z'"});
  ExpectRefused(Header("ascii", "element face 0\n"), {"mesh.ply: has no element 'vertex'"});
}

TEST_F(PlyFileTest, RefusesBadNumbers) {
  const std::string header = Header("ascii", kTriangle);
  EXPECT_NO_THROW(Read(header + "0 0 0 1 0 0 0 1 0 3 0 1 2"));
  ExpectRefused(header + "0 0 0\n1 zero 0\n0 1 0\n3 0 1 2\n", {"mesh.ply:11: expected a number, found 'zero'"});
  ExpectRefused(header + "0 0 0\n1 0 0\n0 1 inf\n3 0 1 2\n", {"mesh.ply:12: vertex 2: expected finite numbers"});
  ExpectRefused(header + "0 0 0\n1 0 0\n0 1 0\n3 0 1\n", {"mesh.ply:14: ends before"});
  ExpectRefused(header + "0 0 0\n1 0 0\n0 1 0\n3 0 1 3\n", {"mesh.ply: a face refers to vertex 3; expected 0 to 2"});
  ExpectRefused(header + "0 0 0\n1 0 0\n0 1 0\n3 0 1 -1\n", {"mesh.ply:13: expected the corners"});
  ExpectRefused(header + "0 0 0\n1 0 0\n0 1 0\n3 0 1 0.5\n", {"mesh.ply:13: expected the corners"});
  ExpectRefused(header + "0 0 0\n1 0 0\n0 1 0\n2 0 1\n", {"mesh.ply:13: expected at least three corners"});
  ExpectRefused(header + "0 0 0\n1 0 0\n0 1 0\n-3 0 1 2\n", {"mesh.ply:13: the length of 'vertex_indices'"});
  ExpectRefused(header + "0 0 0\n1 0 0\n0 1 0\n300 0 1 2\n", {"mesh.ply:13: the length of 'vertex_indices'"});
  ExpectRefused(header + "0 0 0\n1 0 0\n0 1 0\nnan 0 1 2\n", {"mesh.ply:13: the length of 'vertex_indices'"});
  ExpectRefused(header + "0 0 0\n1 0 0\n0 1 0\n3 0 1 2\n5\n", {"mesh.ply:14: expected the file to end"});
  const std::string many = "element vertex 3999999\nproperty float x\nproperty float y\nproperty float z\n";
  ExpectRefused(Header("binary_little_endian", many) + "123", {"3999999 vertices are more than the file holds"});
  Numbers numbers(false);
  numbers.Add<float>({0, 0, 0, 1, 0, HUGE_VALF});
  ExpectRefused(Header("binary_little_endian", kTriangle) + numbers.bytes(), {"mesh.ply: byte ", "vertex 1: expected"});
}

}  // namespace
}  // namespace clothid::ply_file_test

// Pieces of a cloth: in a scene, in an OBJ file, on a finer mesh; the names of their parameters.
#include "sim/scene/pieces.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <string>

#include "sim/scene/refinement.h"
#include "sim/scene/scene_json.h"
#include "tests/expect_error.h"
#include "tests/temporary_folder.h"

namespace clothid::pieces_json_test {
namespace {

constexpr ErrorKind kBadData = ErrorKind::kBadData;
const char* const kTwoPieces = R"({"a": {"triangles": [[0, 2], 5], "k_stretch": 200}, "b": {"triangles": [3]}})";
const char* const kObj = R"(v 0 0 0
v 1 0 0
v 0 1 0
v 1 1 0
v 0 2 0
v 1 2 0
f 1 2 3
g sleeve
usemtl denim
f 3 2 4
g body lining
f 3 4 6 5
g empty
)";

// 8 triangles.
std::string Text(const std::string& pieces, const std::string& more = "",
                 const std::string& mesh = R"({"grid": {"nodes": [3, 3], "size": [0.2, 0.2]}})") {
  return R"({"clothid_scene": 2, "duration": 1, "mesh": )" + mesh + R"(, "pieces": )" + pieces + more + "}";
}

Scene Read(const std::string& pieces, const std::string& more = "") {
  return ParseScene(Text(pieces, more), "scene.json", "");
}

void ExpectBad(const std::string& pieces, const std::string& fragment, const std::string& more = "") {
  ExpectError([&] { Read(pieces, more); }, kBadData, {"scene.json", fragment.c_str()});
}

TEST(ReadPieces, GivesTrianglesAndWhatIsNotTheScenes) {
  const Scene scene = Read(kTwoPieces, R"(, "materials": {"k_stretch": 50, "density": 0.2})");
  EXPECT_EQ(scene.mesh.piece_names, (std::vector<std::string>{"a", "b"}));
  EXPECT_EQ(scene.mesh.face_pieces, (std::vector<int>{0, 0, 0, 1, 2, 0, 2, 2}));
  ASSERT_EQ(scene.pieces.size(), 3u);
  EXPECT_EQ(scene.pieces[0].stretch_stiffness, 200.0);
  EXPECT_EQ(scene.pieces[1].stretch_stiffness, 50.0);
  EXPECT_EQ(scene.pieces[2].stretch_stiffness, 50.0);
  for (const Material& piece : scene.pieces) EXPECT_EQ(piece.density, 0.2);
  EXPECT_TRUE(Read(kTwoPieces).nominal_parameters().pieces == Read(kTwoPieces).pieces);
}

// A piece may have a term that the scene has not; then the model has it.
TEST(ReadPieces, MayBendWhereTheOthersDoNot) {
  const Scene scene = Read(R"({"a": {"triangles": [0], "k_bend": 1e-5}, "b": {"triangles": [1]}})");
  EXPECT_TRUE(scene.has_bending());
  EXPECT_EQ(scene.pieces[0].bending_stiffness, 1e-5);
  EXPECT_EQ(scene.pieces[1].bending_stiffness, 0.0);
  const Eigen::VectorXd weights =
      PieceWeights(scene.nominal_parameters(), ParameterKind::kBendingStiffness, scene.mesh);
  EXPECT_EQ(weights[0], 1.0);
  EXPECT_EQ(weights.tail(7).maxCoeff(), 0.0);
  EXPECT_FALSE(Read(kTwoPieces).has_bending());
}

TEST(ReadPieces, NamesWhatIsWrong) {
  ExpectBad("{}", "'pieces': expected at least one piece");
  ExpectBad("[1]", "'pieces': expected an object");
  ExpectBad(R"({"a b": {"triangles": [0]}})", "expected a name of letters, digits, '_' and '-'");
  ExpectBad(R"({"a": {"triangles": []}})", "'pieces.a.triangles': expected at least one triangle");
  ExpectBad(R"({"a": {"triangles": [8]}})", "'pieces.a.triangles[0]': expected an integer from 0 to 7");
  ExpectBad(R"({"a": {"triangles": [[3, 2]]}})", "expected the first triangle before the last");
  ExpectBad(R"({"a": {"triangles": [[3]]}})", "expected a triangle, or the first and the last");
  ExpectBad(R"({"a": {"triangles": [1]}, "b": {"triangles": [[0, 4]]}})",
            "'pieces.b': triangle 1 is in piece 'a', too");
  ExpectBad(R"({"a": {"triangles": [1, 1]}})", "triangle 1 is in piece 'a', too");
  ExpectBad(R"({"a": {"k_stretch": 10}})",
            "'pieces.a': expected \"triangles\": [..] in it, or a mesh from an OBJ file");
  ExpectBad(R"({"a": {"triangles": [0], "k_stretch": 0}})", "'pieces.a.k_stretch': expected a finite number > 0");
  ExpectBad(R"({"a": {"triangles": [0], "k_warp": 10}})", "'pieces.a.k_warp': the scene has no such term");
  ExpectBad(R"({"a": {"triangles": [0], "added_mass": 1}})",
            "'pieces.a.added_mass': expected triangles, or a constant");
  ExpectBad(R"({"a": {"triangles": [0], "mu": 1}})", "'pieces.a.mu'");
  ExpectBad(R"({"a": {"triangles": [0], "density": 1}})", "'pieces.a.density': expected none beside 'fields.density'",
            R"(, "fields": {"density": [[0.1, 0.2]]})");
  ExpectBad(R"({"a": {"triangles": [0]}})", "unknown parameter 'k_stretch.c'",
            R"(, "parameters": {"k_stretch.c": {"lower": 1}})");
}

// Every elastic energy of its own must be positive.
TEST(ReadPieces, NamesThePieceWhoseEnergyIsNegative) {
  const std::string woven =
      R"(, "materials": {"membrane": "orthotropic", "k_warp": 10, "k_weft": 10, "k_shear": 5, "k_poisson": 4})";
  EXPECT_EQ(Read(R"({"a": {"triangles": [0], "k_poisson": -5}})", woven).pieces[0].poisson_stiffness, -5.0);
  ExpectBad(R"({"a": {"triangles": [0], "k_warp": 1}})", "in piece 'a' k_poisson^2 must be below k_warp k_weft", woven);
}

TEST(ReadPieces, TakesTheGroupsOfAnObjFile) {
  const TemporaryFolder folder;
  folder.Write("cloth.obj", kObj);
  const auto read = [&](const std::string& pieces) {
    return ParseScene(Text(pieces, "", R"({"obj": "cloth.obj"})"), "scene.json", folder.path());
  };
  const Scene scene = read(R"({"sleeve": {"density": 0.3}, "body": {}})");
  EXPECT_EQ(scene.mesh.face_pieces, (std::vector<int>{2, 0, 1, 1}));
  EXPECT_EQ(scene.pieces[0].density, 0.3);
  EXPECT_EQ(read(R"({"denim": {}})").mesh.face_pieces, (std::vector<int>{1, 0, 0, 0}));
  EXPECT_EQ(read(R"({"lining": {}})").mesh.face_pieces, (std::vector<int>{1, 1, 0, 0}));
  const auto expect_bad = [&](const std::string& pieces, const char* fragment) {
    ExpectError([&] { read(pieces); }, kBadData, {"scene.json", fragment});
  };
  expect_bad(R"({"cuff": {}})",
             "'pieces.cuff': the mesh has no such group; expected one of body, denim, lining, sleeve");
  expect_bad(R"({"empty": {}})", "'pieces.empty': no triangle of the mesh is in that group");
  expect_bad(R"({"sleeve": {}, "denim": {}})", "'pieces.denim': triangle 1 is in piece 'sleeve', too");

  // A recording brings the mesh, the file its groups; it has to have the same triangles.
  SceneDefaults recorded;
  recorded.has_mesh = true;
  recorded.mesh = ReadObj(folder.File("cloth.obj"));
  recorded.initial_positions = recorded.mesh.rest_positions.reshaped();
  recorded.duration = 1.0;
  const std::string text = Text(R"({"sleeve": {}})", "", R"({"obj": "cloth.obj"})");
  EXPECT_EQ(ParseScene(text, "scene.json", folder.path(), recorded).mesh.face_pieces, (std::vector<int>{1, 0, 1, 1}));
  recorded.mesh.faces.col(0) = Eigen::Vector3i(1, 2, 0);
  ExpectError([&] { ParseScene(text, "scene.json", folder.path(), recorded); }, kBadData,
              {"'mesh.obj': expected the triangles of the recording, whose pieces are to be groups"});
}

TEST(PieceParameters, HaveNames) {
  const Scene scene =
      Read(kTwoPieces, R"(, "parameters": {"density": {"nominal": 0.4}, "density.b": {"nominal": 0.6}})");
  const ParameterId id = ParseParameter("k_stretch.b", scene);
  EXPECT_EQ(id, (ParameterId{ParameterKind::kStretchStiffness, 0, 1}));
  EXPECT_EQ(ParameterName(id, {}, scene.mesh.piece_names), "k_stretch.b");
  ExpectError([&] { ParseParameter("k_stretch.c", scene); }, ErrorKind::kUsage,
              {"unknown parameter 'k_stretch.c'", "as in density.a, density.b"});
  ExpectError([&] { ParseParameter("k_warp.a", scene); }, ErrorKind::kUsage, {"the scene has no such term"});
  ExpectError([&] { ParseParameter("added_mass.a", scene); }, ErrorKind::kUsage, {"unknown parameter"});
  ExpectError([&] { ParseParameter("k_stretch.a", std::vector<std::string>()); }, ErrorKind::kUsage, {"unknown"});
  const Parameters nominal = scene.nominal_parameters();
  EXPECT_EQ(GetParameter(nominal, ParseParameter("density.a", scene)), 0.4);
  EXPECT_EQ(GetParameter(nominal, ParseParameter("density.b", scene)), 0.6);
  EXPECT_TRUE(Includes(ParseParameter("density", scene), ParseParameter("density.b", scene)));
  EXPECT_FALSE(Includes(ParseParameter("density.b", scene), ParseParameter("density", scene)));
  EXPECT_FALSE(Includes(ParseParameter("density", scene), ParseParameter("k_stretch.b", scene)));
}

TEST(PieceParameters, OfTheWholeSetEveryPiece) {
  const Scene scene = Read(kTwoPieces);
  Parameters parameters = scene.nominal_parameters();
  SetParameter(ParseParameter("k_stretch", scene), 70.0, &parameters);
  for (const Material& piece : parameters.pieces) EXPECT_EQ(piece.stretch_stiffness, 70.0);
  SetParameter(ParseParameter("k_stretch.a", scene), 90.0, &parameters);
  EXPECT_EQ(GetParameter(parameters, ParseParameter("k_stretch", scene)), 70.0);
  EXPECT_EQ(GetParameter(parameters, ParseParameter("k_stretch.a", scene)), 90.0);
  EXPECT_EQ(GetParameter(parameters, ParseParameter("k_stretch.b", scene)), 70.0);
  parameters.pieces[1].density = -1.0;
  ExpectError([&] { ValidateParameters(parameters, scene, "test"); }, kBadData,
              {"test: parameter 'density.b' is -1.0", "expected a finite number > 0"});
  parameters.pieces[1] = parameters.material;
  parameters.pieces[1].added_mass = 0.1;
  ExpectError([&] { ValidateParameters(parameters, scene, "test"); }, kBadData, {"'added_mass.b'", "whole cloth"});
  parameters.pieces.pop_back();
  ExpectError([&] { ValidateParameters(parameters, scene, "test"); }, kBadData, {"a material for every piece"});
}

// The constant that is a field is the same in all pieces.
TEST(PieceParameters, AreNoneOfAField) {
  const Scene scene = Read(kTwoPieces, R"(, "fields": {"density": [[0.1, 0.2]]})");
  ExpectError([&] { ParseParameter("density.a", scene); }, ErrorKind::kUsage, {"density.a"});
  EXPECT_EQ(ParseParameter("k_stretch.a", scene).part, 0);
  EXPECT_EQ(scene.pieces[0].density, scene.material.density);
}

TEST(MeanMaterial, HasTheMassOfTheCloth) {
  const Scene scene = Read(R"({"a": {"triangles": [[0, 5]], "density": 0.4, "k_stretch": 10}})");
  const Material mean = MeanMaterial(scene.nominal_parameters(), scene.mesh);
  EXPECT_NEAR(mean.density, 0.75 * 0.4 + 0.25 * 0.15, 1e-15);
  EXPECT_NEAR(mean.stretch_stiffness, 0.75 * 10.0 + 0.25 * 100.0, 1e-13);
  EXPECT_EQ(mean.added_mass, scene.material.added_mass);
}

TEST(ValidatePieces, NamesWhatIsMissing) {
  Scene scene = Read(kTwoPieces);
  const auto expect = [](const Scene& wrong, const char* fragment) {
    ExpectError([&] { ValidateScene(wrong, "hand"); }, kBadData, {"hand: key 'pieces", fragment});
  };
  Scene wrong = scene;
  wrong.pieces.clear();
  expect(wrong, "a material for every piece");
  wrong = scene;
  wrong.mesh.face_pieces.pop_back();
  expect(wrong, "one of every triangle");
  wrong = scene;
  wrong.mesh.face_pieces[0] = 3;
  expect(wrong, "that are there");
  wrong = scene;
  wrong.mesh.piece_names[1] = "a";
  expect(wrong, "no other piece has");
  wrong = scene;
  std::replace(wrong.mesh.face_pieces.begin(), wrong.mesh.face_pieces.end(), 1, 2);
  expect(wrong, "at least one triangle");
}

TEST(RefineMesh, KeepsThePieces) {
  const Scene scene = Read(kTwoPieces);
  const Scene fine = RefineScene(scene, RefineMesh(scene.mesh));
  EXPECT_NO_THROW(ValidateScene(fine, "fine"));
  ASSERT_EQ(fine.mesh.face_pieces.size(), 32u);
  for (std::size_t f = 0; f < 32; ++f) EXPECT_EQ(fine.mesh.face_pieces[f], scene.mesh.face_pieces[f / 4]);
}

}  // namespace
}  // namespace clothid::pieces_json_test

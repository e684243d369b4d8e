#include "sim/scene/scene_json.h"

#include <gtest/gtest.h>

#include <cmath>
#include <cstdint>
#include <filesystem>

#include "tests/expect_error.h"
#include "tests/temporary_folder.h"

namespace clothid::scene_json_test {
namespace {

constexpr ErrorKind kBadData = ErrorKind::kBadData;

constexpr char kFull[] = R"({
  "clothid_scene": 1, "time_step": 0.01, "integrator": "sdirk2", "duration": 0.5, "gravity": [0, 1, -9], "contact": "velocity", "touch": 1e-4,
  "depenetration_speed": 2,
  "wind": {"mean": [1, 2, 3], "gust": [4, 5, 6], "frequency": 7, "wave_vector": [8, 9, 10]}, "node_force": [0, 0, 0.5],
  "mesh": {"grid": {"nodes": [4, 3], "size": [0.6, 0.2], "origin": [1, 2, 3], "axes": [[0, 1, 0], [0, 0, 1]]}},
  "initial": {"positions": "rest", "velocity": [1, 0, 2]},
  "handles": [0, 8],
  "obstacles": [ {"name": "ball", "type": "sphere", "center": [0, 0, 1], "radius": 0.2, "mu": 0.4, "contact_distance": 0.01},
                 {"type": "plane", "point": [0, 0, -1], "normal": [0, 0, 2]},
                 {"type": "capsule", "from": [0, 0, 0], "to": [1, 0, 0], "radius": 0.1, "mu": 0},
                 {"type": "plane", "point": [0, 0, -2], "normal": [0, 0, 2], "mu": 0.1} ],
  "materials": {"density": 0.2, "k_stretch": 300, "k_bend": 1e-3, "bending": "patches", "bend_poisson": -0.2,
                "drag": 0.1, "damping": 0.2},
  "parameters": {"k_stretch": {"nominal": 100, "lower": 1, "upper": 1e6, "frozen": true}, "mu": {"nominal": 0.6},
                 "mu.ball": {"nominal": 0.7}, "drag": {}, "damping": {"nominal": 0.3}},
  "solver": {"step_tolerance": 1e-6, "adjoint_tolerance": 1e-11, "max_newton_iterations": 7, "max_substep_halvings": 0}
})";

constexpr char kGrid[] = R"("mesh": {"grid": {"nodes": [3, 3], "size": [0.2, 0.2]}})";

// A small scene with `members` in line 2.
std::string SmallScene(const std::string& members) {
  return std::string("{\"clothid_scene\": 1, \"duration\": 1, ") + kGrid + (members.empty() ? "" : ",\n") + members +
         "}";
}

void ExpectBad(const std::string& text, std::initializer_list<const char*> fragments) {
  ExpectError([&] { ParseScene(text, "scene.json", ""); }, kBadData, fragments);
}

void ExpectBadMember(const std::string& members, std::initializer_list<const char*> fragments) {
  ExpectBad(SmallScene(members), fragments);
}

TEST(ParseScene, ReadsEveryKey) {
  const Scene scene = ParseScene(kFull, "scene.json", "");
  EXPECT_EQ(scene.time_step, 0.01);
  EXPECT_EQ(scene.integrator, Integrator::kSdirk2);
  EXPECT_EQ(scene.duration, 0.5);
  EXPECT_EQ(scene.num_steps(), 50);
  EXPECT_EQ(scene.start_time, 0.0);
  EXPECT_EQ(scene.gravity, Eigen::Vector3d(0, 1, -9));
  EXPECT_EQ(scene.contact_mode, ContactMode::kVelocity);
  EXPECT_EQ(scene.touch, 1e-4);
  EXPECT_EQ(scene.depenetration_speed, 2.0);
  EXPECT_EQ(scene.wind.mean, Eigen::Vector3d(1, 2, 3));
  EXPECT_EQ(scene.wind.gust, Eigen::Vector3d(4, 5, 6));
  EXPECT_EQ(scene.wind.frequency, 7.0);
  EXPECT_EQ(scene.wind.wave_vector, Eigen::Vector3d(8, 9, 10));
  EXPECT_EQ(scene.node_force, Eigen::Vector3d(0, 0, 0.5));
  EXPECT_EQ(scene.mesh.num_nodes(), 12);
  EXPECT_LT((scene.mesh.rest_positions.col(11) - Eigen::Vector3d(1, 2.6, 3.2)).norm(), 1e-15);
  EXPECT_EQ(scene.initial_positions, scene.mesh.rest_positions.reshaped());
  EXPECT_EQ(scene.initial_velocities.segment<3>(15), Eigen::Vector3d(1, 0, 2));
  EXPECT_EQ(scene.handles.nodes, (std::vector<int>{0, 8}));
  EXPECT_EQ(scene.handles.path.times().size(), 0);
  EXPECT_EQ(scene.material.density, 0.2);
  EXPECT_EQ(scene.material.stretch_stiffness, 300.0);
  EXPECT_EQ(scene.material.bending_stiffness, 1e-3);
  EXPECT_EQ(scene.bending.law, BendingLaw::kPatches);
  EXPECT_EQ(scene.bending.poisson, -0.2);
  EXPECT_EQ(scene.material.drag, 0.1);
  EXPECT_EQ(scene.material.damping, 0.2);
  EXPECT_EQ(scene.solver.step_tolerance, 1e-6);
  EXPECT_EQ(scene.solver.adjoint_tolerance, 1e-11);
  EXPECT_EQ(scene.solver.max_newton_iterations, 7);
  EXPECT_EQ(scene.solver.max_substep_halvings, 0);
}

TEST(ParseScene, ReadsObstaclesAndNamesThem) {
  const Scene scene = ParseScene(kFull, "scene.json", "");
  EXPECT_EQ(scene.obstacle_names(), (std::vector<std::string>{"ball", "plane", "capsule", "plane2"}));
  EXPECT_EQ(scene.obstacles[0].contact_distance, 0.01);
  EXPECT_EQ(scene.obstacles[1].friction_coefficient, 0.3);
  EXPECT_EQ(scene.obstacles[2].friction_coefficient, 0.0);
  const Eigen::Vector3d origin = Eigen::Vector3d::Zero();
  EXPECT_DOUBLE_EQ(scene.obstacles[0].shape->Closest(origin).gap, 0.8);
  EXPECT_DOUBLE_EQ(scene.obstacles[1].shape->Closest(origin).gap, 1.0);
  EXPECT_DOUBLE_EQ(scene.obstacles[2].shape->Closest({0.5, 0.5, 0.0}).gap, 0.4);
}

TEST(ParseScene, NominalValuesOverrideTheMaterial) {
  const Scene scene = ParseScene(kFull, "scene.json", "");
  const Parameters nominal = scene.nominal_parameters();
  EXPECT_EQ(nominal.material.stretch_stiffness, 100.0);
  EXPECT_EQ(nominal.material.density, 0.2);
  EXPECT_EQ(nominal.material.drag, 0.1);
  EXPECT_EQ(nominal.material.damping, 0.3);
  EXPECT_EQ(nominal.friction_coefficients, (std::vector<double>{0.7, 0.6, 0.6, 0.6}));
  EXPECT_TRUE(scene.parameters.at("k_stretch").frozen);
  EXPECT_EQ(scene.parameters.at("k_stretch").upper_bound, 1e6);
  EXPECT_TRUE(std::isnan(scene.parameters.at("drag").nominal));
  EXPECT_FALSE(scene.parameters.at("mu").frozen);
}

// A scene that was written when there was no other means what it meant.
TEST(ParseScene, VersionOneIsThatOfThePaper) {
  std::string text = SmallScene("");
  for (const auto& [version, integrator, law] : {std::tuple('1', Integrator::kEuler, BendingLaw::kEdges),
                                                 std::tuple('2', Integrator::kSdirk2, BendingLaw::kPatches)}) {
    text[text.find("clothid_scene\": ") + 16] = version;
    const Scene scene = ParseScene(text, "scene.json", "");
    EXPECT_EQ(scene.integrator, integrator);
    EXPECT_EQ(scene.bending.law, law);
  }
  EXPECT_EQ(Scene().integrator, Integrator::kSdirk2);
  EXPECT_EQ(Scene().bending.law, BendingLaw::kPatches);
  text[text.find("clothid_scene\": ") + 16] = '3';
  ExpectError([&] { ParseScene(text, "scene.json", ""); }, kBadData, {"clothid_scene", "expected version 1 or 2"});
}

TEST(ParseScene, ASmallSceneHasDefaults) {
  const Scene scene = ParseScene(SmallScene(""), "scene.json", "");
  EXPECT_EQ(scene.integrator, Integrator::kEuler);
  EXPECT_EQ(scene.contact_mode, ContactMode::kGap);
  EXPECT_EQ(scene.initial_velocities, Eigen::VectorXd::Zero(27));
  EXPECT_TRUE(scene.handles.nodes.empty());
  EXPECT_TRUE(scene.obstacles.empty());
  EXPECT_FALSE(scene.has_bending());
  EXPECT_EQ(scene.bending.law, BendingLaw::kEdges);
  EXPECT_EQ(scene.bending.poisson, 0.0);
  EXPECT_FALSE(scene.has_drag());
  EXPECT_FALSE(scene.has_damping());
}

TEST(ParseScene, RefusesAnIntegratorThatItDoesNotKnow) {
  EXPECT_EQ(ParseScene(SmallScene("\"integrator\": \"euler\""), "scene.json", "").integrator, Integrator::kEuler);
  for (const char* member : {"\"integrator\": \"verlet\"", "\"integrator\": 2", "\"integrator\": null"}) {
    ExpectBadMember(member, {"scene.json:2: key 'integrator': expected \"euler\" or \"sdirk2\""});
  }
}

TEST(ParseScene, AScenesTermsAreThoseOfAPositiveNominalValue) {
  EXPECT_TRUE(ParseScene(SmallScene("\"materials\": {\"damping\": 0.1}"), "scene.json", "").has_damping());
  EXPECT_TRUE(
      ParseScene(SmallScene("\"parameters\": {\"damping\": {\"nominal\": 0.1}}"), "scene.json", "").has_damping());
}

TEST(ParseScene, NamesWhatIsWrongWithTheLawOfBending) {
  const auto expect = [](const std::string& members, const char* fragment) {
    ExpectBadMember("\"materials\": {" + members + "}", {"scene.json:2: key 'materials.", fragment});
  };
  expect(R"("bending": "plates")", "bending': expected \"edges\" or \"patches\"");
  expect(R"("bending": 1)", "bending': expected \"edges\" or \"patches\"");
  for (const char* number : {"1", "-1", "7", "\"0.3\""}) {
    expect(std::string(R"("bending": "patches", "bend_poisson": )") + number,
           "bend_poisson': expected a number between -1 and 1");
  }
  expect(R"("bending": "edges", "bend_poisson": 0)", "bend_poisson': expected \"bending\": \"patches\" beside it");
  Scene scene = ParseScene(SmallScene(""), "scene.json", "");
  scene.bending = {BendingLaw::kPatches, 0.3};
  ValidateScene(scene, "scene");
  scene.bending.poisson = std::nan("");
  ExpectError([&] { ValidateScene(scene, "scene"); }, kBadData, {"'materials.bend_poisson'", "between -1 and 1"});
  scene.bending = {BendingLaw::kEdges, 0.3};
  ExpectError([&] { ValidateScene(scene, "scene"); }, kBadData, {"'materials.bend_poisson'", "bending by patches"});
}

TEST(Scene, CountsTheStepsThatCoverTheDuration) {
  Scene scene;
  const auto steps = [&](double time_step, double duration) {
    scene.time_step = time_step;
    scene.duration = duration;
    return scene.num_steps();
  };
  EXPECT_EQ(steps(0.1, 0.3), 3);
  EXPECT_EQ(steps(0.005, 1.0), 200);
  EXPECT_EQ(steps(0.1, 0.31), 4);
  EXPECT_EQ(steps(0.1, 0.01), 1);
}

constexpr char kTetrahedron[] = R"({"type": "mesh", "mu": 0.2,
  "vertices": [[0, 0, 0], [1, 0, 0], [0, 1, 0], [0, 0, 1]],
  "faces": [[0, 2, 1], [0, 1, 3], [0, 3, 2], [1, 2, 3]]})";

std::string SceneWithObstacle(const std::string& obstacle) { return SmallScene("\"obstacles\": [" + obstacle + "]"); }

TEST(ParseScene, ReadsSurfacesFromTheTextAndFromFiles) {
  const TemporaryFolder folder;
  folder.Write("tetrahedron.obj", "v 0 0 0\nv 1 0 0\nv 0 1 0\nv 0 0 1\nf 1 3 2\nf 1 2 4\nf 1 4 3\nf 2 3 4\n");
  const std::string from_file = R"({"type": "mesh", "obj": "tetrahedron.obj", "mu": 0.2})";
  for (const std::string& text : {SceneWithObstacle(kTetrahedron), SceneWithObstacle(from_file)}) {
    const Scene scene = ParseScene(text, "scene.json", folder.path());
    EXPECT_EQ(scene.obstacle_names(), std::vector<std::string>{"mesh"});
    EXPECT_EQ(scene.obstacles[0].friction_coefficient, 0.2);
    EXPECT_DOUBLE_EQ(scene.obstacles[0].shape->Closest({0.1, 0.1, -0.5}).gap, 0.5);
    EXPECT_DOUBLE_EQ(scene.obstacles[0].shape->Closest({0.1, 0.1, 0.02}).gap, -0.02);
  }
}

TEST(ParseScene, NamesWhatIsWrongWithASurface) {
  const auto expect = [](const std::string& before, const std::string& after,
                         std::initializer_list<const char*> fragments) {
    std::string obstacle = kTetrahedron;
    obstacle.replace(obstacle.find(before), before.size(), after);
    ExpectBad(SceneWithObstacle(obstacle), fragments);
  };
  expect("[0, 0, 1]", "[0, 0]", {"scene.json:3: key 'obstacles[0].vertices[3]': expected an array of three numbers"});
  expect("[0, 0, 1]", "[0, 0, 0]",
         {"scene.json:4: key 'obstacles[0].faces[1]': triangulated surface: triangle 1 has no area"});
  expect("1, 3]", "1, 4]", {"scene.json:4: key 'obstacles[0].faces[1][2]': expected an integer from 0 to 3"});
  expect("1, 3]", "1, 3, 2]", {"scene.json:4: key 'obstacles[0].faces[1]': expected an array of three vertices"});
  expect(", [1, 2, 3]", "", {"key 'obstacles[0].faces[1]': ", "edge 1-3", "expected a closed surface"});
  expect("[0, 2, 1], [0, 1, 3], [0, 3, 2], [1, 2, 3]", "[0, 1, 2], [0, 3, 1], [0, 2, 3], [1, 3, 2]",
         {"key 'obstacles[0].faces': ", "encloses no positive volume"});
  expect("\"faces\"", "\"obj\"", {"scene.json:2: key 'obstacles[0]': expected either \"obj\" or \"vertices\" and"});
  expect("\"faces\"", "\"sides\"", {"key 'obstacles[0].sides': unknown key"});
  ExpectBad(SceneWithObstacle(R"({"type": "mesh", "vertices": []})"), {"key 'obstacles[0].faces': is missing"});
  ExpectBad(SceneWithObstacle(R"({"type": "mesh"})"), {"key 'obstacles[0]': expected either"});
}

TEST(ParseScene, NamesTheFileOfASurface) {
  const TemporaryFolder folder;
  folder.Write("sheet.obj", "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n");
  folder.Write("torn.obj", "v 0 0 0\nv 1 0\n");
  const auto parse = [&](const std::string& file) {
    const std::string text = SceneWithObstacle(R"({"type": "mesh", "obj": ")" + file + "\"}");
    return [text, &folder] { ParseScene(text, "scene.json", folder.path()); };
  };
  ExpectError(parse("sheet.obj"), kBadData,
              {"scene.json:2: key 'obstacles[0].obj': ", "sheet.obj:4: ", "(0)", "closed surface"});
  ExpectError(parse("torn.obj"), kBadData, {"torn.obj:2: expected three finite numbers"});
  // Of a polygon the line, whatever the number of its triangles.
  const std::string box = "v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\nv 0 0 1\nv 1 0 1\nv 1 1 1\nv 0 1 1\n# sides\n";
  const std::string sides = "f 4 3 2 1\nf 5 6 7 8\nf 1 2 6 5\nf 2 3 7 6\nf 3 4 8 7\n";
  folder.Write("box.obj", box + sides + "f 4 1 5 8\n");
  EXPECT_NO_THROW(parse("box.obj")());
  folder.Write("open.obj", box + sides);
  ExpectError(parse("open.obj"), kBadData, {"open.obj:10: triangulated surface: edge 0-3", "(1)"});
  folder.Write("turned.obj", box + sides + "f 8 5 1 4\n");
  ExpectError(parse("turned.obj"), kBadData, {"turned.obj:15: triangulated surface: triangle 11 is inverted"});
  folder.Write("doubled.obj", box + sides + "f 4 1 5 8\nf 4 1 5 8\n");
  ExpectError(parse("doubled.obj"), kBadData, {"doubled.obj:16: ", "belongs to more than two triangles"});
  folder.Write("thin.obj", box + sides + "f 4 1 5 8\nv 2 0 0\nv 3 0 0\nv 4 0 0\nf 9 10 11\n");
  ExpectError(parse("thin.obj"), kBadData, {"thin.obj:19: triangulated surface: triangle 12 has no area"});
  folder.Write("loose.obj", box + sides + "f 4 1 5 8\nv 2 0 0\n");
  ExpectError(parse("loose.obj"), kBadData, {"loose.obj:16: triangulated surface: node 8 belongs to no triangle"});
  folder.Write("bow.obj", box + sides + "f 4 1 8 5\n");
  ExpectError(parse("bow.obj"), kBadData, {"bow.obj:15: the polygon of 4 corners crosses or touches itself"});
  ExpectError(parse("none.obj"), ErrorKind::kIo, {"none.obj"});
  ExpectError(parse(""), kBadData, {"key 'obstacles[0].obj': expected the name of a file"});
}

TEST(ParseScene, ReadsHowTheClothMeetsItself) {
  EXPECT_FALSE(ParseScene(SmallScene(""), "scene.json", "").self_contact);
  const Scene scene =
      ParseScene(SmallScene(R"("self_contact": {"thickness": 0.002}, "parameters": {"mu.self": {"nominal": 0.2}})"),
                 "scene.json", "");
  ASSERT_TRUE(scene.self_contact);
  EXPECT_EQ(scene.self_contact->thickness, 0.002);
  EXPECT_EQ(scene.self_contact->friction_coefficient, 0.3);
  EXPECT_EQ(scene.nominal_parameters().self_friction, 0.2);
}

TEST(ParseScene, NamesWhatIsWrongWithSelfContact) {
  ExpectBadMember(R"("self_contact": {"mu": 0.3})", {"scene.json:2", "thickness"});
  ExpectBadMember(R"("self_contact": {"thickness": 0})", {"scene.json:2", "thickness", "> 0"});
  ExpectBadMember(R"("self_contact": {"thickness": 0.002, "mu": -1})", {"scene.json:2", "mu", ">= 0"});
  ExpectBadMember(R"("self_contact": {"thickness": 0.002}, "contact": "velocity")", {"self_contact", "gap"});
  ExpectBadMember(R"("self_contact": {"thickness": 0.002}, "obstacles": [{"name": "self", "type": "plane",
                     "point": [0, 0, -1], "normal": [0, 0, 1]}])",
                  {"obstacles", "self"});
  ExpectBadMember(R"("parameters": {"mu.self": {}})", {"mu.self"});
}

TEST(ParseScene, NamesUnknownKeysAndTheirLine) {
  ExpectBadMember("\"gravty\": [0, 0, 1]", {"scene.json:2: key 'gravty': unknown key", "gravity"});
  ExpectBadMember("\"wind\": {\n\"men\": 1}",
                  {"scene.json:3: key 'wind.men': unknown key; expected one of mean, gust"});
  ExpectBadMember("\"obstacles\": [\n\n{\"type\": \"plane\", \"point\": [0,0,0], \"normal\": [0,0,1],\n\"radius\": 1}]",
                  {"scene.json:5: key 'obstacles[0].radius': unknown key"});
  ExpectBadMember("\"ab\\ncd\": 1", {"scene.json:2: key 'ab?cd'"});
}

TEST(ParseScene, NamesTheLineOfAValueBehindLineEnds) {
  ExpectBadMember("\"touch\": 1\n,\"handles\": [0\n, 1\n,\n 99\n\n]",
                  {"scene.json:6: key 'handles[2]': expected an integer from 0 to 8, found 99"});
  ExpectBadMember("\"gravity\": [\n0,\ntrue\n,0]", {"scene.json:4: key 'gravity[1]': expected a number"});
  ExpectBadMember("\"touch\": 1e-5\n,\"time_step\"\n:\n\"x\"",
                  {"scene.json:3: key 'time_step': expected a number > 0"});
}

TEST(ParseScene, NamesWrongTypesAndValues) {
  ExpectBadMember("\"time_step\": 0", {"key 'time_step': expected a number > 0"});
  ExpectBadMember("\"time_step\": 1e-9", {"key 'duration': expected at most 10000000 time steps"});
  ExpectBadMember("\"time_step\": 1e10", {"key 'duration': expected at least a billionth of a time step"});
  ExpectBadMember("\"gravity\": [0, 0]", {"key 'gravity': expected an array of three numbers"});
  ExpectBadMember("\"gravity\": -9.81", {"key 'gravity': expected an array of three numbers"});
  ExpectBadMember("\"contact\": \"soft\"", {"key 'contact': expected \"gap\" or \"velocity\""});
  ExpectBadMember("\"wind\": 3", {"key 'wind': expected an object"});
  ExpectBadMember("\"touch\": -1", {"key 'touch': expected a number >= 0"});
  ExpectBadMember("\"materials\": {\"density\": 0}", {"key 'materials.density': expected a number > 0"});
  ExpectBadMember("\"materials\": {\"k_bend\": -1}", {"key 'materials.k_bend': expected a number >= 0"});
  ExpectBadMember("\"materials\": {\"damping\": -1}", {"key 'materials.damping': expected a number >= 0"});
  ExpectBadMember("\"solver\": {\"step_tolerance\": 1}",
                  {"key 'solver.step_tolerance': expected a number between 0 and 1"});
  ExpectBadMember("\"solver\": {\"max_newton_iterations\": 1.5}",
                  {"key 'solver.max_newton_iterations': expected an integer"});
  ExpectBadMember("\"initial\": {\"positions\": 1}", {"key 'initial.positions': expected a string"});
  ExpectBad("{\"clothid_scene\": 3}", {"scene.json:1: key 'clothid_scene': expected version 1 or 2"});
  ExpectBad("{}", {"scene.json:1: key 'clothid_scene': is missing"});
  ExpectBad("{\"clothid_scene\": 1}", {"scene.json:1: key 'duration': is missing"});
  ExpectBad("{\"clothid_scene\": 1, \"duration\": 1}", {"key 'mesh': is missing; expected {\"grid\""});
  ExpectBad("[1]", {"scene.json:1: expected an object"});
}

TEST(ParseScene, NamesWrongMeshes) {
  const auto expect = [](const std::string& mesh, std::initializer_list<const char*> fragments) {
    ExpectBad("{\"clothid_scene\": 1, \"duration\": 1, \"mesh\": " + mesh + "}", fragments);
  };
  expect("{}", {"key 'mesh': expected either"});
  expect("{\"grid\": {\"nodes\": [1, 3], \"size\": [1, 1]}}", {"key 'mesh.grid.nodes[0]': expected an integer from 2"});
  expect("{\"grid\": {\"nodes\": [2.0, 3], \"size\": [1, 1]}}", {"key 'mesh.grid.nodes[0]': expected an integer"});
  expect("{\"grid\": {\"nodes\": [2, 3, 4], \"size\": [1, 1]}}", {"key 'mesh.grid.nodes': expected two integers"});
  expect("{\"grid\": {\"nodes\": [2000000, 2000000], \"size\": [1, 1]}}",
         {"key 'mesh.grid': expected at most 4000000 nodes"});
  expect("{\"grid\": {\"nodes\": [2, 99999999999999], \"size\": [1, 1]}}", {"key 'mesh.grid.nodes[1]'"});
  expect("{\"grid\": {\"nodes\": [2, 2], \"size\": [1, -1]}}", {"key 'mesh.grid.size[1]': expected a number > 0"});
  expect("{\"grid\": {\"nodes\": [2, 2], \"size\": [1, 1], \"axes\": [[1, 0, 0], [-2, 0, 0]]}}",
         {"key 'mesh.grid.axes': expected two directions that are not parallel"});
}

TEST(ParseScene, NamesWrongHandles) {
  ExpectBadMember("\"handles\": [3, -1]", {"key 'handles[1]': expected an integer from 0 to 8, found -1"});
  ExpectBadMember("\"handles\": [3, 4, 3]", {"key 'handles[2]': node 3 is listed twice"});
  ExpectBadMember("\"handles\": [0, 1, 2, 3, 4, 5, 6, 7, 8]", {"key 'handles': expected at least one node"});
  ExpectBadMember("\"handles\": 3", {"key 'handles': expected a list of nodes, {"});
  ExpectBadMember("\"handles\": {\"path\": \"a.csv\"}", {"key 'handles.nodes': is missing"});
}

TEST(ParseScene, NamesWrongObstacles) {
  const std::string sphere = "\"type\": \"sphere\", \"center\": [0, 0, 0], \"radius\": 1";
  const auto expect = [](const std::string& list, std::initializer_list<const char*> fragments) {
    ExpectBadMember("\"obstacles\": [" + list + "]", fragments);
  };
  expect("{" + sphere + ", \"mu\": -0.1}", {"scene.json:2: key 'obstacles[0].mu': expected a number >= 0"});
  std::string many = "0";
  for (int i = 0; i < 1000; ++i) many += ", 0";
  expect(many, {"key 'obstacles': expected at most 1000 obstacles"});
  expect("{\"type\": \"cone\"}",
         {"key 'obstacles[0].type'", "'cone' are not supported; expected \"plane\", \"sphere\","});
  expect("{\"center\": [0, 0, 0]}", {"key 'obstacles[0].type': is missing"});
  expect("{\"type\": \"sphere\", \"radius\": 1}", {"key 'obstacles[0].center': is missing"});
  expect("{\"type\": \"sphere\", \"radius\": 0, \"center\": [0, 0, 0]}",
         {"key 'obstacles[0].radius': expected a number > 0"});
  expect("{\"type\": \"plane\", \"point\": [0, 0, 0], \"normal\": [0, 0, 0]}",
         {"key 'obstacles[0]': a plane's normal"});
  expect("{\"name\": \"a\", " + sphere + "}, {\"name\": \"a\", " + sphere + "}",
         {"key 'obstacles[1].name'", "no other obstacle"});
  expect("{\"name\": \"a,b\", " + sphere + "}", {"key 'obstacles[0].name': expected a name of letters"});
}

TEST(ParseScene, DefaultNamesAvoidGivenOnes) {
  const Scene scene = ParseScene(SmallScene(R"("obstacles": [{"type": "sphere", "center": [0, 0, 0], "radius": 1},
      {"name": "sphere", "type": "sphere", "center": [0, 0, 0], "radius": 1}])"),
                                 "scene.json", "");
  EXPECT_EQ(scene.obstacle_names(), (std::vector<std::string>{"sphere2", "sphere"}));
}

TEST(ParseScene, NamesWrongParameters) {
  ExpectBadMember("\"parameters\": {\"k\": {}}",
                  {"key 'parameters.k': unknown parameter 'k'; expected one of k_stretch"});
  ExpectBadMember("\"parameters\": {\"mu.ball\": {}}", {"key 'parameters.mu.ball': unknown parameter"});
  ExpectBadMember("\"parameters\": {\"mu\": {\"nominal\": -1}}",
                  {"key 'parameters.mu.nominal': expected a number >= 0"});
  ExpectBadMember("\"parameters\": {\"density\": {\"nominal\": 0}}",
                  {"key 'parameters.density.nominal': expected a number > 0"});
  ExpectBadMember("\"parameters\": {\"mu\": {\"lower\": 1, \"upper\": 0.5}}",
                  {"key 'parameters.mu': expected lower < upper"});
  ExpectBadMember("\"parameters\": {\"mu\": {\"nominal\": 1, \"upper\": 0.5}}", {"expected lower <= nominal <= upper"});
  ExpectBadMember("\"parameters\": {\"mu\": {\"prior\": {\"median\": 0.3, \"factor\": 2}}}",
                  {"key 'parameters.mu.prior.median': unknown key"});
  ExpectBadMember("\"parameters\": {\"mu\": {\"prior\": {\"mean\": 0.3}}}",
                  {"key 'parameters.mu.prior.std': is missing"});
  ExpectBadMember("\"parameters\": {\"density\": {\"prior\": {\"median\": 0.1, \"factor\": 1}}}",
                  {"key 'parameters.density.prior.factor': expected a number > 1"});
  ExpectBadMember("\"parameters\": {\"mu\": {\"frozen\": true, \"prior\": {\"mean\": 0.3, \"std\": 0.1}}}",
                  {"key 'parameters.mu.prior': expected none of a parameter that is frozen"});
  ExpectBadMember("\"parameters\": {\"mu\": {\"frozen\": 1}}", {"key 'parameters.mu.frozen': expected true or false"});
}

TEST(ParseScene, NamesTheLineOfBrokenJson) {
  ExpectBad("{\"clothid_scene\": 1,\n\n\"time_step\": }", {"scene.json:3: not valid JSON"});
  ExpectBad("", {"scene.json:1: not valid JSON"});
  ExpectBad("{\"clothid_scene\": 1}\n x", {"scene.json:2: not valid JSON"});
  ExpectBad("{\"clothid_scene\":\n NaN}", {"scene.json:2: not valid JSON"});
  ExpectBad("{\"clothid_scene\": 1,\n\"time_step\": 1e999}", {"scene.json:2: not valid JSON: number overflow"});
  ExpectBad("{\"clothid_scene\": 1 /* one */}", {"scene.json:1: not valid JSON"});
  ExpectBad("{\"a\xff\": 1}", {"scene.json:1: not valid JSON"});
  ExpectBad("{\"clothid_scene\": 1,\n\"touch\": 1,\n\"touch\": 2}",
            {"scene.json:3: key 'touch': expected once", "line 2"});
}

TEST(ParseScene, BoundsWhatItAllocates) {
  ExpectBad(std::string(100000, '['), {"scene.json:1: nested deeper than 64 levels"});
  ExpectBad(std::string(std::size_t{17} << 20, ' '), {"scene.json: is longer than"});
  std::string many = "[0";
  for (int i = 0; i < 1000001; ++i) many += ",0";
  ExpectBad(many + "]", {"more than 1000000 values"});
}

}  // namespace
}  // namespace clothid::scene_json_test

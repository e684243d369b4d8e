#include "sim/scene/shape_json.h"

#include <gtest/gtest.h>

#include <cmath>
#include <initializer_list>
#include <memory>
#include <string>

#include "sim/obstacle/box.h"
#include "sim/obstacle/round_shapes.h"
#include "tests/expect_error.h"

namespace clothid::shape_json_test {
namespace {

using Eigen::Vector3d;

std::shared_ptr<const Obstacle> Read(const std::string& text) {
  const JsonValue value = ParseJson(text, "scene.json");
  return ReadShape(JsonNode(value, "scene.json"), "");
}

template <typename Shape>
std::shared_ptr<const Shape> ReadAs(const std::string& text) {
  const auto shape = std::dynamic_pointer_cast<const Shape>(Read(text));
  EXPECT_NE(shape, nullptr) << text;
  return shape;
}

void ExpectBad(const std::string& text, std::initializer_list<const char*> fragments) {
  ExpectError([&] { Read(text); }, ErrorKind::kBadData, fragments);
}

TEST(ReadShape, ReadsBoxes) {
  const auto plain = ReadAs<Box>(R"({"type": "box", "center": [1, 2, 3], "size": [0.1, 0.2, 0.3], "mu": 0.1})");
  EXPECT_EQ(plain->center(), Vector3d(1, 2, 3));
  EXPECT_EQ(plain->size(), Vector3d(0.1, 0.2, 0.3));
  EXPECT_EQ(plain->radius(), 0.0);
  EXPECT_TRUE(plain->rotation().matrix().isIdentity(0.0));
  const auto turned = ReadAs<Box>(
      R"({"type": "box", "center": [0, 0, 0], "size": [1, 1, 1], "rotation": [0, 0, 2, 2], "radius": 0.02})");
  EXPECT_EQ(turned->radius(), 0.02);
  EXPECT_LT((turned->rotation() * Vector3d::UnitX() - Vector3d::UnitY()).norm(), 1e-15) << "a quarter turn about z";
}

TEST(ReadShape, ReadsTables) {
  const std::string table =
      R"({"type": "table", "center": [0, 0, 1], "normal": [0, 0, 3], "size": [2, 1], "thickness": 0.1)";
  const auto plain = ReadAs<Box>(table + "}");
  EXPECT_EQ(plain->radius(), 0.05) << "half the thickness";
  EXPECT_EQ(plain->size(), Vector3d(2, 1, 0.1));
  EXPECT_LT((plain->center() - Vector3d(0, 0, 0.95)).norm(), 1e-15);
  EXPECT_NEAR(plain->Closest({1.5, 0.0, 0.95}).gap, 0.5, 1e-15);
  const auto turned = ReadAs<Box>(table + R"(, "along": [0, 5, 1], "radius": 0.01})");
  EXPECT_EQ(turned->radius(), 0.01);
  EXPECT_NEAR(turned->Closest({0.0, 1.5, 0.95}).gap, 0.5, 1e-15);
}

TEST(ReadShape, ReadsRoundShapes) {
  const auto cylinder = ReadAs<Cylinder>(R"({"type": "cylinder", "from": [0, 0, 1], "to": [0, 2, 1], "radius": 0.3})");
  EXPECT_LT((cylinder->from() - Vector3d(0, 0, 1)).norm() + (cylinder->to() - Vector3d(0, 2, 1)).norm(), 1e-15);
  EXPECT_EQ(cylinder->radius(), 0.3);
  const auto torus =
      ReadAs<Torus>(R"({"type": "torus", "center": [1, 2, 3], "axis": [0, 2, 0], "radius": 0.3, "tube_radius": 0.1})");
  EXPECT_EQ(torus->center(), Vector3d(1, 2, 3));
  EXPECT_EQ(torus->axis(), Vector3d::UnitY());
  EXPECT_EQ(torus->radius(), 0.3);
  EXPECT_EQ(torus->tube_radius(), 0.1);
  const auto bowl = ReadAs<Bowl>(
      R"({"type": "bowl", "center": [0, 0, 1], "axis": [0, 0, 1], "radius": 0.5, "angle": 60, "thickness": 0.25})");
  EXPECT_EQ(bowl->radius(), 0.5);
  EXPECT_EQ(bowl->thickness(), 0.25);
  EXPECT_NEAR(bowl->angle(), M_PI / 3.0, 1e-15);
  EXPECT_NEAR(bowl->Closest({0.0, 0.0, 0.75}).gap, 0.25, 1e-15) << "above the bottom";
}

TEST(ReadShape, NamesWhatIsWrong) {
  ExpectBad(R"({"type": "box", "center": [0, 0, 0]})", {"scene.json:1: key 'size': is missing"});
  ExpectBad(R"({"type": "box", "center": [0, 0, 0], "size": [1, 1]})", {"key 'size': expected an array of three"});
  ExpectBad(R"({"type": "box", "center": [0, 0, 0], "size": [1, 0, 1]})", {"a box's lengths must be positive"});
  const std::string box = R"({"type": "box", "center": [0, 0, 0], "size": [1, 1, 1], )";
  ExpectBad(box + R"("rotation": [0, 0, 1]})", {"key 'rotation': expected a quaternion, [x, y, z, w]"});
  ExpectBad(box + R"("rotation": [0, 0, 0, 0]})", {"a box's rotation must be finite and longer than zero"});
  ExpectBad(box + R"("radius": -1})", {"key 'radius': expected a number >= 0"});
  ExpectBad(box + R"("radius": 0.6})", {"the radius of a box's edges"});
  ExpectBad(box + R"("normal": [0, 0, 1]})", {"key 'normal': unknown key; expected one of center, size, rotation"});
  const std::string table = R"({"type": "table", "center": [0, 0, 0], "thickness": 0.1, "normal": [1, 0, 0])";
  ExpectBad(table + R"(, "size": [1, 1, 1]})", {"key 'size': expected two numbers > 0 (m)"});
  ExpectBad(table + R"(, "size": [1, 0]})", {"key 'size[1]': expected a number > 0"});
  ExpectBad(table + R"(, "size": [1, 1]})", {"along its normal: choose another direction \"along\""});
  ExpectBad(R"({"type": "cylinder", "from": [0, 0, 0], "to": [0, 0, 0], "radius": 1})", {"a cylinder's two ends"});
  const std::string torus = R"({"type": "torus", "center": [0, 0, 0], "axis": [0, 0, 1], "radius": 1, )";
  ExpectBad(torus + R"("tube_radius": 2})", {"a torus's tube_radius must be smaller than its radius"});
  const std::string bowl = R"({"type": "bowl", "center": [0, 0, 0], "axis": [0, 0, 1], "radius": 1, "thickness": 0.1)";
  ExpectBad(bowl + "}", {"key 'angle': is missing; expected a number > 0 and < 180 (degrees)"});
  ExpectBad(bowl + R"(, "angle": 180})", {"a bowl's angle must be more than 0 and less than 180 degrees"});
  ExpectBad(bowl + R"(, "angle": 179})", {"a bowl's opening must be wider"});
  ExpectBad(R"({"type": "ball"})", {"'ball' are not supported; expected \"plane\", ", "\"bowl\" or \"mesh\""});
}

}  // namespace
}  // namespace clothid::shape_json_test

#include "sim/geometry/polygon.h"

#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <array>
#include <cmath>
#include <vector>

namespace clothid::polygon_test {
namespace {

using Triangles = std::vector<std::array<int, 3>>;

Eigen::Matrix3Xd Flat(const std::vector<Eigen::Vector2d>& corners) {
  Eigen::Matrix3Xd places = Eigen::Matrix3Xd::Zero(3, static_cast<Eigen::Index>(corners.size()));
  for (std::size_t i = 0; i < corners.size(); ++i) places.col(static_cast<Eigen::Index>(i)).head<2>() = corners[i];
  return places;
}

// Beginning with corner `first`.
Eigen::Matrix3Xd Rotated(const Eigen::Matrix3Xd& corners, Eigen::Index first) {
  Eigen::Matrix3Xd rotated(3, corners.cols());
  for (Eigen::Index i = 0; i < corners.cols(); ++i) rotated.col(i) = corners.col((first + i) % corners.cols());
  return rotated;
}

// n - 2 triangles that turn like the polygon, with `area` in all.
void ExpectCut(const Eigen::Matrix3Xd& corners, double area) {
  const Triangles triangles = TrianglesOfPolygon(corners);
  ASSERT_EQ(static_cast<Eigen::Index>(triangles.size()), corners.cols() - 2);
  Eigen::Vector3d normal = Eigen::Vector3d::Zero();
  for (Eigen::Index i = 0; i < corners.cols(); ++i) {
    normal += 0.5 * corners.col(i).cross(corners.col((i + 1) % corners.cols()));
  }
  double sum = 0.0;
  for (const auto& [a, b, c] : triangles) {
    const Eigen::Vector3d cross = 0.5 * (corners.col(b) - corners.col(a)).cross(corners.col(c) - corners.col(a));
    EXPECT_GT(cross.dot(normal), 0.0);
    sum += cross.norm();
  }
  EXPECT_NEAR(sum, area, 1e-12 * std::max(area, 1.0));
}

const std::vector<Eigen::Vector2d> kL = {{0, 0}, {0.2, 0}, {0.2, 0.1}, {0.1, 0.1}, {0.1, 0.2}, {0, 0.2}};

TEST(TrianglesOfPolygonTest, OfAConvexOneAreItsFan) {
  const Eigen::Matrix3Xd pentagon = Flat({{0, 0}, {2, 0}, {3, 1}, {1, 3}, {-1, 1}});
  EXPECT_EQ(TrianglesOfPolygon(pentagon), (Triangles{{0, 1, 2}, {0, 2, 3}, {0, 3, 4}}));
  EXPECT_EQ(TrianglesOfPolygon(pentagon.rowwise().reverse()), (Triangles{{0, 1, 2}, {0, 2, 3}, {0, 3, 4}}));
  EXPECT_EQ(TrianglesOfPolygon(Flat({{0, 0}, {1, 0}, {2, 0}})), (Triangles{{0, 1, 2}})) << "a triangle is what it is";
}

TEST(TrianglesOfPolygonTest, CoverAnLWhateverCornerComesFirst) {
  const Eigen::Matrix3Xd corners = Flat(kL);
  for (Eigen::Index first = 0; first < corners.cols(); ++first) {
    SCOPED_TRACE(first);
    ExpectCut(Rotated(corners, first), 0.03);
    ExpectCut(Rotated(corners, first).rowwise().reverse(), 0.03);
  }
}

// Turned in space, far from the origin, and bent a little.
TEST(TrianglesOfPolygonTest, CoverItAnywhereInSpace) {
  const Eigen::Quaterniond turn = Eigen::Quaterniond(0.3, -0.5, 0.7, 0.2).normalized();
  for (Eigen::Index first = 0; first < 6; ++first) {
    Eigen::Matrix3Xd corners = Rotated(Flat(kL), first);
    ExpectCut((turn.toRotationMatrix() * corners).colwise() + Eigen::Vector3d(100.0, -50.0, 20.0), 0.03);
    for (Eigen::Index i = 0; i < 6; ++i) corners(2, i) = 0.01 * std::sin(3.0 * static_cast<double>(i));
    EXPECT_EQ(TrianglesOfPolygon(corners).size(), 4u);
  }
}

TEST(TrianglesOfPolygonTest, CoverStarsCombsAndConcaveQuads) {
  std::vector<Eigen::Vector2d> star, comb;
  for (int i = 0; i < 14; ++i) {
    const double angle = M_PI * i / 7.0, radius = i % 2 == 0 ? 1.0 : 0.2;
    star.push_back(radius * Eigen::Vector2d(std::cos(angle), std::sin(angle)));
  }
  ExpectCut(Flat(star), 7.0 * 0.2 * std::sin(M_PI / 7.0));
  for (int i = 0; i < 6; ++i) {  // teeth, from right to left below a beam
    comb.emplace_back(6.0 - i, 0.0);
    comb.emplace_back(5.5 - i, -2.0);
  }
  comb.emplace_back(0.0, 0.0);
  comb.emplace_back(0.0, 1.0);
  comb.emplace_back(6.0, 1.0);
  for (Eigen::Index first = 0; first < 15; ++first) ExpectCut(Rotated(Flat(comb), first), 12.0);
  for (Eigen::Index first = 0; first < 4; ++first) {
    ExpectCut(Rotated(Flat({{0, 0}, {1, 0}, {0.2, 0.2}, {0, 1}}), first), 0.2);
  }
}

// Sides may cross where no corner lies in the ear that is cut first, and triangles then cover each other.
TEST(TrianglesOfPolygonTest, AreNoneWhereSidesCross) {
  const std::vector<Eigen::Vector2d> knot = {{0.69, 0.87}, {0.05, -0.37}, {-0.54, -0.11}, {0.83, 0.07}, {-0.14, -0.09}};
  const std::vector<Eigen::Vector2d> loop = {{-1, 0.5},    {0.75, -0.5}, {0.5, -0.25}, {-0.5, 0.5},
                                             {-0.75, 0.5}, {-1, 0},      {-0.25, 0.25}};
  for (const auto& corners : {knot, loop}) {
    for (Eigen::Index first = 0; first < static_cast<Eigen::Index>(corners.size()); ++first) {
      EXPECT_TRUE(TrianglesOfPolygon(Rotated(Flat(corners), first)).empty()) << corners.size() << ", " << first;
    }
  }
}

// A corner on a side is no reason for a triangle without area.
TEST(TrianglesOfPolygonTest, TakeCornersOnSides) {
  for (Eigen::Index first = 0; first < 5; ++first) {
    ExpectCut(Rotated(Flat({{0, 0}, {1, 0}, {2, 0}, {2, 2}, {0, 2}}), first), 4.0);
  }
}

TEST(TrianglesOfPolygonTest, AreNoneWhereItCrossesItselfOrHasNoArea) {
  EXPECT_TRUE(TrianglesOfPolygon(Flat({{0, 0}, {1, 1}, {1, 0}, {0, 1}})).empty()) << "a bow tie";
  EXPECT_TRUE(TrianglesOfPolygon(Flat({{0, 0}, {2, 2}, {2, 0}, {0, 1}})).empty()) << "with lobes of two sizes";
  EXPECT_TRUE(TrianglesOfPolygon(Flat({{0, 0}, {1, 0}, {2, 0}, {3, 0}})).empty()) << "a line";
  std::vector<Eigen::Vector2d> pentagram;
  for (int i = 0; i < 5; ++i) pentagram.emplace_back(std::cos(0.8 * M_PI * i), std::sin(0.8 * M_PI * i));
  EXPECT_TRUE(TrianglesOfPolygon(Flat(pentagram)).empty());
}

}  // namespace
}  // namespace clothid::polygon_test

// A rectangle of cloth in four kinds of triangles, to see what depends on the mesh.
#ifndef CLOTHID_TESTS_SIM_SHEET_MESHES_H_
#define CLOTHID_TESTS_SIM_SHEET_MESHES_H_

#include <cmath>
#include <random>
#include <string>

#include "sim/mesh/mesh.h"

namespace clothid {

enum class SheetKind {
  kRightAngled,  // a grid with parallel diagonals
  kAlternating,  // `MakeGrid`
  kEquilateral,  // every other row shifted by half a triangle; two borders are zigzag, the others straight
  kIrregular,    // inner nodes of a grid moved at random, diagonals where they meet the larger angles (Delaunay)
};

inline constexpr SheetKind kSheetKinds[] = {SheetKind::kRightAngled, SheetKind::kAlternating, SheetKind::kEquilateral,
                                            SheetKind::kIrregular};

inline std::string SheetName(SheetKind kind) {
  const char* const names[] = {"RightAngled", "Alternating", "Equilateral", "Irregular"};
  return names[static_cast<int>(kind)];
}

// Moves inner nodes by up to a quarter of the spacing; `fixed_columns` at both ends of the first axis stay.
inline void Jitter(const GridOptions& grid, int fixed_columns, Mesh* mesh) {
  std::mt19937_64 generator(5);
  std::uniform_real_distribution<double> shift(-0.25, 0.25);
  const auto [columns, rows] = grid.nodes;
  for (int node = 0; node < mesh->num_nodes(); ++node) {
    const int i = node % columns, j = node / columns;
    const double across = shift(generator), along = shift(generator);
    if (i >= fixed_columns && i < columns - fixed_columns) {
      mesh->rest_positions(0, node) += across * grid.size[0] / (columns - 1);
    }
    if (j > 0 && j < rows - 1) mesh->rest_positions(1, node) += along * grid.size[1] / (rows - 1);
  }
}

// The angle at `apex` between two nodes of the xy plane.
inline double AngleAt(const Mesh& mesh, int apex, int a, int b) {
  const Eigen::Vector3d to_a = mesh.rest_positions.col(a) - mesh.rest_positions.col(apex);
  const Eigen::Vector3d to_b = mesh.rest_positions.col(b) - mesh.rest_positions.col(apex);
  return std::acos(to_a.dot(to_b) / (to_a.norm() * to_b.norm()));
}

// In the xy plane, with `grid.nodes` over about `grid.size`: kEquilateral takes its height from the width of its
// triangles.
inline Mesh MakeSheet(SheetKind kind, const GridOptions& grid, int fixed_columns = 1) {
  Mesh mesh = MakeGrid(grid);
  if (kind == SheetKind::kAlternating) return mesh;
  const auto [columns, rows] = grid.nodes;
  const double spacing = grid.size[0] / (columns - 1);
  if (kind == SheetKind::kIrregular) Jitter(grid, fixed_columns, &mesh);
  for (int node = 0; node < mesh.num_nodes() && kind == SheetKind::kEquilateral; ++node) {
    const int j = node / columns;
    mesh.rest_positions.col(node) =
        grid.origin + spacing * Eigen::Vector3d(node % columns + 0.5 * (j % 2), j * std::sqrt(0.75), 0.0);
  }
  for (int quad = 0; 2 * quad < mesh.num_faces(); ++quad) {
    const int a = quad % (columns - 1) + columns * (quad / (columns - 1)), b = a + 1, c = a + columns, d = c + 1;
    bool rising = true;
    if (kind == SheetKind::kEquilateral) rising = quad / (columns - 1) % 2 == 1;
    if (kind == SheetKind::kIrregular) {
      rising = AngleAt(mesh, b, a, d) + AngleAt(mesh, c, a, d) <= AngleAt(mesh, a, b, c) + AngleAt(mesh, d, b, c);
    }
    mesh.faces.col(2 * quad) = rising ? Eigen::Vector3i(a, b, d) : Eigen::Vector3i(a, b, c);
    mesh.faces.col(2 * quad + 1) = rising ? Eigen::Vector3i(a, d, c) : Eigen::Vector3i(b, d, c);
  }
  return mesh;
}

}  // namespace clothid

#endif  // CLOTHID_TESTS_SIM_SHEET_MESHES_H_

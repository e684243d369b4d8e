// Flat sheets on each other, in one mesh.
#ifndef CLOTHID_TESTS_SIM_CONTACT_STACKED_SHEETS_H_
#define CLOTHID_TESTS_SIM_CONTACT_STACKED_SHEETS_H_

#include <Eigen/Core>
#include <array>
#include <cmath>
#include <vector>

#include "sim/mesh/mesh.h"
#include "tests/sim/joined_mesh.h"

namespace clothid {

struct SheetOfStack {
  int columns, rows;
  double width;  // m, of square meshes
  double angle;  // of its columns to the x axis, rad
  std::array<double, 2> origin;
};

// From z = 0 upwards, `distance` apart, nodes in the same order.
inline Mesh StackSheets(const std::vector<SheetOfStack>& sheets, double distance) {
  std::vector<Mesh> parts;
  for (std::size_t i = 0; i < sheets.size(); ++i) {
    const SheetOfStack& sheet = sheets[i];
    GridOptions grid;
    grid.nodes = {sheet.columns, sheet.rows};
    grid.size = {sheet.width, sheet.width * (sheet.rows - 1) / (sheet.columns - 1)};
    grid.origin = {sheet.origin[0], sheet.origin[1], static_cast<double>(i) * distance};
    grid.axes = {Eigen::Vector3d(std::cos(sheet.angle), std::sin(sheet.angle), 0.0),
                 Eigen::Vector3d(-std::sin(sheet.angle), std::cos(sheet.angle), 0.0)};
    parts.push_back(MakeGrid(grid));
  }
  return JoinedMesh(parts);
}

}  // namespace clothid

#endif  // CLOTHID_TESTS_SIM_CONTACT_STACKED_SHEETS_H_

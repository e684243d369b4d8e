// Cloth that is cut, laid out in a UV map and sewn again.
#ifndef CLOTHID_TESTS_SIM_GARMENTS_H_
#define CLOTHID_TESTS_SIM_GARMENTS_H_

#include <Eigen/Core>
#include <Eigen/Geometry>
#include <cmath>
#include <functional>
#include <map>
#include <sstream>
#include <string>
#include <vector>

#include "sim/mesh/mesh.h"
#include "sim/mesh/sewing.h"
#include "sim/scene/material_field.h"
#include "sim/scene/scene.h"

namespace clothid {

// `mesh`, which is flat, with its places in its plane as those of corners at rest: the same cloth.
inline Mesh WithUvRest(Mesh mesh) {
  const Eigen::Matrix2Xd places = FrontAxes(mesh, "a flat cloth").transpose() * mesh.rest_positions;
  mesh.corner_rest = places(Eigen::all, mesh.faces.reshaped());
  return mesh;
}

// A mesh that is cut along `seam`: the triangles beyond it have nodes of their own there, `beyond`, that come last.
struct CutMesh {
  Mesh mesh;
  std::vector<int> seam, beyond;
  std::vector<int> faces;  // beyond the seam
};

// `is_beyond(middle)` of a triangle's middle at the mesh's `rest_positions`.
inline CutMesh Cut(const Mesh& mesh, const std::vector<int>& seam,
                   const std::function<bool(const Eigen::Vector3d&)>& is_beyond) {
  CutMesh cut{mesh, seam, {}, {}};
  std::map<int, int> twins;
  for (const int node : seam) {
    twins[node] = mesh.num_nodes() + static_cast<int>(twins.size());
    cut.beyond.push_back(twins[node]);
  }
  cut.mesh.rest_positions.conservativeResize(3, mesh.num_nodes() + static_cast<int>(seam.size()));
  for (const auto& [node, twin] : twins) cut.mesh.rest_positions.col(twin) = mesh.rest_positions.col(node);
  for (int f = 0; f < mesh.num_faces(); ++f) {
    Eigen::Vector3d middle = Eigen::Vector3d::Zero();
    for (int k = 0; k < 3; ++k) middle += mesh.rest_positions.col(mesh.faces(k, f)) / 3.0;
    if (!is_beyond(middle)) continue;
    cut.faces.push_back(f);
    for (int k = 0; k < 3; ++k) {
      const auto twin = twins.find(cut.mesh.faces(k, f));
      if (twin != twins.end()) cut.mesh.faces(k, f) = twin->second;
    }
  }
  return cut;
}

// Turns the piece beyond the seam in the UV map, and lays it elsewhere.
inline void LayElsewhere(double radians, const Eigen::Vector2d& shift, CutMesh* cut) {
  for (const int f : cut->faces) {
    for (int k = 0; k < 3; ++k) {
      auto place = cut->mesh.corner_rest.col(3 * f + k);
      place = (Eigen::Rotation2Dd(radians) * place + shift).eval();
    }
  }
}

inline Seam SeamOf(const CutMesh& cut) {
  Seam seam;
  seam.a = cut.seam;
  seam.b = cut.beyond;
  return seam;
}

inline Mesh Sewn(Mesh mesh, const std::vector<Seam>& seams) {
  Sewing sewing(&mesh);
  for (const Seam& seam : seams) sewing.Add(seam);
  sewing.Finish();
  ValidateMesh(mesh, "sewn");
  return mesh;
}

// Two meshes with a rest place per corner as one; the nodes of `b` follow those of `a`.
inline Mesh Together(const Mesh& a, const Mesh& b) {
  Mesh both;
  both.rest_positions.resize(3, a.num_nodes() + b.num_nodes());
  both.rest_positions << a.rest_positions, b.rest_positions;
  both.faces.resize(3, a.num_faces() + b.num_faces());
  both.faces << a.faces, (b.faces.array() + a.num_nodes()).matrix();
  both.corner_rest.resize(2, 3 * both.faces.cols());
  both.corner_rest << a.corner_rest, b.corner_rest;
  return both;
}

// `scene` with this mesh, at rest on its nodes.
inline Scene WithMesh(Scene scene, const Mesh& mesh) {
  scene.mesh = mesh;
  scene.initial_positions = mesh.rest_positions.reshaped();
  scene.initial_velocities = Eigen::VectorXd::Zero(scene.initial_positions.size());
  return scene;
}

// Column or row `at` of a grid.
inline std::vector<int> GridLine(int columns, int rows, bool is_column, int at) {
  std::vector<int> nodes;
  for (int i = 0; i < (is_column ? rows : columns); ++i)
    nodes.push_back(is_column ? at + columns * i : i + columns * at);
  return nodes;
}

// A flat panel of `columns` x `rows` nodes in the UV map that lies as a sleeve about the z axis, its first and last
// column beside each other: their chains are `seam` (the first) and `beyond`. Chords are as long as in the map.
inline CutMesh SleevePanel(int columns, int rows, double width, double height) {
  GridOptions grid;
  grid.nodes = {columns, rows};
  grid.size = {width, height};
  CutMesh panel{
      WithUvRest(MakeGrid(grid)), GridLine(columns, rows, true, 0), GridLine(columns, rows, true, columns - 1), {}};
  const double angle = 2.0 * 3.14159265358979323846 / (columns - 1);
  const double radius = 0.5 * width / (columns - 1) / std::sin(0.5 * angle);
  for (int node = 0; node < panel.mesh.num_nodes(); ++node) {
    const int i = node % columns;
    panel.mesh.rest_positions.col(node) << radius * std::cos(i * angle), radius * std::sin(i * angle),
        height * (node / columns) / (rows - 1);
  }
  return panel;
}

// An OBJ file of it, with a `vt` line for each corner that has a place at rest. Numbers read back exactly.
inline std::string ObjText(const Mesh& mesh) {
  std::ostringstream text;
  text.precision(17);
  for (const auto& x : mesh.rest_positions.colwise()) text << "v " << x[0] << " " << x[1] << " " << x[2] << "\n";
  for (const auto& uv : mesh.corner_rest.colwise()) text << "vt " << uv[0] << " " << uv[1] << "\n";
  for (int f = 0; f < mesh.num_faces(); ++f) {
    text << "f";
    for (int k = 0; k < 3; ++k) {
      text << " " << mesh.faces(k, f) + 1;
      if (mesh.has_corner_rest()) text << "/" << 3 * f + k + 1;
    }
    text << "\n";
  }
  return text.str();
}

}  // namespace clothid

#endif  // CLOTHID_TESTS_SIM_GARMENTS_H_

#include "sim/obstacle/triangulated_surface.h"

#include <string>
#include <utility>
#include <vector>

#include "sim/geometry/triangle_tree.h"
#include "sim/mesh/mesh.h"

namespace clothid {
namespace {

// Nearer to an edge or vertex than this share of the largest coordinate there is no direction to speak of.
constexpr double kSingularDistance = 1e-12;

constexpr char kSource[] = "triangulated surface";

void Validate(const Mesh& mesh) {
  if (mesh.num_faces() > kMaxSurfaceFaces) {
    FailOnData(kSource,
               std::to_string(mesh.num_faces()) + " triangles; expected at most " + std::to_string(kMaxSurfaceFaces));
  }
  ValidateMesh(mesh, kSource);
}

// Whose features have no numbers yet.
std::vector<SearchTriangle> PlacedTriangles(const Eigen::Matrix3Xd& vertices, const Eigen::Matrix3Xi& faces) {
  std::vector<SearchTriangle> triangles(static_cast<std::size_t>(faces.cols()));
  for (std::size_t i = 0; i < triangles.size(); ++i) {
    const auto corners = faces.col(static_cast<Eigen::Index>(i));
    triangles[i].Place(vertices.col(corners[0]), vertices.col(corners[1]), vertices.col(corners[2]));
  }
  return triangles;
}

double LeastDistance(const Eigen::Matrix3Xd& vertices) { return kSingularDistance * vertices.cwiseAbs().maxCoeff(); }

}  // namespace

// What moves with the vertices stands beside what does not.
struct TriangulatedSurface::Data {
  Eigen::Matrix3Xd vertices;
  std::shared_ptr<const Eigen::Matrix3Xi> faces;
  std::shared_ptr<const SurfaceTopology> topology;
  TriangleTree tree;
  std::vector<SurfaceFeature> features;  // all of them; empty: each is made when it is asked for
  double least_distance = 0.0;           // m, see EvaluateFeature

  SurfaceFeature Feature(int feature) const {
    return features.empty() ? topology->FeatureAt(feature, tree.triangles()) : features[feature];
  }
};

TriangulatedSurface::TriangulatedSurface(std::shared_ptr<const Data> data) : data_(std::move(data)) {}

TriangulatedSurface::TriangulatedSurface(Eigen::Matrix3Xd vertices, Eigen::Matrix3Xi faces) {
  const Mesh mesh{std::move(vertices), std::move(faces)};
  Validate(mesh);
  auto data = std::make_shared<Data>();
  data->topology = std::make_shared<SurfaceTopology>(mesh);
  std::vector<SearchTriangle> triangles = PlacedTriangles(mesh.rest_positions, mesh.faces);
  data->topology->NumberFeatures(&triangles);
  data->topology->ExpectOutside(triangles, kSource);
  for (int i = 0; i < data->topology->num_features(); ++i) {
    data->features.push_back(data->topology->FeatureAt(i, triangles));
    if (data->features.back().normal.isZero(0.0)) {
      const int vertex = i - data->topology->num_features() + mesh.num_nodes();
      throw MeshError(kSource, "the triangles around vertex " + std::to_string(vertex) + " have no outside",
                      {-1, vertex});
    }
  }
  data->tree = TriangleTree(std::move(triangles));
  data->vertices = mesh.rest_positions;
  data->faces = std::make_shared<const Eigen::Matrix3Xi>(mesh.faces);
  data->least_distance = LeastDistance(data->vertices);
  data_ = std::move(data);
}

TriangulatedSurface TriangulatedSurface::MovedTo(Eigen::Matrix3Xd vertices) const {
  auto data = std::make_shared<Data>();
  data->vertices = std::move(vertices);
  data->faces = data_->faces;
  data->topology = data_->topology;
  data->tree = data_->tree;
  data->tree.Refit(data->vertices, *data->faces);
  data->least_distance = LeastDistance(data->vertices);
  return TriangulatedSurface(std::move(data));
}

void TriangulatedSurface::ExpectOutsideAt(const Eigen::Matrix3Xd& vertices, const std::string& source) const {
  data_->topology->ExpectOutside(PlacedTriangles(vertices, *data_->faces), source);
}

SurfacePoint TriangulatedSurface::Closest(const Eigen::Vector3d& position) const {
  const int feature = data_->tree.ClosestFeature(position);
  if (!data_->features.empty()) {
    return EvaluateFeature(data_->features[feature], position, data_->least_distance);
  }
  return EvaluateFeature(data_->Feature(feature), position, data_->least_distance);
}

NearestFeature TriangulatedSurface::Nearest(const Eigen::Vector3d& position) const {
  const int feature = data_->tree.ClosestFeature(position);
  NearestFeature nearest;
  nearest.face = data_->topology->FaceOf(feature);
  nearest.feature = data_->Feature(feature);
  nearest.point = EvaluateFeature(nearest.feature, position, data_->least_distance);
  return nearest;
}

const Eigen::Matrix3Xd& TriangulatedSurface::vertices() const { return data_->vertices; }
const Eigen::Matrix3Xi& TriangulatedSurface::faces() const { return *data_->faces; }

}  // namespace clothid

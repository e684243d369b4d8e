#include "sim/geometry/normal_cones.h"

#include <limits>

namespace clothid {
namespace {

// Of the size of a part: for the rounding of what lies exactly at its edge.
constexpr double kSlack = 1e-5;

}  // namespace

void NormalCones::Refit(const BoxTree& tree, const std::vector<BoxTree::Box>& places,
                        const std::vector<BoxTree::Box>& normals) {
  faces_.resize(places.size());
  for (std::size_t f = 0; f < places.size(); ++f) faces_[f] = {places[f], normals[f]};
  tree.Gather(
      faces_,
      [](Patch* patch, const Patch& other) {
        patch->places.extend(other.places);
        patch->normals.extend(other.normals);
      },
      &patches_);
  cones_.resize(patches_.size());
  for (std::size_t i = 0; i < patches_.size(); ++i) {
    const auto& [place, normal] = patches_[i];
    Cone* cone = &cones_[i];
    cone->centre = place.center();
    cone->radius = (0.5 + kSlack) * place.diagonal().norm();
    cone->axis = normal.center().normalized();
    // All normals are in a sphere of radius r around c: sin phi = r/|c|.
    const double squared_radius = 0.25 * normal.diagonal().squaredNorm();
    const double squared_cosine = normal.center().squaredNorm() - squared_radius;
    cone->tangent = squared_cosine > 0.0 ? std::sqrt(squared_radius / squared_cosine) + kSlack
                                         : std::numeric_limits<double>::infinity();
  }
}

}  // namespace clothid

// What a user asks of a prediction beside the places of nodes: covered area, strain, forces at grippers, slip.
//
//   area      m^2, that of the cloth seen from above, along gravity: what lies over itself counts once. It is counted
//   on
//             a raster of squares of a sixteenth of an edge, a square where its middle is covered
//   strain    the largest principal stretch of a triangle, less one
//   force     N, with which every gripper, handles that edges join, acts on the cloth (sim/rollout/handle_forces.h);
//             where the cloth meets itself without what that does to handles
//   slip      s, after the start: when for the first time more than half of the nodes that touch an obstacle slip;
//             infinite: never
//   point:N   m, the place of node N
#ifndef CLOTHID_IDENTIFY_PREDICTION_DERIVED_H_
#define CLOTHID_IDENTIFY_PREDICTION_DERIVED_H_

#include <Eigen/Core>
#include <array>
#include <string>
#include <vector>

#include "sim/scene/scene.h"

namespace clothid {

enum class DerivedKind { kPoint, kArea, kStrain, kForce, kSlip };

struct DerivedRequest {
  DerivedKind kind = DerivedKind::kArea;
  int node = 0;      // of kPoint
  std::string name;  // "area", "point_12"
};

// "point:12,area": each once. Throws `Error` (kUsage), naming `flag`, for what `scene` does not have.
std::vector<DerivedRequest> ParseDerived(const std::string& text, const std::string& flag, const Scene& scene);

// Bands of one of them: quantiles [R x T] of `kBandQuantiles`; R numbers in every frame, of kSlip a single one.
struct DerivedBands {
  DerivedRequest request;
  std::array<Eigen::MatrixXd, 5> quantiles;
};

// "m", "m^2", "", "N", "s".
const char* UnitOf(DerivedKind kind);

// The handles of every gripper [G], by their first one.
std::vector<std::vector<int>> GripperNodes(const Scene& scene);

// At positions `x` [3N] m. `scene` with its mesh, gravity and, for strains, its shape at rest.
double CoveredArea(const Scene& scene, const Eigen::Ref<const Eigen::VectorXd>& x);
double LargestStrain(const Mesh& mesh, const Eigen::Ref<const Eigen::VectorXd>& x);

}  // namespace clothid

#endif  // CLOTHID_IDENTIFY_PREDICTION_DERIVED_H_

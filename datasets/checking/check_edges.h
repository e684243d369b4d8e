// Findings about the lengths between neighbouring points against those of the mesh at rest: unit, size, order, places;
// and about the distance between parts of a cloth that meets itself.
#ifndef CLOTHID_DATASETS_CHECKING_CHECK_EDGES_H_
#define CLOTHID_DATASETS_CHECKING_CHECK_EDGES_H_

#include <vector>

#include "datasets/checking/checked_motion.h"
#include "datasets/checking/finding.h"

namespace clothid {

// Of all of them; a problem where their ratio is that of two units.
Finding CheckEdges(const CheckedMotion& checked);
// Single points that are elsewhere on the cloth than the mesh has them; empty where there are none.
std::vector<Finding> CheckPlaces(const CheckedMotion& checked);
// Of a cloth that meets itself and of which every node is seen, as of a simulation: whether triangles cut each other,
// and how near its parts come. Nothing where noise hides that.
std::vector<Finding> CheckSelfContact(const CheckedMotion& checked);

}  // namespace clothid

#endif  // CLOTHID_DATASETS_CHECKING_CHECK_EDGES_H_

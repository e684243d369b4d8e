// What each piece of a cloth (sim/scene/pieces.h) has of the terms of its model, per unit of its constants: every term
// is the sum of its pieces, each times its own constant.
#ifndef CLOTHID_SIM_CLOTH_CLOTH_PIECES_H_
#define CLOTHID_SIM_CLOTH_CLOTH_PIECES_H_

#include <Eigen/Core>
#include <vector>

#include "sim/cloth/field_terms.h"
#include "sim/cloth/membrane.h"
#include "sim/scene/scene.h"
#include "sim/shell/triangle_element.h"

namespace clothid {

// The membrane of every piece, with its material. `face_pieces`: of each of the `triangles`, an index of `materials`.
std::vector<MembranePart> MembraneParts(MembraneLaw law, const TriangleElements& triangles,
                                        const std::vector<int>& face_pieces, const std::vector<Material>& materials);

// Of each of the triangles [F] with these pieces: 1 in `piece`, else 0; kWholeCloth: 1 in all.
Eigen::VectorXd PieceMask(int piece, const std::vector<int>& face_pieces);

class ClothPieces {
 public:
  // `bending`: every term of the scene's bending.
  ClothPieces(const Scene& scene, const std::vector<WeightedBending>& bending);

  // Of one piece, or kWholeCloth: a third of the rest area of its triangles at every node [N] m^2, and its bending, a
  // term each.
  const Eigen::VectorXd& areas(int piece) const { return areas_[Place(piece)]; }
  const std::vector<BendingMatrix>& bending(int piece) const { return bending_[Place(piece)]; }

 private:
  std::size_t Place(int piece) const {
    return piece == kWholeCloth ? areas_.size() - 1 : static_cast<std::size_t>(piece);
  }

  std::vector<Eigen::VectorXd> areas_;               // [P + 1], the whole cloth last
  std::vector<std::vector<BendingMatrix>> bending_;  // likewise
};

}  // namespace clothid

#endif  // CLOTHID_SIM_CLOTH_CLOTH_PIECES_H_

// Contacts taken out of the linear system of a step: see "The solver of a step" in sim/README.md.
//
// In the frame (n, t, b) of a slipping node the normal velocity is known, and at a sticking node all three components
// are; what is left is the symmetric matrix Z^T K Z + kappa b b^T, kappa = mu r_N/|u_T|, and the friction coupling mu t
// n^T of slipping nodes, which is not symmetric. The eliminated unknowns keep their rows as identities, so that the
// pattern, and with it the symbolic factorisation, never changes.
#ifndef CLOTHID_SIM_CONTACT_CONTACT_ELIMINATION_H_
#define CLOTHID_SIM_CONTACT_CONTACT_ELIMINATION_H_

#include <Eigen/Core>
#include <Eigen/SparseCore>
#include <vector>

#include "sim/contact/contact.h"
#include "sim/matrix/block_matrix.h"

namespace clothid {

// The axes (n, t, b) of a slipping node, by columns.
struct LocalFrame {
  int block;
  Eigen::Matrix3d axes;
};

// What the eliminated rows of a reduced matrix belong to: the normals of slipping nodes, and sticking nodes, by blocks.
struct HeldBlocks {
  std::vector<LocalFrame> slipping;
  std::vector<int> sticking;

  bool empty() const { return slipping.empty() && sticking.empty(); }
  std::size_t bytes() const { return slipping.size() * sizeof(LocalFrame) + sticking.size() * sizeof(int); }
};

// Directions of a block that contacts hold no more: those that `projection` leaves as they are.
struct FreedBlock {
  int block;
  Eigen::Matrix3d projection;
};

// In place on [3 Nf x s]: from world axes to those of the frames, and back.
void ToLocal(const std::vector<LocalFrame>& frames, Eigen::MatrixXd* vectors);
void ToWorld(const std::vector<LocalFrame>& frames, Eigen::MatrixXd* vectors);

class ContactElimination {
 public:
  // Replaces what an earlier call has set. `free_index` maps nodes to blocks.
  void SetContacts(const std::vector<Contact>& contacts, const std::vector<int>& free_index);

  bool has_coupling() const { return has_coupling_; }  // a slipping node with mu > 0

  HeldBlocks Held() const;
  // What `before` holds and the contacts do not, of `num_blocks` blocks.
  std::vector<FreedBlock> FreedSince(const HeldBlocks& before, int num_blocks) const;

  // values <- the reduced symmetric matrix in the local frames; `matrix` is K.
  void Reduce(const BlockMatrix& matrix, Eigen::VectorXd* values) const;
  // The columns of `blocks`, which ascend, of the same matrix in world axes [3 Nf x 3 blocks].
  Eigen::SparseMatrix<double> ReducedColumns(const BlockMatrix& matrix, const std::vector<int>& blocks) const;

  // In place on [3 Nf x s]: Z Z^T v, without normals of slipping and without sticking nodes.
  void Project(Eigen::MatrixXd* vectors) const;
  void AddFriction(Eigen::MatrixXd* vectors) const;            // v <- (I + mu t n^T) v
  void AddFrictionTransposed(Eigen::MatrixXd* vectors) const;  // v <- (I + mu n t^T) v
  // result += kappa b b^T v.
  void AddSlipStiffness(const Eigen::MatrixXd& vectors, Eigen::MatrixXd* result) const;

  // For A dv = right: the known part of dv (stick and slip normals), zero elsewhere.
  Eigen::MatrixXd KnownPart(const Eigen::MatrixXd& right) const;
  // Right-hand side of the unknowns, from `right` and K times the known part.
  Eigen::MatrixXd ReducedRight(const Eigen::MatrixXd& right, const Eigen::MatrixXd& known,
                               const Eigen::MatrixXd& matrix_known) const;

  // For A^T z = right: z from q, y = (I + mu n t^T) q and K y.
  Eigen::MatrixXd RecoverAdjoint(const Eigen::MatrixXd& right, const Eigen::MatrixXd& q,
                                 const Eigen::MatrixXd& matrix_y) const;

  // values <- A = (I + S) K - S D, by columns.
  void FullJacobian(const BlockMatrix& matrix, Eigen::VectorXd* values) const;
  // v <- (I + S)^T v.
  void AddImpulseTransposed(Eigen::MatrixXd* vectors) const;
  // v <- (I + S) v.
  void AddImpulse(Eigen::MatrixXd* vectors) const;

 private:
  struct Node {
    int block;
    ContactBranch branch;
    Eigen::Matrix3d frame;        // columns n, t, b of a slipping node
    Eigen::Matrix3d impulse;      // S
    double friction_coefficient;  // mu
    double weight;                // d
    double slip_stiffness;        // kappa
    double slip_compliance;       // 1/(1 + c)

    // Z Z^T: onto what the contact leaves free.
    Eigen::Matrix3d projection() const;
  };
  // [num_blocks] the place of their nodes in `nodes_`; -1: those touch nothing.
  std::vector<int> Places(int num_blocks) const;

  std::vector<Node> nodes_;
  bool has_coupling_ = false;
};

}  // namespace clothid

#endif  // CLOTHID_SIM_CONTACT_CONTACT_ELIMINATION_H_

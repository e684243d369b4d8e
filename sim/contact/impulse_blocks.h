// The derivatives of the equations of a solve that has impulses r among its unknowns, those of the cloth's contacts
// with itself (self_contact.h): how they depend on where it starts and on their friction. With w, n and gap functions
// of x_n,
//   dg = .. - sum_c (dw_i r + w_i dr)                          at node i of a pair
//   dR = (dR/dx_n) dx_n + (dR/dmu) dmu + (dR/dv_h) dv_h        at fixed v and r
// Handles among the nodes have their part in x_n, and their velocities v_h are given.
#ifndef CLOTHID_SIM_CONTACT_IMPULSE_BLOCKS_H_
#define CLOTHID_SIM_CONTACT_IMPULSE_BLOCKS_H_

#include <Eigen/Core>
#include <Eigen/SparseCore>

#include "sim/contact/contact_set.h"

namespace clothid {

// Blocks over all nodes, handles and all, and over the c impulses; without any nothing, not even their sizes.
struct ImpulseBlocks {
  using Block = Eigen::SparseMatrix<double, Eigen::RowMajor>;

  Block spread;              // J^T [3N x 3c]
  Block weights;             // -sum r dw_i/dx_n [3N x 3N]
  Block geometry;            // dR/dx_n [3c x 3N]
  Block speeds;              // dR/dv, of handles dR/dv_h [3c x 3N]
  Eigen::VectorXd friction;  // dR/dmu [3c]

  bool is_empty() const { return friction.size() == 0; }
};

// Of `contacts` of a solve from `start_positions` x_n [3N] that ends with `velocities` [3N].
ImpulseBlocks DifferentiateImpulses(const ContactSet& contacts, const Eigen::VectorXd& start_positions,
                                    const Eigen::VectorXd& velocities);

}  // namespace clothid

#endif  // CLOTHID_SIM_CONTACT_IMPULSE_BLOCKS_H_

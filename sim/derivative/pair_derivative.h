// How the contacts of a cloth with itself depend on where a solve starts and on their friction
// (sim/contact/self_contact.h): with w, n and gap functions of x_n,
//   dg  = .. - sum_c dw_i r        at node i of a pair, at fixed v and r
//   dR  = (dR/dx_n) dx_n + (dR/dmu) dmu + (dR/dv_h) dv_h
// Handles among the nodes have their part in x_n, and their velocities v_h are given.
#ifndef CLOTHID_SIM_DERIVATIVE_PAIR_DERIVATIVE_H_
#define CLOTHID_SIM_DERIVATIVE_PAIR_DERIVATIVE_H_

#include <Eigen/Core>
#include <array>
#include <vector>

#include "sim/cloth/cloth_model.h"
#include "sim/contact/self_contact.h"

namespace clothid {

// The rows of a pair's nodes in columns over some of all nodes, of which the pair's have the numbers `blocks`, -1:
// none, whose rows are zero; and the sum into such columns. `PairCandidate::blocks`: columns over the free nodes
// [3 Nf x s].
using PairBlocks = std::array<int, 4>;
using PairColumns = Eigen::Matrix<double, 12, Eigen::Dynamic>;
PairColumns GatherFromPair(const PairBlocks& blocks, const Eigen::MatrixXd& columns);
void ScatterToPair(const PairBlocks& blocks, const PairColumns& values, Eigen::MatrixXd* columns);

// What columns are over.
enum class PairNodes : char {
  kFree,     // the free nodes [3 Nf x s]
  kHandles,  // the scene's handles, in their order [3H x s]
};

class PairDerivative {
 public:
  // `contacts` of a solve from `start_positions` x_n that ends with `velocities` [3N]. Model and contacts must outlive
  // this.
  PairDerivative(const ClothModel& model, const std::vector<PairContact>& contacts,
                 const Eigen::VectorXd& start_positions, const Eigen::VectorXd& velocities);

  const std::vector<PairContact>& contacts() const { return contacts_; }
  Eigen::Index num_rows() const { return 3 * static_cast<Eigen::Index>(contacts_.size()); }  // 3c
  const PairGeometryGradient& gradient(std::size_t contact) const { return gradients_[contact]; }

  // The numbers of a pair's nodes in columns over `nodes`.
  const PairBlocks& blocks(std::size_t contact, PairNodes nodes) const {
    return nodes == PairNodes::kFree ? contacts_[contact].candidate.blocks : handle_blocks_[contact];
  }

  // On columns of dx_n over `nodes`: the part of dg, -sum dw_i r, over the nodes `rows`, and dR [3c x s].
  Eigen::MatrixXd TimesWeights(const Eigen::MatrixXd& columns, PairNodes nodes = PairNodes::kFree,
                               PairNodes rows = PairNodes::kFree) const;
  Eigen::MatrixXd TimesGeometry(const Eigen::MatrixXd& columns, PairNodes nodes = PairNodes::kFree) const;
  // Their transposes, of columns over `rows` and [3c x s].
  Eigen::MatrixXd TimesWeightsTransposed(const Eigen::MatrixXd& columns, PairNodes nodes = PairNodes::kFree,
                                         PairNodes rows = PairNodes::kFree) const;
  Eigen::MatrixXd TimesGeometryTransposed(const Eigen::MatrixXd& rows, PairNodes nodes = PairNodes::kFree) const;

  // dR [3c x s] of columns of dv_h [3H x s], and the transpose.
  Eigen::MatrixXd TimesHandleVelocities(const Eigen::MatrixXd& columns) const;
  Eigen::MatrixXd TimesHandleVelocitiesTransposed(const Eigen::MatrixXd& rows) const;

  // sum w_i dr over `nodes` of columns of dr [3c x s], and the transpose.
  Eigen::MatrixXd Spread(const Eigen::MatrixXd& impulses, PairNodes nodes) const;
  Eigen::MatrixXd SpreadTransposed(const Eigen::MatrixXd& columns, PairNodes nodes) const;

  // dR/dmu [3c].
  Eigen::VectorXd FrictionDerivative() const;

 private:
  Eigen::Index NumRows(PairNodes nodes) const;                           // of columns over `nodes`
  Eigen::Matrix<double, 3, 12> ByVelocities(std::size_t contact) const;  // dR/dv of its nodes

  const ClothModel& model_;
  const std::vector<PairContact>& contacts_;
  std::vector<PairBlocks> handle_blocks_;  // of their nodes among the handles
  std::vector<PairGeometryGradient> gradients_;
  std::vector<Eigen::Matrix<double, 3, 12>> jacobians_;  // dR/dx_n
};

}  // namespace clothid

#endif  // CLOTHID_SIM_DERIVATIVE_PAIR_DERIVATIVE_H_

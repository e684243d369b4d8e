// A force in a cloth, as all that simulates and differentiates meets it: its value over a solve, a step or a stage of
// one (sim/step/step_problem.h), and the derivatives of that by all that it depends on. To add a force: sim/README.md.
//
// At the end of a solve of size h a force f [3N] is a function of the positions x there, of the velocities v over the
// solve, of the time, of the parameters theta, and of what the solve starts from: the positions x_o of origins, from
// which strain rates are taken, and the positions x^ that its start predicts. `force` is always over the nodes [3N].
#ifndef CLOTHID_SIM_FORCE_FORCE_TERM_H_
#define CLOTHID_SIM_FORCE_FORCE_TERM_H_

#include <Eigen/Core>
#include <Eigen/SparseCore>
#include <functional>
#include <memory>
#include <optional>
#include <vector>

#include "sim/force/force_part.h"
#include "sim/matrix/block_matrix.h"
#include "sim/scene/parameters.h"
#include "sim/scene/scene.h"
#include "sim/shell/strain_rate_damping.h"
#include "sim/shell/triangle_element.h"

namespace clothid {

struct FieldFactors;  // sim/scene/material_field.h

// Forces whose sum over a solve has a size and a potential of its own.
enum class ForceGroup {
  kElastic,  // of an energy of the positions and the time
  kAir,      // of what is around the cloth
  kViscous,  // of a dissipation potential in the cloth
};

// What an elastic energy is told as.
enum class EnergyShare { kStretch, kBending, kSeams };

// The end of a solve.
struct ForcePoint {
  const Parameters& parameters;
  double time_step;                   // h of the solve, s
  double time;                        // s, on the scene's clock
  const Eigen::VectorXd& positions;   // x [3N] m
  const Eigen::VectorXd& velocities;  // v [3N] m/s; may be empty where no term needs them
  ThreadTeam* team = nullptr;         // shares the work of Hessians; null: the caller alone. No number depends on it
};

// Its start.
struct ForceStart {
  std::vector<StrainOrigin> origins;  // x_o; empty where no term needs them
  Eigen::VectorXd predicted;          // x^ [3N] m, likewise
};

// What a term computes once for a solve from its start.
class HeldForce {
 public:
  virtual ~HeldForce() = default;
};

// What may vary over the cloth, for `ForceTerm::SetVariation`.
struct ForceVariation {
  const Scene& scene;
  const Parameters& parameters;
  bool fields, pieces;  // which of them are others than before
  const std::vector<int>& free_index;
  const BlockPattern& pattern;

  // The factors of a field over the triangles [F], 1 where the parameters have none; nothing where the scene has no
  // such field or it is as before.
  std::optional<Eigen::VectorXd> FieldOf(ParameterKind kind) const;
  // Likewise of the pieces, the constant of each to that of the whole.
  std::optional<Eigen::VectorXd> PiecesOf(ParameterKind kind) const;
};

class ForceTerm {
 public:
  virtual ~ForceTerm() = default;

  virtual ForceGroup group() const = 0;
  virtual EnergyShare energy_share() const { return EnergyShare::kStretch; }  // of an elastic one

  // What it depends on beside x, the time and theta. A term without does nothing in what is named after them below.
  virtual bool needs_velocities() const { return false; }
  virtual bool needs_origins() const { return false; }
  virtual bool needs_prediction() const { return false; }

  // Takes over how its constants vary over the cloth.
  virtual void SetVariation(const ForceVariation&) {}

  // Of a term that needs origins or a prediction: makes `held` what it keeps of `start`, for the solve that ends at
  // `time`; memory is used again.
  virtual void Hold(const Parameters&, double /*time*/, const ForceStart&, std::unique_ptr<HeldForce>* /*held*/) const {
  }

  // Adds f and returns the potential of it over the solve, J: -d/dv of it is h f where x = .. + h v.
  virtual double AddForce(const ForcePoint& point, const HeldForce* held, Eigen::VectorXd* force) const = 0;

  // Adds factor * -df/dx below the diagonal of `hessian`, for `BlockMatrix::CompleteFromLower`.
  virtual void AddPositionHessian(double /*factor*/, HessianKind, const ForcePoint&, const HeldForce*,
                                  BlockMatrix* /*hessian*/) const {}

  // Adds factor * -df/dv, to a matrix that is whole on either side of its diagonal; and its product with columns y
  // [3N x s]. Symmetric.
  virtual void AddVelocityHessian(double /*factor*/, const ForcePoint&, const HeldForce*,
                                  BlockMatrix* /*hessian*/) const {}
  virtual void AddVelocityProduct(double /*factor*/, const ForcePoint&, const HeldForce*,
                                  const Eigen::MatrixXd& /*columns*/, Eigen::MatrixXd* /*product*/) const {}

  // Adds factor * -df/dx_o y by the positions `origin` of one that has the share 1, and its transpose times y.
  virtual void AddOriginProduct(double /*factor*/, const ForcePoint&, const Eigen::VectorXd& /*origin*/,
                                const Eigen::MatrixXd& /*columns*/, Eigen::MatrixXd* /*product*/) const {}
  virtual void AddOriginProductTransposed(double /*factor*/, const ForcePoint&, const Eigen::VectorXd& /*origin*/,
                                          const Eigen::MatrixXd& /*columns*/, Eigen::MatrixXd* /*product*/) const {}

  // Adds factor * df/dx^ y, and its transpose times y. `predicted`: x^.
  virtual void AddPredictionProduct(double /*factor*/, const ForcePoint&, const HeldForce*,
                                    const Eigen::VectorXd& /*predicted*/, const Eigen::MatrixXd& /*columns*/,
                                    Eigen::MatrixXd* /*product*/) const {}
  virtual void AddPredictionProductTransposed(double /*factor*/, const ForcePoint&, const HeldForce*,
                                              const Eigen::VectorXd& /*predicted*/, const Eigen::MatrixXd& /*columns*/,
                                              Eigen::MatrixXd* /*product*/) const {}

  // Adds what it turns the clamps by, -dE/dd [3C] N m of an elastic one, at the slopes d that it has of the scene at
  // the time (Handles::slopes).
  virtual void AddSlopeForce(const ForcePoint&, Eigen::VectorXd* /*force*/) const {}

  // Adds factor * df/dtheta for the parameter `id`; nothing for one that it does not have.
  virtual void AddDerivative(ParameterId /*id*/, double /*factor*/, const ForcePoint&, const HeldForce*,
                             Eigen::VectorXd* /*force*/) const {}

  // Of a constant that is a field, theta_f the logarithm of its value in triangle f: adds factor * df/dtheta_f . y to
  // `products` [F x s], F triangles of the mesh. Nothing for a field that it does not have.
  virtual void AddFieldProducts(const FieldFactors& /*field*/, double /*factor*/, const ForcePoint&,
                                const Eigen::MatrixXd& /*columns*/, Eigen::Ref<Eigen::MatrixXd> /*products*/) const {}
  // What adds factor * df along changes of these logarithms, `weights` [F]: the changes times the factors of the field.
  // Empty for a field that it does not have.
  using FieldDirection = std::function<void(double factor, const ForcePoint& point, Eigen::VectorXd* force)>;
  virtual FieldDirection AlongField(ParameterKind, const Eigen::VectorXd& /*weights*/) const { return nullptr; }

  // What it adds to the constant matrix of projective dynamics (sim/cloth/system_matrix.h): so many times L, kg; and a
  // matrix of its own times so many kg m^2/N.
  virtual double LaplacianWeight(const Material&, double /*time_step*/) const { return 0.0; }
  struct ConstantPart {
    double weight;
    const Eigen::SparseMatrix<double>* matrix;  // [N x N]
    const Eigen::VectorXd* diagonal;            // of it [N]
  };
  virtual std::optional<ConstantPart> SystemPart(const Material&, double /*time_step*/) const { return std::nullopt; }

  // Whether it may be stiffer than in that matrix, and how many times it is so at `point`, at least 1: what its force
  // is rounded by grows likewise.
  virtual bool stiffens() const { return false; }
  virtual double StiffnessGrowth(const ForcePoint&) const { return 1.0; }

  // Calls `visit` with sets of nodes, each with one of those in `is_chosen` [N], that it couples beside triangles.
  using NodeVisitor = std::function<void(std::vector<int> nodes)>;
  virtual void VisitCoupled(const std::vector<bool>& /*is_chosen*/, const NodeVisitor& /*visit*/) const {}
  // The same term of what acts on the chosen nodes of `part`, over its nodes, with what varies as it is now.
  virtual std::unique_ptr<ForceTerm> PartOf(const ForcePart& part) const = 0;
};

}  // namespace clothid

#endif  // CLOTHID_SIM_FORCE_FORCE_TERM_H_

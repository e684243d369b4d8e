// What resists strain in the surface of a cloth: the energy of the law that its scene has, with the constants of a
// material, or, of a cloth of pieces, of a material each.
#ifndef CLOTHID_SIM_CLOTH_MEMBRANE_H_
#define CLOTHID_SIM_CLOTH_MEMBRANE_H_

#include <Eigen/Core>
#include <memory>
#include <variant>
#include <vector>

#include "sim/cloth/orthotropic_energy.h"
#include "sim/cloth/stretch_energy.h"
#include "sim/scene/parameters.h"
#include "sim/scene/scene.h"

namespace clothid {

struct MembranePart;

class Membrane {
 public:
  // An orthotropic law wants the shape gradients of `triangles` in axes along warp and weft.
  Membrane(MembraneLaw law, std::shared_ptr<const TriangleElements> triangles);
  // The sum of those of pieces, which have their materials in place of those given below.
  explicit Membrane(std::vector<MembranePart> parts);
  // Other materials for these parts; nothing where there are none.
  void SetMaterials(const std::vector<Material>& materials);

  // Adds -dE/dx to `force` [3N] and returns E for positions [3N], J.
  double AddForce(const Material& material, const Eigen::VectorXd& positions, Eigen::VectorXd* force) const;

  // Adds factor * d2E/dx2 below the diagonal of `hessian`, for `BlockMatrix::CompleteFromLower`.
  void AddHessian(double factor, const Material& material, HessianKind kind, const Eigen::VectorXd& positions,
                  BlockMatrix* hessian) const;

  // Adds factor * (-d2E/(dx dtheta)) to `force` [3N], theta the constant `id`: E is linear in it. Nothing for one
  // that the law does not have.
  void AddForceDerivative(ParameterId id, double factor, const Eigen::VectorXd& positions,
                          Eigen::VectorXd* force) const;

  // k of the constant matrix of projective dynamics, P = .. + h^2 k L, N/m: of an orthotropic law the largest
  // eigenvalue of its constants.
  double SystemStiffness(const Material& material) const;

 private:
  std::variant<StretchEnergy, OrthotropicEnergy, std::shared_ptr<const std::vector<MembranePart>>> energy_;
};

// A piece, or what belongs to none.
struct MembranePart {
  Membrane membrane;
  Material material;
};

}  // namespace clothid

#endif  // CLOTHID_SIM_CLOTH_MEMBRANE_H_

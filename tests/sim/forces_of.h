// The forces of a model by their types, for tests of their formulas.
#ifndef CLOTHID_TESTS_SIM_FORCES_OF_H_
#define CLOTHID_TESTS_SIM_FORCES_OF_H_

#include <vector>

#include "sim/cloth/cloth_model.h"
#include "sim/force/membrane.h"
#include "sim/force/seam_term.h"

namespace clothid {

inline const Membrane& MembraneOf(const ClothModel& model) { return model.forces().Find<MembraneTerm>()->membrane(); }

inline std::vector<const BendingTerm*> BendingOf(const ClothModel& model) {
  std::vector<const BendingTerm*> found;
  for (const auto& term : model.forces().terms()) {
    if (const auto* bending = dynamic_cast<const BendingTerm*>(term.get())) found.push_back(bending);
  }
  return found;
}

// Adds `stiffness` times the force of a term of bending whose constant is 1, at the time 0, and returns its energy
// then.
inline double AddBendingForce(const BendingTerm& term, double stiffness, const Eigen::VectorXd& positions,
                              Eigen::VectorXd* force) {
  Parameters unit;
  unit.material.*RowOf(term.kind()).constant = 1.0;
  Eigen::VectorXd own = Eigen::VectorXd::Zero(positions.size());
  const double energy = term.AddForce({unit, 0.0, 0.0, positions, positions}, nullptr, &own);
  *force += stiffness * own;
  return energy;
}

inline const SeamEnergy& SeamsOf(const ClothModel& model) { return model.forces().Find<SeamTerm>()->energy(); }

}  // namespace clothid

#endif  // CLOTHID_TESTS_SIM_FORCES_OF_H_

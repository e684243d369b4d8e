// What would help a candidate most.
#ifndef CLOTHID_IDENTIFY_EXPERIMENT_IMPROVEMENT_H_
#define CLOTHID_IDENTIFY_EXPERIMENT_IMPROVEMENT_H_

#include <Eigen/Core>
#include <string>
#include <vector>

#include "identify/experiment/cloth_information.h"
#include "identify/experiment/expectation.h"
#include "identify/experiment/planned_experiment.h"

namespace clothid {

// The cloths of a candidate that could be simulated, with the rows of the plan.
std::vector<ClothRows> PlannedRows(const std::vector<ClothInformation>& cloths);

// All but kBothScenes, in the order of their kinds, for the parameters `names` of the plan, of which `planned`, what is
// expected of the candidate itself, may have some only. `worst` is left open.
std::vector<Improvement> FindImprovements(const std::vector<std::string>& names,
                                          const std::vector<ClothInformation>& cloths, const Expectation& planned);

// kBothScenes with `partner`. `of_joint`: over the cloths that both could simulate.
Improvement FindPartner(const std::vector<std::string>& names, const Expectation& planned, const Expectation& of_joint,
                        int partner);

// Fills `worst`, with `worst_told` of the names; what helps it the most comes first, then what helps the others.
void SortImprovements(int worst_told, std::vector<Improvement>* improvements);

}  // namespace clothid

#endif  // CLOTHID_IDENTIFY_EXPERIMENT_IMPROVEMENT_H_

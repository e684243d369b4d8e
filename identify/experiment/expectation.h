// From what single cloths tell to what a plan expects of a recording.
#ifndef CLOTHID_IDENTIFY_EXPERIMENT_EXPECTATION_H_
#define CLOTHID_IDENTIFY_EXPERIMENT_EXPECTATION_H_

#include <Eigen/Core>
#include <algorithm>
#include <string>
#include <vector>

#include "costs/prediction/parameter_block.h"
#include "identify/experiment/planned_experiment.h"
#include "identify/uncertainty/uncertainty.h"

namespace clothid {

// One cloth of a recording, or of two that are fitted jointly.
struct ClothRows {
  std::vector<ParameterBlock> blocks;
  Eigen::VectorXd coordinates;  // [p]
  Eigen::MatrixXd rows;         // [r x p] of the parameters alone, without priors
  int num_measurements = 0;
  // Of the nominal cloth: blocks whose interval would be that of a dent of a rough cost, even where frames count by the
  // error of the step (identify/estimate/interval_check.h). They are not told, and what is known was believed before.
  std::vector<int> rough;
};

struct ClothInformation;

// `rows`: those of what is planned or of what might be.
ClothRows RowsOf(const ClothInformation& cloth, const Eigen::MatrixXd& rows);

// The standard deviations [p] of q of what `cloth` tells with what is believed beforehand, of every parameter by
// itself:
//   1/sqrt(1/std^2 + 1/believed^2),
// std with the priors of all, believed from the bounds where it has none. NaN of frozen parameters.
Eigen::VectorXd StdWithBelief(const ClothRows& cloth);
// What a change of q by 1 is, of the logarithm or of the value.
double UnitOf(const ParameterBlock& block);

// Of recordings of the same kind, a cloth each, the nominal one first.
class Expectation {
 public:
  // `step_errors` [p] of q, of the nominal cloth; empty or NaN: not known. At least one cloth.
  Expectation(const std::vector<ClothRows>& cloths, const Eigen::VectorXd& step_errors);

  // Of block i, without known_start_std.
  ExpectedParameter Parameter(int block) const;
  // Root mean square over the cloths that tell it, as ExpectedParameter::std; NaN where none does.
  double Std(int block) const;
  double told_share(int block) const;
  bool is_told(int block) const { return told_share(block) > 0.5 && !is_rough(block) && !IsLostToStep(block); }
  // [p] standard deviations with belief and `step_share` of the step's error: root mean squares over all cloths.
  Eigen::VectorXd Widths(double step_share) const;
  const std::vector<ParameterBlock>& blocks() const { return nominal_.blocks; }

 private:
  bool IsTold(const Uncertainty& cloth, int block) const;
  bool is_rough(int block) const {
    return std::find(nominal_.rough.begin(), nominal_.rough.end(), block) != nominal_.rough.end();
  }
  // Whether the error of the step leaves it hardly told, as a fit says it (identify/uncertainty/uncertainty.h).
  bool IsLostToStep(int block) const;
  std::string WhyNotTold(int block) const;
  std::string MadeUpBy(int block) const;

  ClothRows nominal_;
  Eigen::VectorXd step_errors_, squared_widths_;  // [p]
  std::vector<Uncertainty> judged_;               // a cloth each
};

}  // namespace clothid

#endif  // CLOTHID_IDENTIFY_EXPERIMENT_EXPECTATION_H_

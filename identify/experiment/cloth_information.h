// What a fit of one recorded cloth would know of the parameters, and what it would know were the recording another.
#ifndef CLOTHID_IDENTIFY_EXPERIMENT_CLOTH_INFORMATION_H_
#define CLOTHID_IDENTIFY_EXPERIMENT_CLOTH_INFORMATION_H_

#include <Eigen/Core>
#include <map>
#include <string>
#include <vector>

#include "costs/prediction/parameter_block.h"
#include "datasets/motion/recorded_motion.h"
#include "identify/experiment/candidate.h"
#include "identify/experiment/plan_options.h"
#include "identify/experiment/planned_experiment.h"
#include "identify/uncertainty/uncertainty.h"

namespace clothid {

struct ClothInformation {
  std::string failure;  // one line; empty: all that follows is there
  std::vector<ParameterBlock> blocks;
  Eigen::VectorXd coordinates;  // [p] q of the truth
  int num_measurements = 0;
  // Of the parameters alone, everything else eliminated, without priors: rows [r x p] with the J^T J of the marginal.
  Eigen::MatrixXd planned;
  std::map<ImprovementKind, Eigen::MatrixXd> improved;  // those that the recording leaves open
  // Of the nominal cloth: the error of the step [p], of q; NaN: not known. Where the information sits, a column for
  // each of `blocks`; and the recording that was planned.
  Eigen::VectorXd step_errors;
  std::vector<int> rough;  // see `ClothRows`
  InformationMap map;
  RecordedMotion recording;
  Eigen::MatrixXf nodes;             // [3N x T] m, all of that cloth
  Eigen::MatrixXd start_directions;  // [n x c] of its unknown start (identify/experiment/informed_start.h)
};

// `nominal`: that of cloth 0, along whose directions the starts of others are looked at; of cloth 0 it does not matter.
ClothInformation InformCloth(const PlanOptions& options, const Candidate& candidate, int cloth,
                             const ClothInformation& nominal);

// What was believed of a block before: the standard deviation of q.
double StdBefore(const ParameterBlock& block);

// As after a fit that ended at the truth, of rows as above.
Uncertainty JudgeRows(const std::vector<ParameterBlock>& blocks, const Eigen::VectorXd& coordinates,
                      const Eigen::MatrixXd& rows, int num_measurements);

}  // namespace clothid

#endif  // CLOTHID_IDENTIFY_EXPERIMENT_CLOTH_INFORMATION_H_

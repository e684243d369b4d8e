// What is believed of parameters, as residuals of Ceres: (q - centre)/std of a block with a prior; and that the wind
// changes little from knot to knot of its profile, (q_i - q_j)/std of two blocks (`ParameterBlock::linked_to`), which
// are the increments of a random walk.
#ifndef CLOTHID_IDENTIFY_FIT_PRIOR_COSTS_H_
#define CLOTHID_IDENTIFY_FIT_PRIOR_COSTS_H_

#include <ceres/cost_function.h>

#include <memory>
#include <vector>

#include "costs/prediction/parameter_block.h"
#include "datasets/motion/recorded_motion.h"

namespace clothid {

// Links every knot to the one before it, where both are among `blocks`, of the same component and recording: their
// difference has the standard deviation smoothness sqrt(time between them), m/s. Smoothness: m/s in a second, > 0.
// Throws `Error` (kUsage) where no two are.
void LinkKnots(const std::vector<RecordedMotion>& motions, double smoothness, std::vector<ParameterBlock>* blocks);

// One row: of the coordinate of a block; of it and of that which it is linked to. Null where nothing is believed.
std::unique_ptr<ceres::CostFunction> MakePriorCost(const ParameterBlock& block);
std::unique_ptr<ceres::CostFunction> MakeLinkCost(const ParameterBlock& block);

}  // namespace clothid

#endif  // CLOTHID_IDENTIFY_FIT_PRIOR_COSTS_H_

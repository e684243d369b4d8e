// The card of a cloth (datasets/fabric/fabric_card.h) from what a fit found.
#ifndef CLOTHID_IDENTIFY_CARD_CARD_OF_FIT_H_
#define CLOTHID_IDENTIFY_CARD_CARD_OF_FIT_H_

#include <Eigen/Core>
#include <vector>

#include "datasets/fabric/fabric_card.h"
#include "datasets/motion/recorded_motion.h"
#include "identify/estimate/fit_summary.h"
#include "identify/repetition/repetitions.h"
#include "identify/verdict/fit_checks.h"

namespace clothid {

// `nodes`: of every recording the nodes of its cloth at the estimate [3N x T] m, or empty: then it tells no range. Laws
// and nominal values are those of the first recording. Constants that recordings have for themselves (`--each`) are
// those of the first, as in exports; of repetitions the card has the mean, its interval and the scatter. Constants of
// pieces are left out, of a field the card has the level.
FabricCard CardOfFit(const FitSummary& summary, const FitChecks& checks, const std::vector<RecordedMotion>& motions,
                     const std::vector<Eigen::MatrixXd>& nodes);

// Of finished fits that were judged together: the card of the first, which there must be, with the means of what was
// pooled, their scatter, and the recordings and ranges of all.
FabricCard PooledCard(const std::vector<FabricCard>& cards, const Repetitions& repetitions);

// Whether it has forces and nothing else.
bool IsTensileCurve(const RecordedMotion& motion);

}  // namespace clothid

#endif  // CLOTHID_IDENTIFY_CARD_CARD_OF_FIT_H_

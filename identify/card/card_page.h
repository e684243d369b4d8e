// card.html: the card of a cloth for people.
#ifndef CLOTHID_IDENTIFY_CARD_CARD_PAGE_H_
#define CLOTHID_IDENTIFY_CARD_CARD_PAGE_H_

#include <Eigen/Core>
#include <string>
#include <vector>

#include "datasets/fabric/fabric_card.h"
#include "datasets/motion/recorded_motion.h"
#include "identify/estimate/fit_summary.h"

namespace clothid {

// One file that any browser shows offline, without a library: constants with intervals and where they were seen, how
// they were measured, and of every tensile curve the force over the strain, measured and fitted. `nodes` as for
// `CardOfFit`.
std::string CardHtml(const FabricCard& card, const FitSummary& summary, const std::vector<RecordedMotion>& motions,
                     const std::vector<Eigen::MatrixXd>& nodes);

}  // namespace clothid

#endif  // CLOTHID_IDENTIFY_CARD_CARD_PAGE_H_

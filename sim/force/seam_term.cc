#include "sim/force/seam_term.h"

#include <algorithm>

namespace clothid {

double SeamTerm::AddForce(const ForcePoint& point, const HeldForce*, Eigen::VectorXd* force) const {
  return energy_.AddForce(point.time, point.positions, force);
}

void SeamTerm::AddPositionHessian(double factor, HessianKind, const ForcePoint&, const HeldForce*,
                                  BlockMatrix* hessian) const {
  energy_.AddHessian(factor, hessian);
}

std::optional<ForceTerm::ConstantPart> SeamTerm::SystemPart(const Material&, double time_step) const {
  return ConstantPart{time_step * time_step, &energy_.matrix(), &energy_.diagonal()};
}

void SeamTerm::VisitCoupled(const std::vector<bool>& is_chosen, const NodeVisitor& visit) const {
  for (const SeamEnergy::Link& link : energy_.links()) {
    if (std::any_of(link.nodes.begin(), link.nodes.end(), [&](int node) { return is_chosen[node]; })) {
      visit({link.nodes.begin(), link.nodes.end()});
    }
  }
}

std::unique_ptr<ForceTerm> SeamTerm::PartOf(const ForcePart& part) const {
  std::vector<SeamEnergy::Link> links;
  for (const SeamEnergy::Link& link : energy_.links()) {
    if (!part.Touches(link.nodes)) continue;
    links.push_back(link);
    for (int& node : links.back().nodes) node = part.index[node];
  }
  return std::make_unique<SeamTerm>(
      SeamEnergy(std::move(links), PartOfMatrix(energy_.matrix(), part), part.blocks, *part.pattern));
}

}  // namespace clothid

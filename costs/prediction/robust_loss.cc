#include "costs/prediction/robust_loss.h"

#include <cmath>
#include <optional>
#include <string_view>

#include "sim/base/error.h"
#include "sim/base/text_file.h"

namespace clothid {
namespace {

// rho(s) and sqrt(rho'(s)) of the Huber loss.
void Huber(double scale, double squared, double* rho, double* weight) {
  if (squared <= scale * scale) {
    *rho = squared;
    *weight = 1.0;
    return;
  }
  const double norm = std::sqrt(squared);
  *rho = 2.0 * scale * norm - scale * scale;
  *weight = std::sqrt(scale / norm);
}

// The same of the Cauchy loss.
void Cauchy(double scale, double squared, double* rho, double* weight) {
  const double ratio = squared / (scale * scale);
  *rho = scale * scale * std::log1p(ratio);
  *weight = 1.0 / std::sqrt(1.0 + ratio);
}

// One past the last row of the reading of a force that starts at `begin`.
Eigen::Index EndOfForce(const ForceObservation& forces, Eigen::Index first_row, Eigen::Index begin, Eigen::Index size) {
  const SeenForce& first = forces.seen()[first_row + begin];
  Eigen::Index end = begin + 1;
  while (end < size) {
    const SeenForce& next = forces.seen()[first_row + end];
    if (next.reading != first.reading || next.row / 3 != first.row / 3) break;
    ++end;
  }
  return end;
}

// One past the last row of the point in one frame, or of the force, that starts at `begin`.
Eigen::Index EndOfPoint(const Observation& observation, int first_row, Eigen::Index begin, Eigen::Index size) {
  const int num_before = observation.first_force_row();
  if (first_row + begin >= num_before) return EndOfForce(observation.forces(), first_row - num_before, begin, size);
  const SeenCoordinate& first = observation.coordinates()[first_row + begin];
  Eigen::Index end = begin + 1;
  while (end < size && first_row + end < num_before) {
    const SeenCoordinate& next = observation.coordinates()[first_row + end];
    if (next.frame != first.frame || next.point != first.point) break;
    ++end;
  }
  return end;
}

}  // namespace

RobustLoss ParseRobustLoss(const std::string& text) {
  RobustLoss loss;
  if (text == "none") return loss;
  const std::size_t colon = text.find(':');
  const std::string name = text.substr(0, colon);
  if (colon != std::string::npos && (name == "huber" || name == "cauchy")) {
    const std::optional<double> scale = ParseNumber(std::string_view(text).substr(colon + 1));
    loss.kind = name == "huber" ? RobustLoss::Kind::kHuber : RobustLoss::Kind::kCauchy;
    loss.scale = scale.value_or(0.0);
    // Scales whose square is no number that one can divide by are no scales.
    if (std::isnormal(loss.scale * loss.scale) && loss.scale > 0.0) return loss;
  }
  throw Error(ErrorKind::kUsage,
              "loss '" + Printable(text) + "': expected none, huber:A or cauchy:A with A > 0, in standard deviations");
}

Influence InfluenceOn(const RobustLoss& loss, double squared) {
  const double limit = loss.scale * loss.scale;
  if (loss.kind == RobustLoss::Kind::kHuber && squared > limit) {
    const double first = loss.scale / std::sqrt(squared);
    return {first, -0.5 * first / squared};
  }
  if (loss.kind == RobustLoss::Kind::kCauchy) {
    const double first = 1.0 / (1.0 + squared / limit);
    return {first, -first * first / limit};
  }
  return {};
}

double LossWeights(const RobustLoss& loss, const Observation& observation, int first_row,
                   const Eigen::VectorXd& residuals, Eigen::VectorXd* weights) {
  weights->setOnes(residuals.size());
  if (observation.error_weights().size() > 0) {
    *weights = observation.error_weights().segment(first_row, residuals.size());
  }
  if (!loss.is_robust()) return 0.5 * weights->cwiseProduct(residuals).squaredNorm();
  double cost = 0.0;
  for (Eigen::Index begin = 0; begin < residuals.size();) {
    const Eigen::Index end = EndOfPoint(observation, first_row, begin, residuals.size());
    double rho = 0.0, weight = 1.0;
    auto own = weights->segment(begin, end - begin);
    const double squared = own.cwiseProduct(residuals.segment(begin, end - begin)).squaredNorm();
    (loss.kind == RobustLoss::Kind::kHuber ? Huber : Cauchy)(loss.scale, squared, &rho, &weight);
    own *= weight;
    cost += 0.5 * rho;
    begin = end;
  }
  return cost;
}

}  // namespace clothid

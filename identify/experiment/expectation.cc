#include "identify/experiment/expectation.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "identify/experiment/cloth_information.h"
#include "identify/uncertainty/hidden_direction.h"
#include "identify/uncertainty/priors.h"

namespace clothid {
namespace {

constexpr double kNaN = std::numeric_limits<double>::quiet_NaN();
// A parameter takes part in a direction from this share of its largest entry on, as its words tell it.
constexpr double kTakesPart = 0.01;

}  // namespace

ClothRows RowsOf(const ClothInformation& cloth, const Eigen::MatrixXd& rows) {
  return {cloth.blocks, cloth.coordinates, rows, cloth.num_measurements, cloth.rough};
}

double UnitOf(const ParameterBlock& block) { return block.scale == ParameterScale::kLog ? 1.0 : block.unit; }

Eigen::VectorXd StdWithBelief(const ClothRows& cloth) {
  std::vector<int> free;
  for (int i = 0; i < static_cast<int>(cloth.blocks.size()); ++i) {
    if (!cloth.blocks[i].frozen) free.push_back(i);
  }
  const Posterior posterior(cloth.blocks, cloth.rows, free);
  Eigen::VectorXd stds = Eigen::VectorXd::Constant(cloth.rows.cols(), kNaN);
  for (std::size_t k = 0; k < free.size(); ++k) {
    const ParameterBlock& block = cloth.blocks[free[k]];
    const double precision = std::pow(posterior.jacobian().CoordinateStd(static_cast<Eigen::Index>(k)), -2);
    const double believed = block.prior.is_given() ? 0.0 : std::pow(BelievedStd(block), -2);
    stds[free[k]] = 1.0 / std::sqrt(precision + believed);
  }
  return stds;
}

Expectation::Expectation(const std::vector<ClothRows>& cloths, const Eigen::VectorXd& step_errors)
    : nominal_(cloths.front()), step_errors_(step_errors) {
  const Eigen::Index size = nominal_.coordinates.size();
  if (step_errors_.size() == 0) step_errors_ = Eigen::VectorXd::Constant(size, kNaN);
  squared_widths_ = Eigen::VectorXd::Zero(size);
  for (const ClothRows& cloth : cloths) {
    judged_.push_back(JudgeRows(cloth.blocks, cloth.coordinates, cloth.rows, cloth.num_measurements));
    squared_widths_ += StdWithBelief(cloth).cwiseAbs2() / static_cast<double>(cloths.size());
  }
  for (const int block : nominal_.rough) squared_widths_[block] = std::pow(StdBefore(nominal_.blocks[block]), 2);
}

bool Expectation::IsTold(const Uncertainty& cloth, int block) const {
  return !nominal_.blocks[block].frozen && cloth.parameters[block].identifiable;
}

double Expectation::told_share(int block) const {
  const auto count =
      std::count_if(judged_.begin(), judged_.end(), [&](const Uncertainty& cloth) { return IsTold(cloth, block); });
  return static_cast<double>(count) / static_cast<double>(judged_.size());
}

double Expectation::Std(int block) const {
  double sum = 0.0;
  int count = 0;
  for (const Uncertainty& cloth : judged_) {
    if (!IsTold(cloth, block)) continue;
    sum += std::pow(cloth.parameters[block].coordinate_std, 2);
    ++count;
  }
  return count > 0 ? UnitOf(nominal_.blocks[block]) * std::sqrt(sum / count) : kNaN;
}

Eigen::VectorXd Expectation::Widths(double step_share) const {
  const Eigen::ArrayXd known = step_errors_.array().isNaN().select(0.0, step_errors_.array());
  return (squared_widths_.array() + (step_share * known).square()).sqrt();
}

ExpectedParameter Expectation::Parameter(int block) const {
  const ParameterBlock& own = nominal_.blocks[block];
  ExpectedParameter expected;
  expected.name = own.name;
  expected.scale = own.scale;
  expected.is_in_scene = true;
  expected.value = own.start;
  expected.told_share = told_share(block);
  expected.is_told = is_told(block);
  expected.std = Std(block);
  expected.step_error = UnitOf(own) * step_errors_[block];
  if (!own.frozen) expected.share_of_belief = std::min(1.0, Widths(1.0)[block] / StdBefore(own));
  if (expected.is_told) {
    const double step = std::isnan(expected.step_error) ? 0.0 : expected.step_error;
    ParameterUncertainty interval;
    SetInterval(own, own.ToCoordinate(own.start), kNormal95 * std::hypot(expected.std, step) / UnitOf(own), &interval);
    expected.lower95 = interval.lower95;
    expected.upper95 = interval.upper95;
    return expected;
  }
  expected.not_told = WhyNotTold(block);
  if (!is_rough(block)) expected.made_up_by = MadeUpBy(block);
  return expected;
}

bool Expectation::IsLostToStep(int block) const {
  const ParameterBlock& own = nominal_.blocks[block];
  return step_errors_[block] > kHardlyTold * BelievedStd(own);
}

std::string Expectation::WhyNotTold(int block) const {
  const ParameterUncertainty& nominal = judged_.front().parameters[block];
  if (nominal_.blocks[block].frozen) return "the scene freezes it";
  if (is_rough(block)) return "its cost is rough: 1 % away it has risen by less than a tenth of what its slope says";
  if (told_share(block) > 0.5 && IsLostToStep(block)) return "the error of the time step leaves nothing of it";
  if (nominal.at_bound) return "it stands at its bound";
  if (!nominal.visible) return "between its bounds it moves unseen";
  if (nominal.identifiable) return "told of the nominal cloth, but not of most others";
  if (nominal.reaches_lower || nominal.reaches_upper) return "its interval reaches a bound";
  return "its interval is hardly narrower than what is believed";
}

std::string Expectation::MadeUpBy(int block) const {
  const Uncertainty& nominal = judged_.front();
  for (const HiddenDirection& hidden : nominal.hidden_directions) {
    const bool has_others = (hidden.coordinates.array().abs() >= kTakesPart).count() > 1;
    if (std::abs(hidden.coordinates[block]) >= kTakesPart && has_others) return hidden.words;
  }
  Eigen::VectorXd direction = Eigen::VectorXd::Zero(nominal_.coordinates.size());
  for (Eigen::Index j = 0; j < direction.size(); ++j) {
    const double together =
        nominal.correlation(block, j) * nominal.parameters[static_cast<std::size_t>(j)].coordinate_std;
    if (!std::isnan(together)) direction[j] = together;
  }
  Eigen::Index largest = 0;
  if (!(direction.cwiseAbs().maxCoeff(&largest) > 0.0)) return "";
  direction /= direction[largest];
  const bool has_others = (direction.array().abs() >= kTakesPart).count() > 1;
  return has_others ? DescribeDirection(nominal_.blocks, direction) : "";
}

}  // namespace clothid

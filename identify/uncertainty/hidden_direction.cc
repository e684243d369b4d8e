#include "identify/uncertainty/hidden_direction.h"

#include <algorithm>
#include <cmath>
#include <iomanip>
#include <sstream>

#include "identify/base/join_words.h"
#include "identify/base/knot_names.h"

namespace clothid {
namespace {

// Entries of a direction below this share of its largest are left out of its words.
constexpr double kNegligibleShare = 0.01;
// Logarithmic entries that differ by less than this share are one common factor.
constexpr double kCommonFactor = 0.02;
// Of more knots of the wind the names alone are told.
constexpr std::size_t kMostKnots = 3;

bool IsCommonFactor(const std::vector<ParameterBlock>& blocks, const Eigen::VectorXd& direction,
                    const std::vector<int>& parts) {
  return parts.size() > 1 && std::all_of(parts.begin(), parts.end(), [&](int i) {
           return blocks[i].scale == ParameterScale::kLog && std::abs(direction[i] - 1.0) < kCommonFactor;
         });
}

}  // namespace

std::string DescribeDirection(const std::vector<ParameterBlock>& blocks, const Eigen::VectorXd& direction) {
  std::vector<int> parts;
  std::vector<std::string> names, moves, moves_but_knots, knots;
  for (int i = 0; i < direction.size(); ++i) {
    if (std::abs(direction[i]) < kNegligibleShare) continue;
    parts.push_back(i);
    names.push_back(blocks[i].name);
    const bool is_knot = IsWindKnot(blocks[i].id);
    if (is_knot) knots.push_back(blocks[i].name);
    std::ostringstream move;
    move << std::setprecision(3) << blocks[i].name;
    if (blocks[i].scale == ParameterScale::kLog) {
      move << " times " << std::exp2(direction[i]);
    } else {
      move << (direction[i] < 0.0 ? " minus " : " plus ") << blocks[i].unit * std::abs(direction[i]) * std::log(2.0);
    }
    moves.push_back(move.str());
    if (!is_knot) moves_but_knots.push_back(move.str());
  }
  if (parts.size() == 1) return names.front();
  if (knots.size() > kMostKnots) {
    moves = moves_but_knots;
    for (const std::string& run : WithKnotRuns(knots)) moves.push_back(run);
  }
  if (IsCommonFactor(blocks, direction, parts)) return JoinWords(names) + " multiplied by one factor";
  return JoinWords(moves);
}

}  // namespace clothid

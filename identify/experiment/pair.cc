#include "identify/experiment/pair.h"

#include <array>
#include <cmath>

#include "identify/problem/problem_blocks.h"

namespace clothid {
namespace {

// For every block of the recording's own fit, where it stands in the joint one.
std::vector<int> Places(const std::vector<ParameterBlock>& own, const std::vector<ParameterBlock>& joint,
                        int recording) {
  std::vector<int> places;
  for (const ParameterBlock& block : own) {
    for (int j = 0; j < static_cast<int>(joint.size()); ++j) {
      const bool concerns = joint[j].recording == kEveryRecording || joint[j].recording == recording;
      if (concerns && BaseName(joint[j].name) == block.name) places.push_back(j);
    }
  }
  return places;
}

// Either recording of a cloth, and its places.
struct Member {
  const ClothInformation* cloth;
  std::vector<int> places;
};

ClothRows Join(const std::vector<ParameterBlock>& blocks, const std::array<Member, 2>& members) {
  ClothRows joint;
  joint.blocks = blocks;
  joint.coordinates = Eigen::VectorXd::Zero(static_cast<Eigen::Index>(blocks.size()));
  joint.rows = Eigen::MatrixXd::Zero(members[0].cloth->planned.rows() + members[1].cloth->planned.rows(),
                                     joint.coordinates.size());
  // The first one speaks for what they have in common.
  for (int m = 1; m >= 0; --m) joint.coordinates(members[m].places) = members[m].cloth->coordinates;
  joint.rows.topRows(members[0].cloth->planned.rows())(Eigen::all, members[0].places) = members[0].cloth->planned;
  joint.rows.bottomRows(members[1].cloth->planned.rows())(Eigen::all, members[1].places) = members[1].cloth->planned;
  for (const Member& member : members) {
    joint.num_measurements += member.cloth->num_measurements;
    for (const int block : member.cloth->rough) joint.rough.push_back(member.places[static_cast<std::size_t>(block)]);
  }
  return joint;
}

// See `JointCloths::step_errors`.
Eigen::VectorXd JoinStepErrors(Eigen::Index size, const std::array<Member, 2>& members) {
  Eigen::VectorXd squares = Eigen::VectorXd::Zero(size), precisions = Eigen::VectorXd::Zero(size);
  for (const Member& member : members) {
    const Eigen::ArrayXd precision = StdWithBelief(RowsOf(*member.cloth, member.cloth->planned)).array().pow(-2);
    const Eigen::ArrayXd& errors = member.cloth->step_errors.array();
    const Eigen::ArrayXd own = errors.isNaN().select(0.0, (precision * errors).square());
    squares(member.places) += own.matrix();
    precisions(member.places) += precision.matrix();
  }
  return (squares.array().sqrt() / precisions.array()).matrix();
}

}  // namespace

JointCloths JoinCloths(const PlanOptions& options, const Candidate& first, const Candidate& second,
                       const std::vector<ClothInformation>& of_first, const std::vector<ClothInformation>& of_second) {
  JointCloths joint;
  const std::vector<ParameterBlock> blocks =
      MakeBlocks({of_first.front().recording, of_second.front().recording}, JointOptions(options, {&first, &second}));
  for (std::size_t i = 0; i < of_first.size(); ++i) {
    if (!of_first[i].failure.empty() || !of_second[i].failure.empty()) continue;
    const std::array<Member, 2> members = {Member{&of_first[i], Places(of_first[i].blocks, blocks, 0)},
                                           Member{&of_second[i], Places(of_second[i].blocks, blocks, 1)}};
    joint.cloths.push_back(Join(blocks, members));
    if (i == 0) joint.step_errors = JoinStepErrors(joint.cloths.front().coordinates.size(), members);
  }
  return joint;
}

}  // namespace clothid

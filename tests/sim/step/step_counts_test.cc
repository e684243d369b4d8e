// Contact events between one solve and the next, and sums of counts.
#include "sim/step/step_counts.h"

#include <gtest/gtest.h>

namespace clothid::step_counts_test {
namespace {

ContactRecord RecordOf(int node, ContactBranch branch, int obstacle = 0) {
  ContactRecord record;
  record.node = node;
  record.branch = branch;
  record.obstacle = obstacle;
  return record;
}

TEST(ContactChangesTest, TellJoinedLeftAndSwitchedApart) {
  const ContactBranch stick = ContactBranch::kStick, slip = ContactBranch::kSlip;
  RolloutCounts counts;
  CountContactChanges(
      {{RecordOf(1, stick), RecordOf(3, slip), RecordOf(4, slip), RecordOf(6, stick)}},
      {{RecordOf(0, slip), RecordOf(3, stick), RecordOf(4, stick, 1), RecordOf(6, stick), RecordOf(7, slip)}}, &counts);
  EXPECT_EQ(counts.contacts, 5);
  EXPECT_EQ(counts.nodes_joined, 2);
  EXPECT_EQ(counts.nodes_left, 1);
  EXPECT_EQ(counts.branch_switches, 2);
  EXPECT_EQ(counts.obstacle_switches, 1);
  EXPECT_EQ(counts.contact_changes(), 5);
}

PairContactRecord PairOf(int vertex, int face, ContactBranch branch) {
  PairContactRecord record;
  record.features = {PairKind::kVertexFace, {vertex, face, face + 1, face + 2}};
  record.branch = branch;
  return record;
}

// A vertex that slides from one face to the next counts twice.
TEST(PairChangesTest, CountWhatComesGoesAndSwitches) {
  const ContactBranch stick = ContactBranch::kStick, slip = ContactBranch::kSlip;
  RolloutCounts counts;
  CountContactChanges({{}, {PairOf(1, 10, slip), PairOf(2, 10, stick), PairOf(4, 20, slip)}},
                      {{}, {PairOf(1, 11, slip), PairOf(2, 10, slip), PairOf(4, 20, slip)}}, &counts);
  EXPECT_EQ(counts.self_contacts, 3);
  EXPECT_EQ(counts.pair_changes, 3);
  EXPECT_EQ(counts.contact_changes(), 3);
}

TEST(RolloutCountsTest, AddUpAndTakeOff) {
  RolloutCounts sum;
  sum.steps = 3;
  sum.obstacle_switches = 2;
  RolloutCounts other;
  other.steps = 4;
  other.nodes_left = 5;
  sum += other;
  EXPECT_EQ(sum.steps, 7);
  EXPECT_EQ(sum.nodes_left, 5);
  EXPECT_EQ(sum.obstacle_switches, 2);
  sum -= other;
  EXPECT_EQ(sum.steps, 3);
  EXPECT_EQ(sum.nodes_left, 0);
}

}  // namespace
}  // namespace clothid::step_counts_test

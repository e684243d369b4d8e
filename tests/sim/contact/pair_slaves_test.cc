// Slaves: one to a pair, none twice, none that follows itself, masters first.
#include "sim/contact/pair_slaves.h"

#include <gtest/gtest.h>

#include <random>
#include <set>
#include <vector>

namespace clothid::pair_slaves_test {
namespace {

PairContact Contact(PairKind kind, std::array<int, 4> blocks, const Eigen::Vector4d& weights) {
  PairContact contact;
  contact.candidate.features.kind = kind;
  contact.candidate.blocks = blocks;
  contact.candidate.geometry.weights = weights;
  contact.response.branch = ContactBranch::kStick;
  return contact;
}

// Of a vertex and a face.
PairContact VertexFace(const std::array<int, 4>& blocks) {
  return Contact(PairKind::kVertexFace, blocks, {1.0, -0.5, -0.3, -0.2});
}

void ExpectInOrder(const std::vector<PairContact>& contacts, const PairSlaves& slaves) {
  std::vector<int> pair_of(100, -1);
  for (std::size_t c = 0; c < contacts.size(); ++c) {
    if (slaves.places[c] < 0) continue;
    int& pair = pair_of[contacts[c].candidate.blocks[slaves.places[c]]];
    EXPECT_EQ(pair, -1);
    pair = static_cast<int>(c);
  }
  std::set<int> before;
  for (const int c : slaves.order) {
    for (int place = 0; place < 4; ++place) {
      const int block = contacts[c].candidate.blocks[place];
      if (place == slaves.places[c] || block < 0 || pair_of[block] < 0) continue;
      EXPECT_EQ(before.count(pair_of[block]), 1u) << "pair " << c << " follows pair " << pair_of[block];
    }
    before.insert(c);
  }
}

TEST(PairSlavesTest, VerticesFollowFacesAndHeldNodesNothing) {
  const std::vector<PairContact> contacts = {VertexFace({0, 1, 2, 3}), VertexFace({4, 0, 1, 2})};
  const PairSlaves free = ChooseSlaves(contacts, {}, 5);
  EXPECT_EQ(free.places, (std::vector<int>{0, 0}));
  EXPECT_EQ(free.order, (std::vector<int>{0, 1}));
  // 4 is held and 0 follows already. 1 and 2 would follow 0, which follows them.
  EXPECT_EQ(ChooseSlaves(contacts, {4}, 5).places, (std::vector<int>{0, -1}));
  // 0 is held as well. 1 follows it, with 2 and 3, so that 2 cannot follow 1.
  EXPECT_EQ(ChooseSlaves(contacts, {0, 4}, 5).places, (std::vector<int>{1, -1}));
}

TEST(PairSlavesTest, LeavesPairsThatLeaveAndHandlesWithoutSlaves) {
  std::vector<PairContact> contacts = {VertexFace({0, 1, 2, 3}), VertexFace({-1, 1, 2, 3})};
  contacts[0].response.branch = ContactBranch::kTakeOff;
  const PairSlaves slaves = ChooseSlaves(contacts, {}, 4);
  EXPECT_EQ(slaves.places, (std::vector<int>{-1, 1}));
  EXPECT_EQ(slaves.order, std::vector<int>{1});
}

TEST(PairSlavesTest, FollowNoCircleWhateverThePairs) {
  std::mt19937 random(1);
  int num_slaves = 0;
  for (int trial = 0; trial < 200; ++trial) {
    std::vector<PairContact> contacts;
    for (int c = 0; c < 20; ++c) {
      std::set<int> blocks;
      while (blocks.size() < 4) blocks.insert(static_cast<int>(random() % 30));
      std::vector<int> nodes(blocks.begin(), blocks.end());
      std::shuffle(nodes.begin(), nodes.end(), random);
      const std::array<int, 4> four = {nodes[0], nodes[1], nodes[2], nodes[3]};
      contacts.push_back(c % 3 == 0 ? Contact(PairKind::kEdgeEdge, four, {0.6, 0.4, -0.97, -0.03}) : VertexFace(four));
    }
    const PairSlaves slaves = ChooseSlaves(contacts, {0, 1}, 30);
    ExpectInOrder(contacts, slaves);
    for (int c = 0; c < 20; ++c) {
      if (slaves.places[c] < 0) continue;
      ++num_slaves;
      EXPECT_GT(contacts[c].candidate.blocks[slaves.places[c]], 1);
      EXPECT_GE(std::abs(contacts[c].candidate.geometry.weights[slaves.places[c]]), 0.05);
    }
  }
  EXPECT_GT(num_slaves, 200 * 10);
}

}  // namespace
}  // namespace clothid::pair_slaves_test

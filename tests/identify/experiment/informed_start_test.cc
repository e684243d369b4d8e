// Which directions of a start a recording tells of, and what the others matter.
#include "identify/experiment/informed_start.h"

#include <gtest/gtest.h>

#include <cmath>

#include "identify/experiment/candidate.h"
#include "identify/experiment/cloth_information.h"
#include "tests/temporary_folder.h"

namespace clothid::informed_start_test {
namespace {

Eigen::MatrixXd Diagonal(const Eigen::Vector4d& entries) { return entries.asDiagonal(); }

TEST(InformedStartTest, AreThoseThatTellMoreThanWasBelieved) {
  const Eigen::MatrixXd measured = Diagonal({3.0, 0.5, 4.0, 0.0}), believed = Diagonal({1.0, 1.0, 2.0, 1.0});
  const Eigen::MatrixXd directions = InformedDirections(measured, believed);
  ASSERT_EQ(directions.cols(), 2);
  const Eigen::MatrixXd unit = (measured * directions).transpose() * (measured * directions) +
                               (believed * directions).transpose() * (believed * directions);
  EXPECT_LT((unit - Eigen::MatrixXd::Identity(2, 2)).norm(), 1e-12);
  EXPECT_NEAR(directions.row(0).norm(), 1.0 / std::sqrt(10.0), 1e-12);
  EXPECT_NEAR(directions.row(2).norm(), 1.0 / std::sqrt(20.0), 1e-12);
  EXPECT_LT(directions.row(1).norm() + directions.row(3).norm(), 1e-12);
}

TEST(InformedStartTest, DoNotDependOnTheUnknowns) {
  const Eigen::MatrixXd measured = Diagonal({3.0, 0.5, 4.0, 0.0}), believed = Diagonal({1.0, 1.0, 2.0, 1.0});
  Eigen::Matrix4d change = Eigen::Matrix4d::Identity();
  change(0, 1) = 2.0;
  change(3, 2) = -1.0;
  change(2, 2) = 1e-3;
  const Eigen::MatrixXd one = InformedDirections(measured, believed);
  const Eigen::MatrixXd other = change * InformedDirections(measured * change, believed * change);
  EXPECT_LT((one * one.transpose() - other * other.transpose()).norm(), 1e-10);
}

TEST(InformedStartTest, AreAllWhereNeitherTellsOne) {
  const Eigen::MatrixXd measured = Diagonal({3.0, 1.0, 4.0, 0.0}), believed = Diagonal({1.0, 1.0, 2.0, 0.0});
  EXPECT_EQ(InformedDirections(measured, believed), Eigen::MatrixXd::Identity(4, 4));
}

// A cloth that falls on a ball, held by a side; another one than the nominal.
TEST(InformedStartTest, SufficeForOtherCloths) {
  const TemporaryFolder folder;
  PlanOptions options;
  options.scene_paths = {folder.Write("drape.json", R"({
    "clothid_scene": 2, "time_step": 0.01, "duration": 0.4, "contact": "gap",
    "mesh": {"grid": {"nodes": [7, 7], "size": [0.5, 0.5], "origin": [-0.25, 0, 0],
                      "axes": [[1, 0, 0], [0, 0.906307787036650, -0.422618261740699]]}},
    "initial": {"positions": "rest"}, "handles": [0, 1, 2, 3, 4, 5, 6],
    "obstacles": [{"name": "ball", "type": "sphere", "center": [0.03, 0.25, -0.35], "radius": 0.2, "mu": 0.57}],
    "materials": {"density": 0.15, "k_stretch": 300, "k_bend": 1.5e-3, "drag": 0.05}})")};
  options.fit.parameters = {"mu", "k_stretch", "k_bend"};
  options.sigma = 0.002;
  options.frame_rate = 50.0;
  options.start = StartSource::kRest;
  const Candidate candidate = ReadCandidates(options).front();
  const ClothInformation nominal = InformCloth(options, candidate, 0, {});
  ASSERT_EQ(nominal.failure, "");
  const Eigen::Index num_start = nominal.start_directions.rows();
  EXPECT_LT(nominal.start_directions.cols(), num_start);
  ClothInformation all;
  all.start_directions = Eigen::MatrixXd::Identity(num_start, num_start);
  const ClothInformation one = InformCloth(options, candidate, 1, nominal);
  const ClothInformation other = InformCloth(options, candidate, 1, all);
  const auto stds = [](const ClothInformation& cloth) {
    return (cloth.planned.transpose() * cloth.planned).inverse().diagonal().cwiseSqrt().eval();
  };
  for (int i = 0; i < 3; ++i) EXPECT_NEAR(stds(one)[i] / stds(other)[i], 0.98, 0.02 + 1e-6) << i;
}

}  // namespace
}  // namespace clothid::informed_start_test

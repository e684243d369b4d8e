// What is believed of fields, and how they are asked for.
#include "costs/field/field_prior.h"

#include <gtest/gtest.h>

#include <cmath>
#include <string>
#include <vector>

#include "costs/field/field_request.h"
#include "tests/expect_error.h"

namespace clothid::field_prior_test {
namespace {

// The integral of the squared Laplacian, whatever the grid; nothing of the mean.
TEST(FieldPriorTest, IsTheSameOnEveryGrid) {
  for (const int side : {17, 33}) {
    const Eigen::SparseMatrix<double> root = SmoothnessRoot(side, side);
    Eigen::VectorXd wave(side * side);
    for (int r = 0; r < side; ++r) {
      for (int c = 0; c < side; ++c) wave[r * side + c] = std::cos(3.14159265358979 * c / (side - 1.0));
    }
    EXPECT_NEAR((root * wave).squaredNorm(), 0.5 * std::pow(3.14159265358979, 4), 0.1 * 49.0) << side;
    EXPECT_LE((root * Eigen::VectorXd::Ones(side * side)).norm(), 1e-9);
  }
}

// Eigenvectors of the prior, and what they leave out of its covariance.
TEST(FieldPriorTest, ModesAreThoseOfThePrior) {
  constexpr int kRows = 5, kColumns = 7;
  const Eigen::MatrixXd prior = SmoothnessRoot(kRows, kColumns).transpose() * SmoothnessRoot(kRows, kColumns);
  const Eigen::MatrixXd all = FieldModes(kRows, kColumns, 7);
  ASSERT_EQ(all.cols(), kRows * kColumns);
  EXPECT_LE((all.transpose() * all - Eigen::MatrixXd::Identity(35, 35)).norm(), 1e-12);
  const Eigen::VectorXd roughness = (all.transpose() * prior * all).diagonal();
  EXPECT_LE((prior * all - all * roughness.asDiagonal()).norm(), 1e-10 * prior.norm());
  EXPECT_LE((RoughVariances(kRows, kColumns, 7)).norm(), 0.0);
  const Eigen::MatrixXd few = FieldModes(kRows, kColumns, 3);
  ASSERT_EQ(few.cols(), 9);
  const Eigen::MatrixXd rest = all - few * (few.transpose() * all);
  const Eigen::VectorXd variances =
      rest.array().square().matrix() * roughness.cwiseMax(1e-9).cwiseInverse();  // the mean is not in `rest`
  EXPECT_LE((RoughVariances(kRows, kColumns, 3) - variances).norm(), 1e-9 * variances.norm());
}

TEST(FieldRequestTest, NamesWhatItCannotRead) {
  const std::vector<FieldRequest> requests = ParseFieldRequests("k_stretch:8x4, density:2x2");
  ASSERT_EQ(requests.size(), 2u);
  EXPECT_EQ(requests[0].rows, 8);
  EXPECT_EQ(requests[0].columns, 4);
  EXPECT_EQ(requests[1].kind, ParameterKind::kDensity);
  EXPECT_TRUE(ParseFieldRequests("").empty());
  const auto expect = [](const std::string& text, const char* message) {
    ExpectError([&] { ParseFieldRequests(text); }, ErrorKind::kUsage, {"--field: ", message});
  };
  for (const char* text : {"k_stretch", "k_stretch:8", "k_stretch:8x", "k_stretch:0x4", "k_stretch:4x300", ":4x4,",
                           "k_stretch:4.5x4", "k_stretch 4x4", "x", ""}) {
    if (*text != '\0') expect(text, "");
  }
  expect("mu:4x4", "'mu' can be no field");
  expect("k_stretch:4x4,k_stretch:2x2", "'k_stretch' is given twice");
  expect("k_stretch:80x80", "6400 unknowns; expected at most 4096");
}

}  // namespace
}  // namespace clothid::field_prior_test

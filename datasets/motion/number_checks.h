// The checks that recordings share with the files they come from, in the words of either. Internal to datasets/motion.
#ifndef CLOTHID_DATASETS_MOTION_NUMBER_CHECKS_H_
#define CLOTHID_DATASETS_MOTION_NUMBER_CHECKS_H_

#include <Eigen/Core>
#include <string>
#include <vector>

namespace clothid {

// Every check throws `Error` (kBadData) in one line: "SOURCE: tensor 'FIELD': entry 3 .." of a file, "SOURCE: FIELD[3]
// .." of a recording in memory.
class NumberChecks {
 public:
  enum class Kind { kFile, kRecording };
  // `source` must outlive the checks.
  NumberChecks(Kind kind, const std::string& source) : kind_(kind), source_(source) {}

  [[noreturn]] void Fail(const std::string& field, const std::string& message) const;
  [[noreturn]] void FailEntry(const std::string& field, Eigen::Index index, const std::string& message) const;

  void ExpectSize(const std::string& field, Eigen::Index found, Eigen::Index expected) const;
  // Finite, each above the one before it.
  void ExpectIncreasing(const std::string& field, const Eigen::VectorXd& times) const;
  // Finite and > 0.
  void ExpectPositive(const std::string& field, const Eigen::VectorXd& numbers) const;
  // 0 to count - 1.
  void ExpectIndex(const std::string& field, Eigen::Index at, int index, int count) const;
  // Within 1e-6 of 1.
  bool SumsToOne(double sum) const;
  // By frame [.. x T]: NaN, or of a size of at most `largest`.
  void ExpectPositions(const std::string& field, const Eigen::MatrixXd& positions, double largest) const;
  // One per time, of a size of at most `largest`, with a point at least in all of them.
  void ExpectClouds(const std::string& field, const std::string& count_field,
                    const std::vector<Eigen::Matrix3Xd>& clouds, Eigen::Index num_times, double largest) const;

 private:
  Kind kind_;
  const std::string& source_;
};

}  // namespace clothid

#endif  // CLOTHID_DATASETS_MOTION_NUMBER_CHECKS_H_

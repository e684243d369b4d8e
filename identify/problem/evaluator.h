// Evaluates every recording of a fit at one point, side by side, and keeps the best point.
#ifndef CLOTHID_IDENTIFY_PROBLEM_EVALUATOR_H_
#define CLOTHID_IDENTIFY_PROBLEM_EVALUATOR_H_

#include <Eigen/Core>
#include <functional>
#include <limits>
#include <string>
#include <vector>

#include "costs/rollout_cost.h"
#include "identify/base/evaluation_progress.h"
#include "identify/problem/problem.h"
#include "identify/uncertainty/uncertainty.h"

namespace clothid {

// A point with a cost. Evaluators of another purpose than a fit keep no predictions of it, nor their counts.
struct FitPoint {
  Eigen::VectorXd coordinates;  // [p + n + f]; empty: no point was evaluated yet
  double cost = std::numeric_limits<double>::infinity();
  Precision precision = Precision::kFull;  // with which it was evaluated
  std::vector<Eigen::MatrixXd> predicted;  // per recording [R x T] m, see Observation
  std::vector<Eigen::MatrixXd> forces;     // per recording [3G x F] N; empty where none were measured
  RolloutCounts counts;                    // of its rollouts, summed over the recordings

  bool is_valid() const { return coordinates.size() > 0; }
};

// The Gauss-Newton model of the cost at a point, for changes of the blocks:  L(q + d) ~ cost + gradient . d + 1/2 d .
// hessian d.
struct QuadraticModel {
  Eigen::VectorXd coordinates;  // [p + n + f]
  double cost = 0.0;
  Eigen::VectorXd gradient;  // [p] J^T r; zero for frozen blocks; of the other unknowns nothing is told
  Eigen::MatrixXd hessian;   // [p x p] J^T J; a zero row: no recording depends on the block, or it is frozen
};

// The rows that the model is made of: those of what is believed, then those of the recordings, one after the other
// (costs/rollout_cost.h).
struct EvaluatedRows {
  Eigen::VectorXd residuals;  // [r]
  Eigen::MatrixXd jacobian;   // [r x p], zero for frozen blocks
};

// Ceres' own threads would stop evaluating the other recordings once one has failed, and which ones depends on timing;
// here all are always evaluated, so that caches, counts and results are the same on any number of threads.
class FitEvaluator {
 public:
  // `problem` must outlive the evaluator. `purpose`: what is told of the evaluations.
  FitEvaluator(const FitProblem* problem, int num_threads, EvaluationPurpose purpose = EvaluationPurpose::kFit);

  // kExactRows: rows by sensitivities, along with the rollout of a new point. `Linearize` has them, too, then.
  enum class Derivative { kNone, kRows, kExactRows, kGradient };
  // The sum over the recordings, in their order, and the priors. kGradient also fills `gradient` [p + n + f], which may
  // else be null. False where a rollout failed: see last_failure(), which then tells the place, too.
  bool Evaluate(const Eigen::VectorXd& coordinates, Derivative derivative, double* cost, Eigen::VectorXd* gradient,
                Precision precision = Precision::kFull);

  // The Jacobian of all recordings by sensitivities, along the p parameters and along `combinations` [(n + f) x c] of
  // the other unknowns, with the priors of starts, without all others. False as above.
  bool Linearize(const Eigen::VectorXd& coordinates, const Eigen::MatrixXd& combinations, Linearization* linearization,
                 Precision precision = Precision::kFull);

  // J^T J `direction` [p + n + f] of the same, without frozen parameters. False as above.
  bool TimesCurvature(const Eigen::VectorXd& coordinates, const Eigen::VectorXd& direction, Eigen::VectorXd* product,
                      Precision precision = Precision::kFull);

  // J^T D [p + n + f] of what changes from the predictions here to `changed`, with `forces`, one of each recording
  // (`RolloutCost::PullBackChange`). False as above.
  bool PullBackChange(const Eigen::VectorXd& coordinates, const std::vector<Eigen::MatrixXd>& changed,
                      const std::vector<Eigen::MatrixXd>& forces, Eigen::VectorXd* product);

  // Of the last kRows or kExactRows evaluation that worked.
  const QuadraticModel& model() const { return model_; }
  const EvaluatedRows& rows() const { return rows_; }
  // Makes `coordinates` the first point, evaluated as costs now are, with full precision, and the best where its cost
  // is the lowest; false where that fails.
  bool SetFirst(const Eigen::VectorXd& coordinates);
  const FitPoint& first() const { return first_; }  // the first point that worked
  // The point of lowest cost, of those of full precision where there are some: costs of different precision do not
  // compare.
  const FitPoint& best() const { return best_; }
  // The next point is the best one whatever its cost: costs with priors of other weights do not compare, either.
  void SupersedeBest();
  // The same where the best point is a loose one.
  void SupersedeLoose();
  bool best_is_superseded() const { return best_is_superseded_; }
  // Whether the best point is one of all that compare with the first.
  bool first_compares() const { return first_compares_; }
  int num_failures() const { return num_failures_; }                 // evaluations that did not work
  const std::string& last_failure() const { return last_failure_; }  // the reason of the last of them
  CostStatistics statistics() const;                                 // since the evaluator was made
  // |dL/dq| at the best point; NaN where no gradient was asked for there.
  double best_gradient_norm() const { return best_gradient_norm_; }
  double seconds() const { return seconds_; }  // wall time of all evaluations

 private:
  struct RecordingResult {
    bool ok = false;
    double cost = 0.0;
    Eigen::VectorXd gradient;  // kGradient: of all coordinates of the recording
    EvaluatedRows rows;        // of the recording's blocks
  };
  RecordingResult EvaluateRecording(int recording, const Eigen::VectorXd& coordinates, Derivative derivative,
                                    Precision precision) const;
  RecordingResult EvaluateRows(int recording, const Eigen::VectorXd& coordinates, Precision precision) const;
  // All of them, with what is believed; fills rows_ and model_ where there are rows.
  double Sum(const std::vector<RecordingResult>& results, const Eigen::VectorXd& coordinates, Derivative derivative,
             Eigen::VectorXd* gradient);
  // ", at mu 0.3, k_stretch 2e+05 N/m (6.54 to 4070 N/m were measured of cloth)": the parameters, or of more than a
  // handful those alone that no cloth can have.
  std::string PlaceText(const Eigen::VectorXd& coordinates) const;
  void Keep(const Eigen::VectorXd& coordinates, double cost, Precision precision);
  // Of one that was just evaluated.
  FitPoint PointOf(const Eigen::VectorXd& coordinates, double cost, Precision precision) const;

  // What one recording tells of some columns.
  struct RecordingLinearization {
    std::vector<int> columns;  // their places among all
    Eigen::MatrixXd jacobian, frame_scores;
    Eigen::VectorXd residuals;
  };
  bool LinearizeRecording(int recording, const Eigen::VectorXd& coordinates, const Eigen::MatrixXd& combinations,
                          Precision precision, RecordingLinearization* part) const;
  Linearization Collect(const std::vector<RecordingLinearization>& parts, Eigen::Index num_columns) const;

  // What the recordings give of all coordinates [p + n + f], summed.
  Eigen::VectorXd SumOf(const std::vector<Eigen::VectorXd>& parts) const;
  // work(recording) for all, timed; then the reason why one of them returned false, if so.
  bool ForEachRecording(const std::function<bool(int recording)>& work);

  const FitProblem* problem_;
  int num_threads_;
  EvaluationPurpose purpose_;
  QuadraticModel model_;
  EvaluatedRows rows_;
  FitPoint first_, best_;
  bool best_is_superseded_ = false, first_compares_ = false;
  CostStatistics statistics_before_;
  std::string last_failure_;
  int num_failures_ = 0;
  double best_gradient_norm_ = std::numeric_limits<double>::quiet_NaN();
  double seconds_ = 0.0;
};

}  // namespace clothid

#endif  // CLOTHID_IDENTIFY_PROBLEM_EVALUATOR_H_

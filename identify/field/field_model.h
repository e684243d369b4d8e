// Recordings as functions of fields and parameters: cost, gradient, and products with the Jacobian, none of which takes
// more than a rollout or a sweep for each recording, however many unknowns a field has. Recordings go side by side, on
// `FitOptions::num_threads`; results do not depend on it.
//
// The unknowns are u = (q, theta): q [p] the internal coordinates of the parameters that are fitted with the fields,
// theta [n] the logarithms of the fields at their control nodes, over their starting values, row by row, one field
// after the other. With the whitened residuals e of all recordings, weighted by the loss, and their Jacobian J:
//   cost(u) = L(u) + lambda/2 |B theta|^2,   gradient = J^T e + lambda P theta,   H = J^T J + lambda P,   P = B^T B
// with B of field_prior.h.
#ifndef CLOTHID_IDENTIFY_FIELD_FIELD_MODEL_H_
#define CLOTHID_IDENTIFY_FIELD_FIELD_MODEL_H_

#include <Eigen/Core>
#include <Eigen/SparseCore>
#include <functional>
#include <memory>
#include <string>
#include <vector>

#include "costs/prediction/prediction_cost.h"
#include "costs/prediction/recording_model.h"
#include "datasets/motion/recorded_motion.h"
#include "identify/base/options.h"
#include "identify/field/field_request.h"

namespace clothid {

// One recording at a point: what its sweeps need.
struct FieldRecordingPoint {
  Eigen::VectorXd coordinates;  // of its blocks
  Rollout rollout;
  Eigen::MatrixXd predicted, velocities;
  ForceTrack forces;
  PredictionCost cost;
  Eigen::MatrixXd scalar_rows;  // [m x p] weighted columns of J; empty until they are asked for
};

struct FieldPoint {
  Eigen::VectorXd unknowns;  // u
  Precision precision = Precision::kFull;
  std::vector<FieldRecordingPoint> recordings;
  double data_cost = 0.0;  // L
};

struct FieldCounts {
  int rollouts = 0;
  int sweeps = 0;  // forward or reverse, along a rollout that is at hand
};

class FieldModel {
 public:
  // `motions`: whose scenes have the fields of `requests` (`SetField`), the same everywhere: their starting values.
  // `blocks`: of all fitted parameters; those that are levels of fields are left out, as are frozen ones. Throws
  // `Error` (kUsage) where a recording has an unknown start, or a level belongs to one recording alone, and where
  // `RecordingModel` does.
  FieldModel(const std::vector<RecordedMotion>& motions, const std::vector<ParameterBlock>& blocks,
             const std::vector<FieldRequest>& requests, const FitOptions& options);

  int num_scalars() const { return static_cast<int>(scalars_.size()); }      // p
  int num_field_unknowns() const { return static_cast<int>(root_.cols()); }  // n
  int size() const { return num_scalars() + num_field_unknowns(); }          // p + n
  const std::vector<int>& scalars() const { return scalars_; }               // their indices in `blocks`
  const std::vector<ParameterBlock>& blocks() const { return blocks_; }      // all
  const std::vector<FieldRequest>& requests() const { return requests_; }
  const Eigen::SparseMatrix<double>& prior_root() const { return root_; }     // B [n x n]
  const Eigen::SparseMatrix<double>& prior_matrix() const { return prior_; }  // P [n x n]
  int num_recordings() const { return static_cast<int>(models_.size()); }
  const Observation& observation(int recording) const { return models_[recording]->observation(); }
  int num_measurements() const;
  bool sigma_is_known() const;

  Eigen::VectorXd Start() const;
  // The values of a field at the control nodes, [rows x columns].
  Eigen::MatrixXd ValuesOf(int field, const Eigen::VectorXd& unknowns) const;
  // The weights [p' x (p + n)] of u that make the coordinates of all blocks that are not frozen: the scalars
  // themselves, and the levels of fields, means of theta over the area of the first recording.
  Eigen::MatrixXd BlockWeights(std::vector<int>* free_blocks) const;

  // The coordinates of all blocks at u: of levels, the logarithm of the field's.
  Eigen::VectorXd BlockCoordinates(const Eigen::VectorXd& unknowns) const;

  // Simulates. False where a rollout fails, `failure()` says why.
  bool MoveTo(const Eigen::VectorXd& unknowns, Precision precision, FieldPoint* point);
  const std::string& failure() const { return failure_; }

  // J^T e [p + n].
  Eigen::VectorXd DataGradient(const FieldPoint& point);
  // J v of every recording, and J^T of such rows. To about `kLooseAdjointTolerance`.
  std::vector<Eigen::VectorXd> Times(const Eigen::VectorXd& v, FieldPoint* point);
  Eigen::VectorXd TimesTransposed(const std::vector<Eigen::VectorXd>& rows, const FieldPoint& point);
  // J^T J v.
  Eigen::VectorXd TimesCurvature(const Eigen::VectorXd& v, FieldPoint* point) {
    return TimesTransposed(Times(v, point), *point);
  }
  // (J V)^T (J V) for columns V [(p + n) x c], by one forward sweep for each recording. `frame_scores` (may be null):
  // per recording [c x T], the parts of (J V)^T e that the frames have.
  Eigen::MatrixXd Gram(const Eigen::MatrixXd& columns, FieldPoint* point,
                       std::vector<Eigen::MatrixXd>* frame_scores = nullptr);

  const FieldCounts& counts() const { return counts_; }

 private:
  // Which blocks of a recording's model are scalars of u, and their places there.
  struct ActiveScalars {
    std::vector<int> blocks, places;
  };
  ActiveScalars ScalarsIn(int recording) const;
  // Side by side; `work` must touch nothing of another recording.
  void ForEachRecording(const std::function<void(int recording)>& work) const;
  void Simulate(int recording, const Eigen::VectorXd& unknowns, Precision precision, FieldRecordingPoint* at);
  Eigen::VectorXd CoordinatesOf(int recording, const Eigen::VectorXd& unknowns) const;
  Eigen::VectorXd Pull(int recording, const FieldRecordingPoint& at, const Eigen::VectorXd& seeds, Precision precision);
  // Changes of the values per triangle [K F x c], from those at the control nodes [n x c].
  Eigen::MatrixXd OverTriangles(int recording, const Eigen::MatrixXd& theta) const;
  // J_r^T of every recording's `seeds`, added up in their order.
  Eigen::VectorXd PullAll(const FieldPoint& point, Precision precision,
                          const std::function<Eigen::VectorXd(int recording)>& seeds);
  void SetScalarRows(FieldPoint* point);
  void SetScalarRows(int recording, FieldRecordingPoint* at);
  // The rows of J V that each frame, or reading of forces, has (`Observation::first_row`), for columns V [(p + n) x c].
  void PushColumns(int recording, const Eigen::MatrixXd& columns, const FieldRecordingPoint& at,
                   const std::function<void(int frame, Eigen::Index row, const Eigen::MatrixXd& part)>& visit);

  std::vector<ParameterBlock> blocks_;
  std::vector<FieldRequest> requests_;
  std::vector<double> start_levels_;  // of the fields
  std::vector<int> scalars_;
  AdjointOptions adjoint_;
  RobustLoss loss_;
  const std::atomic<bool>* cancel_;
  int num_threads_;
  std::vector<std::unique_ptr<RecordingModel>> models_;
  std::vector<std::vector<int>> model_blocks_;                     // of every recording: indices in blocks_
  std::vector<std::vector<Eigen::SparseMatrix<double>>> weights_;  // W, per recording and field
  Eigen::SparseMatrix<double> root_, prior_;
  std::string failure_;
  FieldCounts counts_;
};

}  // namespace clothid

#endif  // CLOTHID_IDENTIFY_FIELD_FIELD_MODEL_H_

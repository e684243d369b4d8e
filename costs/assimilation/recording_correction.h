// Corrections of a rollout by its recording (sim/rollout/correction.h), with the gains of
// costs/assimilation/assimilation.h.
//
// The innovations e of the seen coordinates of tracked points become a displacement u of the free nodes, which follows
// them and is smooth,
//   u = argmin |psi(e) - P u|^2 + l^4/m sum_i a_i (Lap u)_i^2 = (P^T P + l^4/m L^T M^-1 L)^-1 P^T psi(e),
// each axis for itself: P of all points that are ever seen, e = 0 where one is not; L the cotangent Laplacian, M the
// areas a_i of the nodes, m their mean; handles have u = 0. On a sheet of which every node is seen, waves of length w
// keep 1/(1 + (2 pi l/w)^4) of their amplitude; nodes that nobody sees move with those around them. Points of clouds
// and points that slide go into the same minimum (costs/assimilation/surface_pairs.h).
//
// psi(e) = rho'(|e/sigma|^2) e is what the loss lets a point count (costs/prediction/robust_loss.h): a gross error
// hardly moves the state. With several frames at the end of one step e is their mean.
#ifndef CLOTHID_COSTS_ASSIMILATION_RECORDING_CORRECTION_H_
#define CLOTHID_COSTS_ASSIMILATION_RECORDING_CORRECTION_H_

#include <Eigen/Core>
#include <Eigen/SparseCholesky>
#include <Eigen/SparseCore>
#include <memory>
#include <vector>

#include "costs/assimilation/assimilation.h"
#include "costs/assimilation/surface_pairs.h"
#include "datasets/observation/observation.h"
#include "sim/cloth/cloth_model.h"
#include "sim/rollout/correction.h"

namespace clothid {

class RecordingCorrection : public Correction {
 public:
  // `observation` of a recording of the cloth of `model`, with the times `times` [T] s of its frames; keeps no
  // reference to either. Forces correct nothing. `influence`: empty where all points count alike.
  RecordingCorrection(const Assimilation& assimilation, InfluenceOf influence, const Observation& observation,
                      const Eigen::VectorXd& times, const ClothModel& model);

  bool Corrects(int step) const override { return Find(step) != nullptr; }
  void Evaluate(int step, const StepEnds& ends, Eigen::VectorXd* positions, Eigen::VectorXd* velocities) const override;
  void Times(int step, const StepEnds& ends, const Eigen::MatrixXd& start_changes, const Eigen::MatrixXd& end_changes,
             Eigen::MatrixXd* positions, Eigen::MatrixXd* velocities) const override;
  void TimesTransposed(int step, const StepEnds& ends, const Eigen::MatrixXd& by_positions,
                       const Eigen::MatrixXd& by_velocities, Eigen::MatrixXd* by_start,
                       Eigen::MatrixXd* by_end) const override;

 private:
  using Factor = Eigen::SimplicialLDLT<Eigen::SparseMatrix<double>>;
  using OrderedFactor = Eigen::SimplicialLDLT<Eigen::SparseMatrix<double>, Eigen::Lower, Eigen::NaturalOrdering<int>>;
  // A frame with points that are compared with the surface, and what both ends of the step share in it.
  struct SurfaceFrame {
    int frame = 0;
    double of_start = 0.0, of_end = 1.0;
  };
  // What is seen at the end of a step, r rows: coordinates of points in a frame, those of one behind each other.
  struct CorrectedStep {
    int step = 0;
    CorrectionGains gains;
    double share = 1.0;                                   // 1 over the number of frames
    Eigen::SparseMatrix<double, Eigen::RowMajor> points;  // P [r x 3N]
    Eigen::VectorXd measured, sigma;                      // [r] m
    Eigen::VectorXd of_start, of_end;                     // [r] what both ends of the step share in its frame
    bool has_start = false;                               // of_start is not zero
    std::vector<int> first_rows;                          // of every point and frame, and r
    std::vector<SurfaceFrame> surface_frames;
  };
  // What such frames add to a step, where its ends are.
  struct StepPairs {
    std::vector<SurfacePairs> frames;
    std::unique_ptr<const OrderedFactor> factor;  // of K
  };

  const CorrectedStep& At(int step) const { return *Find(step); }
  const CorrectedStep* Find(int step) const;
  void AddStep(const Observation& observation, int first_frame, int end_frame, const CorrectionGains& gains);
  void FactorSmoothing(const Observation& observation, double smoothing, const ClothModel& model);
  void KeepInOrder(const Eigen::SparseMatrix<double>& matrix, const Mesh& mesh);
  // P of states, or of changes of them, at the times of the frames [r x s].
  static Eigen::MatrixXd Predicted(const CorrectedStep& step, const Eigen::MatrixXd& start, const Eigen::MatrixXd& end);
  // e [r]; then psi(e), and dpsi/de times `rows` [r x s].
  static Eigen::VectorXd Innovations(const CorrectedStep& step, const StepEnds& ends);
  Eigen::VectorXd Counted(const CorrectedStep& step, const Eigen::VectorXd& innovations) const;
  void TimesSlopes(const CorrectedStep& step, const Eigen::VectorXd& innovations, Eigen::MatrixXd* rows) const;
  // P^T psi(e) [3N] and, where there are pairs, what they add; K^-1 of that is u.
  Eigen::VectorXd RightSide(const CorrectedStep& step, const StepEnds& ends, const StepPairs& pairs) const;
  // The pairs of a step, if it has any, with their derivatives where these are asked for.
  StepPairs Pair(const CorrectedStep& step, const StepEnds& ends) const;
  StepPairs PairWithDerivatives(const CorrectedStep& step, const StepEnds& ends) const;
  // K^-1 of columns [3N x s]; zero at handles. Without pairs each axis is for itself.
  Eigen::MatrixXd Smooth(const StepPairs& pairs, const Eigen::MatrixXd& columns) const;
  Eigen::MatrixXd SmoothTogether(const OrderedFactor& factor, const Eigen::MatrixXd& columns) const;

  InfluenceOf influence_;
  std::vector<CorrectedStep> steps_;  // ascending
  CloudObservation clouds_;
  std::vector<int> free_nodes_;         // in the order of K
  Factor factor_;                       // of K of a step without pairs, of one axis
  Eigen::SparseMatrix<double> matrix_;  // K_0 of those with pairs, of all axes, its lower half; empty without clouds
  std::vector<int> places_;             // [N] in K, -1: handles; likewise
  Eigen::Matrix3Xi faces_;              // likewise
};

}  // namespace clothid

#endif  // CLOTHID_COSTS_ASSIMILATION_RECORDING_CORRECTION_H_

#include "identify/experiment/information_sweep.h"

#include <stdexcept>

#include "costs/prediction/recording_model.h"
#include "costs/rows/compressed_jacobian.h"

namespace clothid {
namespace {

// Sorts rows of frames into parts.
class PartCollector {
 public:
  // `observation`: of `cloth.all`; `planned`: of `cloth.planned`.
  PartCollector(const RecordedCloth& cloth, const Observation& observation, const Observation& planned, int num_columns)
      : cloth_(cloth),
        observation_(observation),
        planned_(planned),
        collected_(kNumRowParts, CompressedJacobian(num_columns)) {}

  void AddFrame(int frame, const Eigen::MatrixXd& jacobian) {
    const int reading = frame - observation_.num_frames();
    if (reading >= 0) {
      const bool is_later = reading >= cloth_.planned.num_frames();
      Add(is_later ? RowPart::kLaterForces : RowPart::kForces, jacobian);
      if (!is_later && !cloth_.planned.forces.is_empty()) AddWeighed(planned_.num_frames() + reading, jacobian);
      return;
    }
    const int first = observation_.first_row(frame), num_points = cloth_.planned.num_points();
    Eigen::Index num_own = 0;
    while (num_own < jacobian.rows() &&
           observation_.coordinates()[static_cast<std::size_t>(first + num_own)].point < num_points) {
      ++num_own;
    }
    const bool is_between = frame % 2 == 1, is_later = frame / 2 >= cloth_.planned.num_frames();
    if (is_between && (is_later || cloth_.planned.times[cloth_.planned.num_frames() - 1] < cloth_.all.times[frame])) {
      return;  // between frames that the plan does not have
    }
    const RowPart own = is_between ? RowPart::kBetween : is_later ? RowPart::kLater : RowPart::kPlanned;
    Add(own, jacobian.topRows(num_own));
    if (own != RowPart::kPlanned) return;
    AddWeighed(frame / 2, jacobian.topRows(num_own));
    Add(RowPart::kFurther, jacobian.bottomRows(jacobian.rows() - num_own));
  }

  const Eigen::MatrixXd& Factor(int part) { return collected_[static_cast<std::size_t>(part)].Factor(); }

 private:
  void Add(RowPart part, const Eigen::MatrixXd& jacobian) {
    if (jacobian.rows() == 0) return;
    collected_[static_cast<std::size_t>(part)].Add(jacobian, Eigen::VectorXd::Zero(jacobian.rows()));
  }

  // A frame of the plan, or a reading after all frames.
  void AddWeighed(int frame, const Eigen::MatrixXd& jacobian) {
    const Eigen::VectorXd& weights = planned_.error_weights();
    if (weights.size() == 0) return;
    Add(RowPart::kWeighed, weights.segment(planned_.first_row(frame), jacobian.rows()).asDiagonal() * jacobian);
  }

  const RecordedCloth& cloth_;
  const Observation &observation_, &planned_;
  std::vector<CompressedJacobian> collected_;
};

}  // namespace

InformationSweep SweepCloth(const RecordedCloth& cloth, const FitProblem& problem, const Eigen::MatrixXd& directions,
                            const std::atomic<bool>* cancel) {
  const std::vector<int> free = problem.free_blocks();
  const int num_free = static_cast<int>(free.size()), num_blocks = problem.num_blocks();
  const int num_start = static_cast<int>(directions.cols());
  const RecordingModel& planned = problem.cost(0).model();
  RecordingModel model(cloth.all, problem.blocks(), {}, planned.shared_start());
  PartCollector collector(cloth, model.observation(), planned.observation(), num_free + num_start);
  model.PushForward(
      cloth.rollout, problem.StartCoordinates(), {free, directions},
      [&](int frame, const Eigen::VectorXd&, const Eigen::VectorXd&, const Eigen::MatrixXd& jacobian) {
        if (cancel != nullptr && cancel->load()) throw std::runtime_error("interrupted");
        collector.AddFrame(frame, jacobian);
      },
      Precision::kFull);
  InformationSweep sweep;
  for (int part = 0; part < kNumRowParts; ++part) {
    const Eigen::MatrixXd& factor = collector.Factor(part);
    if (!factor.allFinite()) throw std::runtime_error("the sensitivities are not finite");
    Eigen::MatrixXd& rows = sweep.parts[static_cast<std::size_t>(part)];
    rows = Eigen::MatrixXd::Zero(factor.rows(), num_blocks + num_start);
    rows(Eigen::all, free) = factor.leftCols(num_free);
    rows.rightCols(num_start) = factor.middleCols(num_free, num_start);
  }
  sweep.has_forces = !cloth.all.forces.is_empty();
  sweep.has_further = cloth.all.num_points() > cloth.planned.num_points();
  return sweep;
}

InformationMap MapInformation(const RecordedCloth& cloth, const FitProblem& problem, const Eigen::MatrixXd& follow,
                              const Eigen::MatrixXd& influence, const std::atomic<bool>* cancel) {
  const std::vector<int> free = problem.free_blocks();
  const auto num_free = static_cast<Eigen::Index>(free.size());
  RecordingModel model(cloth.planned, problem.blocks(), {}, problem.cost(0).model().shared_start());
  SweepColumns columns{free, {}};
  if (follow.rows() > 0) columns.combinations = follow(Eigen::all, free);
  const Observation& observation = model.observation();
  InformationMap map;
  map.times = cloth.planned.times;
  map.per_node = Eigen::MatrixXd::Zero(cloth.planned.scene.mesh.num_nodes(), influence.cols());
  map.per_frame = Eigen::MatrixXd::Zero(map.times.size(), influence.cols());
  map.of_forces = Eigen::VectorXd::Zero(influence.cols());
  const SensitivityResult result = model.PushForward(
      problem.StartCoordinates(), columns,
      [&](int frame, const Eigen::VectorXd&, const Eigen::VectorXd&, const Eigen::MatrixXd& jacobian) {
        Eigen::MatrixXd alone = jacobian.leftCols(num_free);
        if (follow.rows() > 0) alone += jacobian.rightCols(num_free);
        const Eigen::MatrixXd squared = (alone * influence(free, Eigen::all)).cwiseAbs2();
        if (frame >= observation.num_frames()) {
          map.of_forces += squared.colwise().sum().transpose();
          return;
        }
        map.per_frame.row(frame) += squared.colwise().sum();
        for (Eigen::Index r = 0; r < squared.rows(); ++r) {
          const SeenCoordinate& seen = observation.coordinates()[observation.first_row(frame) + r];
          map.per_node.row(cloth.planned.points[seen.point].nodes[0]) += squared.row(r);
        }
      },
      {Precision::kFull, cancel});
  if (result.failure) throw std::runtime_error(result.failure->ToString());
  return map;
}

}  // namespace clothid

// The records of a rollout for a sweep from its end to its start, those that it did not keep made again.
#ifndef CLOTHID_SIM_ROLLOUT_RECORD_READER_H_
#define CLOTHID_SIM_ROLLOUT_RECORD_READER_H_

#include <Eigen/Core>
#include <vector>

#include "sim/rollout/rollout.h"
#include "sim/step/stage.h"

namespace clothid {

class Simulator;

// Reads backwards at the cost of one more rollout at the most; in any other order it may simulate a segment repeatedly.
class RecordReader {
 public:
  // Both must outlive the reader. `simulator` must be of the scene that `rollout` was made with.
  RecordReader(const Rollout& rollout, Simulator* simulator);

  // Record i, to the last bit the one that the rollout had. Where it is not kept, the steps from the checkpoint before
  // it to the one after it are simulated again: references to records that were not kept either become invalid. Throws
  // `std::runtime_error` where they do not end in that checkpoint.
  const StepRecord& record(int i);

  // What solve i starts from; of the second stage of a step computed, to the last bit what its solver had. Valid until
  // the reader is asked for another record or start.
  SolveStart start(int i);
  const Eigen::VectorXd& start_positions(int i) { return start(i).positions; }
  const Eigen::VectorXd& start_velocities(int i) { return start(i).velocities; }

 private:
  void SimulateSegmentOf(int i);
  // The ends of record i, corrected where they are, or the start of the rollout for i = -1.
  const Eigen::VectorXd& end_positions(int i);
  const Eigen::VectorXd& end_velocities(int i);

  const Rollout& rollout_;
  Simulator* simulator_;
  int first_record_ = 0;             // of the segment
  std::vector<StepRecord> records_;  // the steps that were simulated last
  int second_record_ = -1;           // the second stage that `second_start_` belongs to; -1: none yet
  SecondStart second_start_;
};

}  // namespace clothid

#endif  // CLOTHID_SIM_ROLLOUT_RECORD_READER_H_

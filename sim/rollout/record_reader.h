// The records of a rollout for a sweep from its end to its start, those that it did not keep made again.
#ifndef CLOTHID_SIM_ROLLOUT_RECORD_READER_H_
#define CLOTHID_SIM_ROLLOUT_RECORD_READER_H_

#include <Eigen/Core>
#include <vector>

#include "sim/rollout/rollout.h"

namespace clothid {

class Simulator;

// Reads backwards at the cost of one more rollout at the most; in any other order it may simulate a segment repeatedly.
class RecordReader {
 public:
  // Both must outlive the reader. `simulator` must be of the scene that `rollout` was made with.
  RecordReader(const Rollout& rollout, Simulator* simulator) : rollout_(rollout), simulator_(simulator) {}

  // Record i, to the last bit the one that the rollout had. Where it is not kept, the steps from the checkpoint before
  // it to the one after it are simulated again: references to records that were not kept either become invalid. Throws
  // `std::runtime_error` where they do not end in that checkpoint.
  const StepRecord& record(int i);

  // The state from which record i starts.
  const Eigen::VectorXd& start_positions(int i);
  const Eigen::VectorXd& start_velocities(int i);

 private:
  void SimulateSegmentOf(int i);

  const Rollout& rollout_;
  Simulator* simulator_;
  int first_record_ = 0;             // of the segment
  std::vector<StepRecord> records_;  // the steps that were simulated last
};

}  // namespace clothid

#endif  // CLOTHID_SIM_ROLLOUT_RECORD_READER_H_

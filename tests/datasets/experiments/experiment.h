// The scenes of datasets/experiments.
#ifndef CLOTHID_TESTS_DATASETS_EXPERIMENTS_EXPERIMENT_H_
#define CLOTHID_TESTS_DATASETS_EXPERIMENTS_EXPERIMENT_H_

#include <Eigen/Core>
#include <string>

#include "sim/scene/scene_json.h"

namespace clothid {

inline const std::string kExperiments = std::string(CLOTHID_SOURCE_DIR) + "/datasets/experiments";

inline Scene Experiment(const std::string& name) { return ReadScene(kExperiments + "/" + name + ".scene.json"); }

// The mean position of `count` successive nodes, m.
inline Eigen::Vector3d MeanOf(const Eigen::VectorXd& positions, int first, int count) {
  return positions.segment(3 * first, 3 * count).reshaped(3, count).rowwise().mean();
}

}  // namespace clothid

#endif  // CLOTHID_TESTS_DATASETS_EXPERIMENTS_EXPERIMENT_H_

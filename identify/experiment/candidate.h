// The candidates of a plan as they are asked for: scenes, and what would be fitted to a recording of each.
#ifndef CLOTHID_IDENTIFY_EXPERIMENT_CANDIDATE_H_
#define CLOTHID_IDENTIFY_EXPERIMENT_CANDIDATE_H_

#include <Eigen/Core>
#include <map>
#include <string>
#include <vector>

#include "identify/experiment/plan_options.h"
#include "sim/scene/scene.h"

namespace clothid {

struct Candidate {
  std::string path, name, text;  // text: the JSON of the scene
  Scene scene;
  FitOptions fit;                      // of the parameters that it has, on one thread
  std::vector<ParameterBlock> blocks;  // of the nominal cloth; without recordings' own parameters
};

// Throws `Error` as `PlanExperiment` does.
std::vector<Candidate> ReadCandidates(const PlanOptions& options);

// The scene of `PlanOptions::predicted_path`, with blocks of those of the parameters that it has. Throws likewise.
Candidate ReadPredicted(const PlanOptions& options);

// What a fit of recordings of several candidates is asked for.
FitOptions JointOptions(const PlanOptions& options, const std::vector<const Candidate*>& candidates);

// True values by name of cloth number `cloth`, 0 the nominal one, of what can be drawn.
std::map<std::string, double> DrawCloth(const PlanOptions& options, const Candidate& candidate, int cloth);

}  // namespace clothid

#endif  // CLOTHID_IDENTIFY_EXPERIMENT_CANDIDATE_H_

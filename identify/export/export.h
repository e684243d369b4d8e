// Fitted constants as files for other simulators, with formula, unit and source beside every number.
//
//   mujoco   export_mujoco.xml: a model (MJCF) of the cloth as a flex, ready to run
//   newton   export_newton.py: a function that adds the cloth to a ModelBuilder of NVIDIA Newton
//   arcsim   export_arcsim.json: a material of ARCSim
//   blender  export_blender.py: settings of Blender's cloth modifier
//   ppf      export_ppf.py: parameters of ppf-contact-solver
// All but mujoco come with export_cloth.obj, the mesh at rest.
#ifndef CLOTHID_IDENTIFY_EXPORT_EXPORT_H_
#define CLOTHID_IDENTIFY_EXPORT_EXPORT_H_

#include <map>
#include <string>
#include <vector>

#include "datasets/fabric/fabric_card.h"
#include "identify/repetition/repetitions.h"
#include "sim/scene/parameters.h"
#include "sim/scene/scene.h"

namespace clothid {

struct ExportedFile {
  std::string name, text;
};

// Estimates by name, and what is to be said beside some of them.
struct ExportedEstimates {
  std::map<std::string, double> values;
  std::map<std::string, std::string> remarks;

  // Of what was pooled the mean over the recordings, with its interval and their scatter beside it; of what could not
  // be and has no joint estimate nothing, which is said.
  void TakeMeans(const Repetitions& repetitions);
};

// "mujoco,newton"; empty: none; "all": every one. Throws `Error` (kUsage), naming `flag`, for others.
std::vector<std::string> ParseSimulators(const std::string& text, const std::string& flag);

// The nominal parameters of `scene` with those of `values`, estimates by name, that are constants of the cloth or its
// obstacles. The wind, what is of a recording itself, as time_offset, and of another than the first are left out.
Parameters ParametersOfEstimates(const std::map<std::string, double>& values, const Scene& scene);

// Throws `Error` (kUsage), led by `source`, for a cloth that no file here can tell: one that is sewn, or whose rest
// shape is a UV map.
void ExpectExportable(const Scene& scene, const std::string& source);

// The files for these simulators. Throws as `ExpectExportable` does. The same arguments, the same texts. `remarks` by
// the name of a parameter stand in the comment of its constant. `card` says how far the cloth was strained, at which a
// law that stiffens is cut to one number; null: not at all.
std::vector<ExportedFile> ExportCloth(const Scene& scene, const Parameters& parameters,
                                      const std::vector<std::string>& simulators,
                                      const std::map<std::string, std::string>& remarks = {},
                                      const FabricCard* card = nullptr);

// Whether `ExportCloth` gives files of this name.
bool IsExportedFile(const std::string& name);

// `identify --result RESULT --export SIMULATORS --output FOLDER`: the estimates of a result.json for the cloth of the
// recording `target`; empty: of predicted.bin in the folder of the result. Of repetitions the means. fabric.json in
// that folder is the card, if it is there. All files or none.
// Throws `Error`: kUsage without simulators or a folder; kIo and kBadData, naming file and key, for what cannot be
// read.
void ExportResult(const std::string& result, const std::string& target, const std::string& simulators,
                  const std::string& folder);

}  // namespace clothid

#endif  // CLOTHID_IDENTIFY_EXPORT_EXPORT_H_

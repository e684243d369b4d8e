// The text of each file of an export. Internal to identify/export.
#ifndef CLOTHID_IDENTIFY_EXPORT_SIMULATOR_EXPORTS_H_
#define CLOTHID_IDENTIFY_EXPORT_SIMULATOR_EXPORTS_H_

#include <string>

#include "identify/export/export_constants.h"
#include "sim/scene/scene.h"

namespace clothid {

std::string MujocoXml(const Scene& scene, const ExportConstants& constants);
std::string NewtonScript(const ExportConstants& constants);
std::string ArcsimJson(const ExportConstants& constants);
std::string BlenderScript(const Scene& scene, const ExportConstants& constants);
std::string PpfScript(const ExportConstants& constants);
std::string ClothObj(const Scene& scene);

// What was found, and what no number here stands for, as lines that begin with `comment`.
std::string Preamble(const ExportConstants& constants, const std::string& comment);

}  // namespace clothid

#endif  // CLOTHID_IDENTIFY_EXPORT_SIMULATOR_EXPORTS_H_

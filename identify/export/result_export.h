// Exports what an earlier fit has found.
#ifndef CLOTHID_IDENTIFY_EXPORT_RESULT_EXPORT_H_
#define CLOTHID_IDENTIFY_EXPORT_RESULT_EXPORT_H_

#include <string>

namespace clothid {

// `identify --result RESULT --export SIMULATORS --output FOLDER`: the estimates of a result.json for the cloth of the
// recording `target`; empty: of predicted.bin in the folder of the result. All files or none. Throws `Error`: kUsage
// without simulators or a folder; kIo and kBadData, naming file and key, for what cannot be read.
void ExportResult(const std::string& result, const std::string& target, const std::string& simulators,
                  const std::string& folder);

}  // namespace clothid

#endif  // CLOTHID_IDENTIFY_EXPORT_RESULT_EXPORT_H_

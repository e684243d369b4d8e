// The metadata of motion.bin (datasets/motion/motion_file.h) and the checksums in it. Internal to datasets/.
#ifndef CLOTHID_DATASETS_MOTION_MOTION_HEADER_H_
#define CLOTHID_DATASETS_MOTION_MOTION_HEADER_H_

#include <string>
#include <vector>

#include "datasets/files/safetensors.h"

namespace clothid {

// Throws `Error` (kBadData), naming `path` and key, unless format and version are those of a motion file, all keys are
// known, and the checksums are those of header and tensors.
void VerifyMotionHeader(const Safetensors& file, const std::string& path);

// The string `key` of the metadata. Throws `Error` (kBadData) where there is none.
const std::string& RequireMetadata(const Safetensors& file, const std::string& path, const std::string& key);

// The header of a container with these strings and tensors, whose bytes have the checksum `sha256`.
std::string MotionHeader(const std::string& scene_text, const std::string& provenance, const std::string& sha256,
                         const std::vector<TensorBytes>& tensors);

}  // namespace clothid

#endif  // CLOTHID_DATASETS_MOTION_MOTION_HEADER_H_

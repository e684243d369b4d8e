#include "datasets/motion/motion_header.h"

#include <algorithm>
#include <iterator>
#include <string_view>

#include "datasets/files/sha256.h"
#include "sim/base/error.h"
#include "sim/base/text_file.h"

namespace clothid {
namespace {

constexpr char kFormat[] = "clothid.motion";
constexpr char kVersion[] = "1";
constexpr std::size_t kDigestLength = 64;

constexpr std::string_view kMetadataKeys[] = {"format", "version", "scene", "provenance", "sha256", "header_sha256"};

std::string HeaderDigest(std::string header, std::size_t digest_position) {
  header.replace(digest_position, kDigestLength, kDigestLength, ' ');
  return Sha256Hex({header});
}

// Where the value of `header_sha256` stands in the header; npos where it does not. The quotes around the key cannot
// stand inside a JSON string, so nothing but a key is found, and only `__metadata__` may hold this one.
std::size_t FindHeaderDigest(const std::string& header, const std::string& digest) {
  constexpr char kKey[] = "\"header_sha256\"";
  constexpr char kBlanks[] = " \t\r\n";
  const std::size_t key = header.find(kKey);
  if (key == std::string::npos) return key;
  const std::size_t colon = header.find_first_not_of(kBlanks, key + sizeof(kKey) - 1);
  if (colon == std::string::npos || header[colon] != ':') return std::string::npos;
  const std::size_t quote = header.find_first_not_of(kBlanks, colon + 1);
  if (quote == std::string::npos || header.compare(quote, digest.size() + 2, "\"" + digest + "\"") != 0) {
    return std::string::npos;
  }
  return quote + 1;
}

void ExpectMetadata(const Safetensors& file, const std::string& path, const std::string& key,
                    const std::string& expected) {
  const std::string& found = RequireMetadata(file, path, key);
  if (found != expected) {
    FailOnData(path, "key '__metadata__." + key + "': expected '" + expected + "', found '" + Printable(found) + "'");
  }
}

}  // namespace

const std::string& RequireMetadata(const Safetensors& file, const std::string& path, const std::string& key) {
  const auto found = file.metadata.find(key);
  if (found == file.metadata.end()) FailOnData(path, "key '__metadata__." + key + "': is missing; expected a string");
  return found->second;
}

void VerifyMotionHeader(const Safetensors& file, const std::string& path) {
  ExpectMetadata(file, path, "format", kFormat);
  ExpectMetadata(file, path, "version", kVersion);
  for (const auto& [key, value] : file.metadata) {
    if (std::find(std::begin(kMetadataKeys), std::end(kMetadataKeys), key) == std::end(kMetadataKeys)) {
      FailOnData(path, "unknown key '__metadata__." + Printable(key) + "'");
    }
  }
  const auto header_digest = file.metadata.find("header_sha256");
  if (header_digest != file.metadata.end()) {
    const std::size_t position = FindHeaderDigest(file.header, header_digest->second);
    if (header_digest->second.size() != kDigestLength || position == std::string::npos ||
        HeaderDigest(file.header, position) != header_digest->second) {
      FailOnData(path, "key '__metadata__.header_sha256': does not match the header; the file is damaged");
    }
  }
  if (RequireMetadata(file, path, "sha256") != Sha256Hex({file.data})) {
    FailOnData(path, "key '__metadata__.sha256': does not match the tensors; the file is damaged");
  }
}

std::string MotionHeader(const std::string& scene_text, const std::string& provenance, const std::string& sha256,
                         const std::vector<TensorBytes>& tensors) {
  const std::string blank(kDigestLength, ' ');
  std::string header = SafetensorsHeader({{"format", kFormat},
                                          {"version", kVersion},
                                          {"scene", scene_text},
                                          {"provenance", provenance},
                                          {"sha256", sha256},
                                          {"header_sha256", blank}},
                                         tensors);
  header.replace(FindHeaderDigest(header, blank), kDigestLength, Sha256Hex({header}));
  return header;
}

}  // namespace clothid

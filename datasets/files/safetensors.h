// The safetensors container: an 8-byte little-endian header length, a JSON header, then the raw little-endian tensors.
// https://github.com/huggingface/safetensors#format
//
// Header: {"__metadata__": {string: string}, NAME: {"dtype": .., "shape": [..], "data_offsets": [begin, end]}, ..},
// padded with blanks. Here the tensors must cover the data without overlap and without a hole, and are F32, F64 or I32.
#ifndef CLOTHID_DATASETS_FILES_SAFETENSORS_H_
#define CLOTHID_DATASETS_FILES_SAFETENSORS_H_

#include <cstddef>
#include <cstdint>
#include <map>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

namespace clothid {

enum class TensorType { kF32, kF64, kI32 };

const char* TensorTypeName(TensorType type);  // "F32", ..

struct TensorInfo {
  TensorType type = TensorType::kF64;
  std::vector<long long> shape;
  std::size_t begin = 0, end = 0;  // bytes of the data

  std::size_t num_elements() const;
};

// A container that was read: every offset lies within `data` and fits its type and shape.
struct Safetensors {
  std::string length_bytes;  // the first 8 bytes of the file
  std::string header;        // the JSON text with its padding
  std::string data;
  std::map<std::string, std::string> metadata;
  std::map<std::string, TensorInfo> tensors;

  std::string_view bytes(const TensorInfo& tensor) const {
    return std::string_view(data).substr(tensor.begin, tensor.end - tensor.begin);
  }
};

inline constexpr std::uint64_t kMaxContainerBytes = std::uint64_t{1} << 32;
inline constexpr std::uint64_t kMaxHeaderBytes = 100'000'000;  // the limit of the reference implementation
inline constexpr std::size_t kMaxHeaderKeys = 1000;            // tensors, and strings of the metadata

// Checks every bound before anything of the size that the file claims is allocated. Throws `Error`: kIo where the file
// cannot be read, else kBadData naming file and key.
Safetensors ReadSafetensors(const std::string& path);

// A tensor to be written.
struct TensorBytes {
  std::string name;
  TensorType type = TensorType::kF64;
  std::vector<long long> shape;
  std::string bytes;
};

// The header of a file that holds `tensors` in this order, padded to a multiple of 8 bytes.
std::string SafetensorsHeader(const std::vector<std::pair<std::string, std::string>>& metadata,
                              const std::vector<TensorBytes>& tensors);

// The 8 bytes that stand before a header of this length.
std::string LengthBytes(std::size_t length);

}  // namespace clothid

#endif  // CLOTHID_DATASETS_FILES_SAFETENSORS_H_

// What stands before the numbers of a PLY file, the Stanford polygon format. Internal to datasets/.
//   ply
//   format ascii|binary_little_endian|binary_big_endian 1.0
//   comment ..
//   element NAME COUNT
//   property TYPE NAME
//   property list TYPE TYPE NAME
//   end_header
#ifndef CLOTHID_DATASETS_FORMATS_PLY_HEADER_H_
#define CLOTHID_DATASETS_FORMATS_PLY_HEADER_H_

#include <cstddef>
#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

namespace clothid {

enum class PlyEncoding { kAscii, kLittleEndian, kBigEndian };

enum class PlyType { kInt8, kUint8, kInt16, kUint16, kInt32, kUint32, kFloat32, kFloat64 };

std::size_t PlyTypeSize(PlyType type);  // bytes

struct PlyProperty {
  std::string name;
  PlyType type = PlyType::kFloat32;
  std::optional<PlyType> count_type;  // an integer; of a list alone
};

struct PlyElement {
  std::string name;
  std::uint64_t count = 0;
  std::vector<PlyProperty> properties;

  // The index of the property of this name, one number unless `is_list`; nothing where there is none.
  std::optional<std::size_t> Find(std::string_view property_name, bool is_list) const;
};

struct PlyHeader {
  PlyEncoding encoding = PlyEncoding::kAscii;
  std::vector<PlyElement> elements;
  std::size_t size = 0;  // bytes before the numbers
  int num_lines = 0;
};

// Reads the header from the bytes of a whole file. Throws `Error` (kBadData), naming `path` and line.
PlyHeader ReadPlyHeader(const std::string& path, std::string_view bytes);

}  // namespace clothid

#endif  // CLOTHID_DATASETS_FORMATS_PLY_HEADER_H_

#include "datasets/files/file_kind.h"

#include <algorithm>
#include <cerrno>
#include <cstring>
#include <fstream>

#include "sim/base/error.h"
#include "sim/base/text_file.h"

namespace clothid {
namespace {

struct Signature {
  std::string_view start, kind;
};

constexpr Signature kSignatures[] = {{"\x1f\x8b", "packed with gzip"},
                                     {"PK\x03\x04", "packed with zip (.npz is, too)"},
                                     {"\xfd"
                                      "7zXZ",
                                      "packed with xz"},
                                     {"BZh", "packed with bzip2"},
                                     {"\x28\xb5\x2f\xfd", "packed with zstd"},
                                     {"\x93NUMPY", "a NumPy array"},
                                     {"\x89HDF", "an HDF5 file (.h5, .mat)"},
                                     {"MATLAB", "a MATLAB file"},
                                     {"#ROSBAG", "a ROS bag"},
                                     {"POINTCACHE2", "a PC2 point cache"},
                                     {"ply\n", "a PLY mesh"},
                                     {"ply\r", "a PLY mesh"},
                                     {"\x7f"
                                      "ELF",
                                      "a program"},
                                     {"version https://git-lfs", "a Git LFS pointer: the file itself is not here"}};

// Of bytes that text, also in UTF-8, does not hold.
bool IsBinary(char c) {
  const auto byte = static_cast<unsigned char>(c);
  return byte == 0x7f || byte >= 0xf8 || (byte < 0x20 && c != '\t' && c != '\n' && c != '\r');
}

}  // namespace

std::string ReadStart(const std::string& path, std::size_t max_bytes) {
  std::ifstream file(path, std::ios::binary);
  if (!file) throw Error(ErrorKind::kIo, path + ": cannot be read: " + std::strerror(errno));
  std::string start(max_bytes, '\0');
  file.read(start.data(), static_cast<std::streamsize>(start.size()));
  start.resize(static_cast<std::size_t>(file.gcount()));
  StripByteOrderMark(path, &start);
  return start;
}

std::string FileKind(std::string_view start) {
  start = start.substr(0, kKindBytes);
  for (const Signature& signature : kSignatures) {
    if (start.substr(0, signature.start.size()) == signature.start) return std::string(signature.kind);
  }
  if (start.empty() || std::any_of(start.begin(), start.end(), IsBinary)) return "";
  const std::size_t first = start.find_first_not_of(" \t\r\n");
  return first != std::string_view::npos && (start[first] == '{' || start[first] == '[') ? "JSON text" : "text";
}

}  // namespace clothid

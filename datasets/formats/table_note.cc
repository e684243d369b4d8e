#include "datasets/formats/table_note.h"

#include <algorithm>
#include <array>
#include <filesystem>
#include <string_view>

#include "datasets/files/file_kind.h"
#include "sim/base/error.h"
#include "sim/base/table.h"
#include "sim/base/text_file.h"

namespace clothid {
namespace {

constexpr std::size_t kMaxLooked = 1 << 16;  // bytes

// Of text that is no table, in small letters.
constexpr std::array<std::string_view, 4> kOthers = {".trc", ".obj", ".ply", ".json"};

}  // namespace

std::string TableNote(const std::string& path) {
  const std::string extension = std::filesystem::path(path).extension().string();
  if (std::find(kOthers.begin(), kOthers.end(), extension) != kOthers.end()) return "";
  try {
    const std::string start = ReadStart(path, kMaxLooked);
    if (FileKind(start) != "text") return "";
    return Table(path, start.substr(0, start.rfind('\n')), "").note();
  } catch (const Error&) {
    return "";
  }
}

}  // namespace clothid

#include "datasets/formats/table_note.h"

#include <algorithm>
#include <array>
#include <filesystem>
#include <optional>
#include <string_view>

#include "datasets/files/file_kind.h"
#include "sim/base/error.h"
#include "sim/base/table.h"
#include "sim/base/text_file.h"

namespace clothid {
namespace {

constexpr std::size_t kMaxLooked = 1 << 16;  // bytes

// Of text that is no table, in small letters.
constexpr std::array<std::string_view, 3> kOthers = {".obj", ".ply", ".json"};

constexpr char kTrc[] = ".trc";

// The same of a TRC file, which has no header and whose cells always stand between tabs. Labels may have commas.
std::string TrcNote(std::string_view start) {
  while (const std::optional<std::string_view> line = TakeLine(&start)) {
    const bool has_numbers = !line->empty() && line->front() >= '0' && line->front() <= '9';
    if (has_numbers && line->find(',') != std::string_view::npos) {
      return "commas in numbers are taken for decimal marks";
    }
  }
  return "";
}

}  // namespace

std::string TableNote(const std::string& path) {
  const std::string extension = std::filesystem::path(path).extension().string();
  if (extension == kTrc) {
    try {
      return TrcNote(ReadStart(path, kMaxLooked));
    } catch (const Error&) {
      return "";
    }
  }
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

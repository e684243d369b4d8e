#include "datasets/formats/ply_header.h"

#include <algorithm>
#include <utility>

#include "sim/base/error.h"
#include "sim/base/text_file.h"

namespace clothid {
namespace {

struct NamedType {
  std::string_view name, other_name;
  PlyType type;
  std::size_t size;  // bytes
};

constexpr NamedType kTypes[] = {
    {"char", "int8", PlyType::kInt8, 1},        {"uchar", "uint8", PlyType::kUint8, 1},
    {"short", "int16", PlyType::kInt16, 2},     {"ushort", "uint16", PlyType::kUint16, 2},
    {"int", "int32", PlyType::kInt32, 4},       {"uint", "uint32", PlyType::kUint32, 4},
    {"float", "float32", PlyType::kFloat32, 4}, {"double", "float64", PlyType::kFloat64, 8},
};

class PlyHeaderReader {
 public:
  PlyHeaderReader(const std::string& path, std::string_view bytes) : path_(path), bytes_(bytes), rest_(bytes) {}

  PlyHeader Read() {
    if (Line() != "ply") Fail("is not a PLY file: expected 'ply'");
    ReadFormat(Line());
    while (true) {
      std::string_view line = Line();
      const std::string_view keyword = TakeWord(&line);
      if (keyword == "end_header") break;
      if (keyword == "comment" || keyword == "obj_info") continue;
      if (keyword == "element") {
        ReadElement(line);
      } else if (keyword == "property") {
        ReadProperty(line);
      } else {
        Fail("expected 'element', 'property', 'comment' or 'end_header', found '" + Printable(keyword) + "'");
      }
    }
    header_.size = bytes_.size() - rest_.size();
    return header_;
  }

 private:
  [[noreturn]] void Fail(const std::string& message) const {
    throw Error(ErrorKind::kBadData, path_ + ":" + std::to_string(header_.num_lines) + ": " + message);
  }

  std::string_view Line() {
    const std::optional<std::string_view> line = TakeLine(&rest_);
    ++header_.num_lines;
    if (!line) Fail("expected 'end_header'");
    return *line;
  }

  void ReadFormat(std::string_view line) {
    const std::string_view keyword = TakeWord(&line), format = TakeWord(&line), version = TakeWord(&line);
    if (keyword == "format" && format == "ascii") {
      header_.encoding = PlyEncoding::kAscii;
    } else if (keyword == "format" && format == "binary_little_endian") {
      header_.encoding = PlyEncoding::kLittleEndian;
    } else if (keyword == "format" && format == "binary_big_endian") {
      header_.encoding = PlyEncoding::kBigEndian;
    } else {
      Fail("expected 'format' and ascii, binary_little_endian or binary_big_endian");
    }
    if (version != "1.0") Fail("expected version 1.0, found '" + Printable(version) + "'");
  }

  void ReadElement(std::string_view line) {
    PlyElement element;
    element.name = TakeWord(&line);
    const std::string_view word = TakeWord(&line);
    const std::optional<long long> count = ParseInteger(word);
    if (element.name.empty() || !count || *count < 0) {
      Fail("expected 'element NAME COUNT' with a count >= 0, found '" + Printable(word) + "'");
    }
    element.count = static_cast<std::uint64_t>(*count);
    header_.elements.push_back(std::move(element));
  }

  void ReadProperty(std::string_view line) {
    if (header_.elements.empty()) Fail("expected an element before its first property");
    PlyProperty property;
    std::string_view word = TakeWord(&line);
    if (word == "list") {
      property.count_type = Type(TakeWord(&line));
      if (*property.count_type == PlyType::kFloat32 || *property.count_type == PlyType::kFloat64) {
        Fail("expected an integer type for the length of a list");
      }
      word = TakeWord(&line);
    }
    property.type = Type(word);
    property.name = TakeWord(&line);
    if (property.name.empty()) Fail("expected a name after the type of a property");
    header_.elements.back().properties.push_back(std::move(property));
  }

  PlyType Type(std::string_view word) const {
    for (const NamedType& type : kTypes) {
      if (word == type.name || word == type.other_name) return type.type;
    }
    Fail("expected a type like 'float' or 'uchar', found '" + Printable(word) + "'");
  }

  const std::string& path_;
  const std::string_view bytes_;
  std::string_view rest_;
  PlyHeader header_;
};

}  // namespace

std::size_t PlyTypeSize(PlyType type) {
  return std::find_if(std::begin(kTypes), std::end(kTypes), [&](const NamedType& t) { return t.type == type; })->size;
}

std::optional<std::size_t> PlyElement::Find(std::string_view property_name, bool is_list) const {
  for (std::size_t i = 0; i < properties.size(); ++i) {
    if (properties[i].name == property_name && properties[i].count_type.has_value() == is_list) return i;
  }
  return std::nullopt;
}

PlyHeader ReadPlyHeader(const std::string& path, std::string_view bytes) { return PlyHeaderReader(path, bytes).Read(); }

}  // namespace clothid

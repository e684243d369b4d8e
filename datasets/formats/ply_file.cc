#include "datasets/formats/ply_file.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <limits>
#include <optional>
#include <string_view>
#include <utility>
#include <vector>

#include "datasets/formats/ply_header.h"
#include "datasets/formats/track_cells.h"
#include "sim/base/byte_order.h"
#include "sim/base/error.h"
#include "sim/base/text_file.h"

namespace clothid {
namespace {

constexpr std::string_view kWhiteSpace = " \t\r\n\v\f";

// What a file is read for.
enum class PlyUse { kMesh, kPoints };

// "inf" and the like, which vertices of a mesh must not be and other numbers may.
std::optional<double> ParseInfinity(std::string_view word) {
  std::string text(word);
  for (char& c : text) c = static_cast<char>(c | 0x20);
  const double sign = text.front() == '-' ? -1.0 : 1.0;
  if (word.front() == '-' || word.front() == '+') text.erase(0, 1);
  if (text != "inf" && text != "infinity") return std::nullopt;
  return sign * std::numeric_limits<double>::infinity();
}

// The numbers behind a header, one after the other.
class PlyNumbers {
 public:
  PlyNumbers(const std::string& path, std::string_view bytes, const PlyHeader& header)
      : path_(path), encoding_(header.encoding), bytes_(bytes), position_(header.size), line_(header.num_lines + 1) {}

  double Next(PlyType type) { return encoding_ == PlyEncoding::kAscii ? NextWord() : NextBinary(type); }

  std::size_t num_left() const { return bytes_.size() - position_; }  // bytes

  // Throws unless nothing is left but white space of a text.
  void ExpectEnd() {
    if (encoding_ == PlyEncoding::kAscii) SkipWhiteSpace();
    if (num_left() > 0) Fail("expected the file to end after the last element of its header");
  }

  // Of the number read last, from 1 on; 0: binary.
  int line() const { return encoding_ == PlyEncoding::kAscii ? line_ : 0; }

  [[noreturn]] void Fail(const std::string& message) const {
    const std::string place =
        encoding_ == PlyEncoding::kAscii ? std::to_string(line_) : " byte " + std::to_string(position_);
    throw Error(ErrorKind::kBadData, path_ + ":" + place + ": " + message);
  }

 private:
  void SkipWhiteSpace() {
    for (; position_ < bytes_.size() && kWhiteSpace.find(bytes_[position_]) != std::string_view::npos; ++position_) {
      if (bytes_[position_] == '\n') ++line_;
    }
  }

  double NextWord() {
    SkipWhiteSpace();
    const std::size_t end = std::min(bytes_.find_first_of(kWhiteSpace, position_), bytes_.size());
    const std::string_view word = bytes_.substr(position_, end - position_);
    if (word.empty()) Fail("ends before the elements of its header are complete");
    std::optional<double> value = ParseCoordinate(word);
    if (!value) value = ParseInfinity(word);
    if (!value) Fail("expected a number, found '" + Printable(word) + "'");
    position_ = end;
    return *value;
  }

  double NextBinary(PlyType type) {
    switch (type) {
      case PlyType::kInt8:
        return Load<std::int8_t>();
      case PlyType::kUint8:
        return Load<std::uint8_t>();
      case PlyType::kInt16:
        return Load<std::int16_t>();
      case PlyType::kUint16:
        return Load<std::uint16_t>();
      case PlyType::kInt32:
        return Load<std::int32_t>();
      case PlyType::kUint32:
        return Load<std::uint32_t>();
      case PlyType::kFloat32:
        return Load<float>();
      case PlyType::kFloat64:
        return Load<double>();
    }
    return 0.0;
  }

  template <typename T>
  double Load() {
    if (num_left() < sizeof(T)) Fail("ends before the elements of its header are complete");
    const ByteOrder order = encoding_ == PlyEncoding::kBigEndian ? ByteOrder::kBig : ByteOrder::kLittle;
    const T value = LoadNumber<T>(bytes_.data() + position_, order);
    position_ += sizeof(T);
    return static_cast<double>(value);
  }

  const std::string& path_;
  const PlyEncoding encoding_;
  const std::string_view bytes_;
  std::size_t position_;
  int line_;
};

class PlyReader {
 public:
  PlyReader(const std::string& path, std::string_view bytes, PlyUse use)
      : path_(path), use_(use), header_(ReadPlyHeader(path, bytes)), numbers_(path, bytes, header_) {}

  PolygonMesh Read() {
    bool has_vertices = false, has_faces = false;
    for (const PlyElement& element : header_.elements) {
      if (element.name == "vertex" && !std::exchange(has_vertices, true)) {
        ReadVertices(element);
      } else if (use_ == PlyUse::kMesh && element.name == "face" && !std::exchange(has_faces, true)) {
        ReadFaces(element);
      } else {
        for (std::uint64_t i = 0; !element.properties.empty() && i < element.count; ++i) ReadItem(element);
      }
    }
    numbers_.ExpectEnd();
    if (!has_vertices) Fail("has no element 'vertex'");
    const Eigen::Index num_vertices = mesh_.positions.cols();
    for (const int index : mesh_.corners) {
      if (index < num_vertices) continue;
      Fail("a face refers to vertex " + std::to_string(index) + "; expected 0 to " + std::to_string(num_vertices - 1));
    }
    return std::move(mesh_);
  }

 private:
  [[noreturn]] void Fail(const std::string& message) const { throw Error(ErrorKind::kBadData, path_ + ": " + message); }

  // Reads the values of one item: `values_` gets those that are single numbers, at the index of their property (0 for
  // lists), and `list_` the items of the property `wanted_list`.
  void ReadItem(const PlyElement& element, std::optional<std::size_t> wanted_list = std::nullopt) {
    values_.assign(element.properties.size(), 0.0);
    for (std::size_t i = 0; i < element.properties.size(); ++i) {
      const PlyProperty& property = element.properties[i];
      if (!property.count_type) {
        values_[i] = numbers_.Next(property.type);
        continue;
      }
      const double count = numbers_.Next(*property.count_type);
      if (!(count >= 0.0 && count <= static_cast<double>(numbers_.num_left()) && count == std::floor(count))) {
        numbers_.Fail("the length of '" + Printable(property.name) + "' is no count, or more than the file holds");
      }
      if (wanted_list == i) list_.clear();
      for (std::size_t k = static_cast<std::size_t>(count); k > 0; --k) {
        const double value = numbers_.Next(property.type);
        if (wanted_list == i) list_.push_back(value);
      }
    }
  }

  void ReadVertices(const PlyElement& element) {
    std::array<std::size_t, 3> axes;
    for (std::size_t k = 0; k < 3; ++k) {
      const std::optional<std::size_t> axis = element.Find(std::string_view("xyz").substr(k, 1), false);
      if (!axis) Fail("the element 'vertex' lacks the property '" + std::string(1, "xyz"[k]) + "'");
      axes[k] = *axis;
    }
    // A number takes at least a byte: no memory for more than the file can hold.
    if (element.count > kMaxNodes || 3 * element.count > numbers_.num_left()) {
      Fail(std::to_string(element.count) + " vertices are more than the file holds, or than the limit of " +
           std::to_string(kMaxNodes));
    }
    mesh_.positions.resize(3, static_cast<Eigen::Index>(element.count));
    for (Eigen::Index i = 0; i < mesh_.positions.cols(); ++i) {
      ReadItem(element);
      for (int k = 0; k < 3; ++k) {
        double value = values_[axes[static_cast<std::size_t>(k)]];
        if (std::isinf(value)) {
          if (use_ == PlyUse::kMesh) {
            numbers_.Fail("vertex " + std::to_string(i) + ": expected finite numbers, or NaN where it is not seen");
          }
          value = std::numeric_limits<double>::quiet_NaN();
        }
        mesh_.positions(k, i) = value;
      }
    }
  }

  void ReadFaces(const PlyElement& element) {
    std::optional<std::size_t> corners = element.Find("vertex_indices", true);
    if (!corners) corners = element.Find("vertex_index", true);
    for (std::uint64_t i = 0; !element.properties.empty() && i < element.count; ++i) {
      ReadItem(element, corners);
      if (corners) AppendPolygon();
    }
  }

  void AppendPolygon() {
    for (const double index : list_) {
      if (!(index >= 0.0 && index < kMaxNodes && index == std::floor(index))) {
        numbers_.Fail("expected the corners of a face to be indices of vertices");
      }
    }
    if (list_.size() < 3) numbers_.Fail("expected at least three corners of a face");
    if (mesh_.corners.size() + list_.size() - 2 * (mesh_.sizes.size() + 1) > kMaxFaces) {
      numbers_.Fail("more than " + std::to_string(kMaxFaces) + " triangles");
    }
    for (const double index : list_) mesh_.corners.push_back(static_cast<int>(index));
    mesh_.sizes.push_back(static_cast<int>(list_.size()));
    if (numbers_.line() > 0) mesh_.lines.push_back(numbers_.line());
  }

  const std::string& path_;
  const PlyUse use_;
  const PlyHeader header_;
  PlyNumbers numbers_;
  std::vector<double> values_, list_;
  PolygonMesh mesh_;
};

PolygonMesh ReadPlyFor(PlyUse use, const std::string& path) {
  const std::string bytes = ReadText(path, kMaxPlyBytes);
  return PlyReader(path, bytes, use).Read();
}

}  // namespace

PolygonMesh ReadPlyPolygons(const std::string& path) { return ReadPlyFor(PlyUse::kMesh, path); }

Mesh ReadPly(const std::string& path) {
  const PolygonMesh polygons = ReadPlyPolygons(path);
  Mesh mesh;
  mesh.faces = CutPolygons(path, polygons, polygons.positions.reshaped());
  mesh.rest_positions = polygons.positions;
  return mesh;
}

Eigen::Matrix3Xd ReadPlyPoints(const std::string& path) { return ReadPlyFor(PlyUse::kPoints, path).positions; }

std::string PlyBytes(const Eigen::Ref<const Eigen::Matrix3Xd>& positions, const Eigen::Matrix3Xi& faces) {
  std::string bytes = "ply\nformat binary_little_endian 1.0\nelement vertex " + std::to_string(positions.cols()) +
                      "\nproperty double x\nproperty double y\nproperty double z\n";
  if (faces.cols() > 0) {
    bytes += "element face " + std::to_string(faces.cols()) + "\nproperty list uchar int vertex_indices\n";
  }
  bytes += "end_header\n";
  for (const double value : positions.reshaped()) AppendLittleEndian(value, &bytes);
  for (const auto& face : faces.colwise()) {
    AppendLittleEndian(std::uint8_t{3}, &bytes);
    for (const int index : face) AppendLittleEndian(static_cast<std::int32_t>(index), &bytes);
  }
  return bytes;
}

}  // namespace clothid

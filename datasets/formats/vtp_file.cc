#include "datasets/formats/vtp_file.h"

#include <nettle/base64.h>

#include <cstdint>
#include <filesystem>
#include <vector>

#include "datasets/files/file_group.h"
#include "sim/base/byte_order.h"
#include "sim/base/frame_names.h"
#include "sim/base/text_file.h"

namespace clothid {
namespace {

namespace fs = std::filesystem;

constexpr char kXml[] = "<?xml version=\"1.0\"?>\n";

// A DataArray of format "binary": base64 of the number of bytes, as UInt64, and the bytes.
template <typename T>
std::string DataArray(const std::string& type, const std::string& attributes, const T* values, Eigen::Index count) {
  std::string bytes;
  AppendLittleEndian(static_cast<std::uint64_t>(static_cast<std::size_t>(count) * sizeof(T)), &bytes);
  bytes.append(reinterpret_cast<const char*>(values), static_cast<std::size_t>(count) * sizeof(T));
  std::string encoded(BASE64_ENCODE_RAW_LENGTH(bytes.size()), '\0');
  nettle_base64_encode_raw(encoded.data(), bytes.size(), reinterpret_cast<const std::uint8_t*>(bytes.data()));
  return "<DataArray type=\"" + type + "\" " + attributes + " format=\"binary\">" + encoded + "</DataArray>\n";
}

// Cells of `size` points each, whose indices follow each other.
std::string Cells(const std::string& name, const std::vector<std::int32_t>& points, std::int32_t size) {
  std::vector<std::int32_t> offsets;
  for (std::size_t end = static_cast<std::size_t>(size); end <= points.size(); end += static_cast<std::size_t>(size)) {
    offsets.push_back(static_cast<std::int32_t>(end));
  }
  return "<" + name + ">\n" +
         DataArray("Int32", "Name=\"connectivity\"", points.data(), static_cast<Eigen::Index>(points.size())) +
         DataArray("Int32", "Name=\"offsets\"", offsets.data(), static_cast<Eigen::Index>(offsets.size())) + "</" +
         name + ">\n";
}

std::string EscapedForXml(const std::string& text) {
  std::string escaped;
  for (const char c : text) {
    switch (c) {
      case '&':
        escaped += "&amp;";
        break;
      case '<':
        escaped += "&lt;";
        break;
      case '"':
        escaped += "&quot;";
        break;
      default:
        escaped += c;
    }
  }
  return escaped;
}

}  // namespace

std::string VtpText(const PointTracks& tracks, int frame) {
  const auto corners = tracks.faces.reshaped();
  std::vector<std::int32_t> indices(corners.begin(), corners.end());
  const bool has_faces = !indices.empty();
  for (int point = 0; !has_faces && point < tracks.num_points(); ++point) indices.push_back(point);
  const std::string num_points = std::to_string(tracks.num_points());
  const std::string num_faces = std::to_string(tracks.faces.cols());
  std::string text = kXml;
  text +=
      "<VTKFile type=\"PolyData\" version=\"1.0\" byte_order=\"LittleEndian\" header_type=\"UInt64\">\n<PolyData>\n";
  text += "<Piece NumberOfPoints=\"" + num_points + "\" NumberOfVerts=\"" + (has_faces ? "0" : num_points) +
          "\" NumberOfLines=\"0\" NumberOfStrips=\"0\" NumberOfPolys=\"" + num_faces + "\">\n<Points>\n";
  text += DataArray("Float64", "Name=\"Points\" NumberOfComponents=\"3\"", tracks.positions.col(frame).data(),
                    tracks.positions.rows());
  text += "</Points>\n";
  text += has_faces ? Cells("Polys", indices, 3) : Cells("Verts", indices, 1);
  return text + "</Piece>\n</PolyData>\n</VTKFile>\n";
}

void WriteVtpSeries(const PointTracks& tracks, const std::string& path) {
  const fs::path collection = fs::path(path).replace_extension(".pvd");
  // A '#' of the name itself is no number of a frame.
  const std::string stem = collection.stem().string();
  FileGroup group(collection.string());
  std::string text = kXml;
  text += "<VTKFile type=\"Collection\" version=\"0.1\" byte_order=\"LittleEndian\">\n<Collection>\n";
  for (int frame = 0; frame < tracks.num_frames(); ++frame) {
    const std::string name = stem + FrameName("_####.vtp", frame);
    const std::string time = tracks.times.size() > 0 ? ShortestText(tracks.times[frame]) : std::to_string(frame);
    group.Write(name, VtpText(tracks, frame));
    text += "<DataSet timestep=\"" + time + "\" group=\"\" part=\"0\" file=\"" + EscapedForXml(name) + "\"/>\n";
  }
  group.Write(collection.filename().string(), text + "</Collection>\n</VTKFile>\n");
  group.Commit();
}

}  // namespace clothid

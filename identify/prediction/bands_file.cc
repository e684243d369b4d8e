#include "identify/prediction/bands_file.h"

#include <zlib.h>

#include <cstdint>
#include <limits>

#include "sim/base/error.h"
#include "sim/base/npy_file.h"

namespace clothid {
namespace {

void AppendNumber(std::uint64_t value, int num_bytes, std::string* out) {
  for (int i = 0; i < num_bytes; ++i) out->push_back(static_cast<char>((value >> (8 * i)) & 0xff));
}

std::uint32_t Crc(const std::string& content) {
  return static_cast<std::uint32_t>(crc32_z(0, reinterpret_cast<const Bytef*>(content.data()), content.size()));
}

// What both headers of a file have in common: version, flags, method 0 (stored), the first day that ZIP knows, sizes.
std::string EntryFields(const std::string& name, const std::string& content) {
  constexpr std::uint64_t kVersion = 20, kFirstDay = 0x21;
  std::string fields;
  AppendNumber(kVersion, 2, &fields);
  AppendNumber(0, 2, &fields);
  AppendNumber(0, 2, &fields);
  AppendNumber(kFirstDay << 16, 4, &fields);
  AppendNumber(Crc(content), 4, &fields);
  AppendNumber(content.size(), 4, &fields);
  AppendNumber(content.size(), 4, &fields);
  AppendNumber(name.size(), 2, &fields);
  AppendNumber(0, 2, &fields);
  return fields;
}

std::string VectorBytes(const Eigen::VectorXd& values) {
  return NpyBytes(NpyArray{{values.size()}, {values.begin(), values.end()}});
}

// Of some motions [3N x T], one after another.
template <typename Motions>
std::string PositionsBytes(const Motions& motions) {
  const Eigen::Index num_frames = motions[0].cols(), num_rows = motions[0].rows();
  NpyArray array;
  array.shape = {static_cast<long long>(motions.size()), num_frames, num_rows / 3, 3};
  array.values.reserve(motions.size() * static_cast<std::size_t>(num_frames * num_rows));
  for (const Eigen::MatrixXd& motion : motions) {
    array.values.insert(array.values.end(), motion.reshaped().begin(), motion.reshaped().end());
  }
  return NpyBytes(array);
}

std::string DerivedBytes(const DerivedBands& bands) {
  const Eigen::Index num_rows = bands.quantiles[0].rows(), num_frames = bands.quantiles[0].cols();
  NpyArray array;
  array.shape = {static_cast<long long>(kBandQuantiles.size())};
  if (bands.request.kind != DerivedKind::kSlip) array.shape.push_back(num_frames);
  if (bands.request.kind == DerivedKind::kForce) array.shape.push_back(num_rows / 3);
  if (bands.request.kind == DerivedKind::kForce || bands.request.kind == DerivedKind::kPoint) array.shape.push_back(3);
  for (const Eigen::MatrixXd& quantile : bands.quantiles) {
    array.values.insert(array.values.end(), quantile.reshaped().begin(), quantile.reshaped().end());
  }
  return NpyBytes(array);
}

}  // namespace

std::string ArchiveBytes(const std::vector<std::pair<std::string, std::string>>& files) {
  std::string archive, directory;
  for (const auto& [name, content] : files) {
    ExpectUsage(archive.size() + content.size() < std::numeric_limits<std::uint32_t>::max() / 2,
                "--bands: expected less than 2 GB: a lower --frame_rate");
    const std::size_t offset = archive.size();
    const std::string fields = EntryFields(name, content);
    archive += "PK\3\4" + fields + name + content;
    directory += "PK\1\2";
    AppendNumber(20, 2, &directory);  // the version that wrote it
    directory += fields;
    directory.append(2 + 2 + 2 + 4, 0);  // comment, disk, attributes
    AppendNumber(offset, 4, &directory);
    directory += name;
  }
  const std::size_t offset = archive.size();
  archive += directory + "PK\5\6";
  AppendNumber(0, 4, &archive);
  AppendNumber(files.size(), 2, &archive);
  AppendNumber(files.size(), 2, &archive);
  AppendNumber(directory.size(), 4, &archive);
  AppendNumber(offset, 4, &archive);
  AppendNumber(0, 2, &archive);
  return archive;
}

std::string BandsNpz(const Prediction& prediction, const FitPosterior& posterior, bool with_draws) {
  const Eigen::Map<const Eigen::VectorXd> quantiles(kBandQuantiles.data(), kBandQuantiles.size());
  std::vector<std::pair<std::string, std::string>> files = {
      {"times.npy", VectorBytes(prediction.times)},
      {"quantiles.npy", VectorBytes(quantiles)},
      {"positions.npy", PositionsBytes(prediction.quantiles)},
      {"spread.npy", VectorBytes(prediction.spread)},
      {"moved.npy", VectorBytes(prediction.moved)},
      {"share_parameters.npy", VectorBytes(prediction.shares.parameters)},
      {"share_finer.npy", VectorBytes(prediction.shares.finer)},
      {"share_start.npy", VectorBytes(prediction.shares.start)},
      {"share_handles.npy", VectorBytes(prediction.shares.handles)},
      {"share_rest.npy", VectorBytes(prediction.shares.rest)}};
  for (std::size_t i = 0; i < posterior.parameters.size(); ++i) {
    files.emplace_back("share_" + posterior.parameters[i].name + ".npy",
                       VectorBytes(prediction.shares.each.col(static_cast<Eigen::Index>(i))));
  }
  for (const DerivedBands& bands : prediction.derived) {
    files.emplace_back(bands.request.name + ".npy", DerivedBytes(bands));
  }
  if (with_draws) files.emplace_back("draws.npy", PositionsBytes(prediction.cloths));
  return ArchiveBytes(files);
}

}  // namespace clothid

#include "identify/report/packed_array.h"

#include <zlib.h>

#include <algorithm>
#include <cmath>
#include <stdexcept>

namespace clothid {
namespace {

constexpr double kLargestWord = 65534.0;

std::string Base64(const std::vector<unsigned char>& bytes) {
  static constexpr char kLetters[] = "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
  std::string text;
  text.reserve((bytes.size() + 2) / 3 * 4);
  for (std::size_t i = 0; i < bytes.size(); i += 3) {
    const std::size_t count = std::min<std::size_t>(3, bytes.size() - i);
    unsigned group = 0;
    for (std::size_t k = 0; k < 3; ++k) group = group << 8 | (k < count ? bytes[i + k] : 0u);
    for (std::size_t k = 0; k < 4; ++k) text += k <= count ? kLetters[group >> (18 - 6 * k) & 63] : '=';
  }
  return text;
}

// 0, -1, 1, -2, .. to 0, 1, 2, 3, ..
std::uint16_t ZigZag(std::int16_t change) {
  return static_cast<std::uint16_t>(static_cast<std::uint16_t>(change) << 1 ^ (change < 0 ? 0xffff : 0));
}

}  // namespace

std::string PackBytes(std::string_view bytes) {
  uLongf size = compressBound(static_cast<uLong>(bytes.size()));
  std::vector<unsigned char> packed(size);
  const int status = compress2(packed.data(), &size, reinterpret_cast<const Bytef*>(bytes.data()),
                               static_cast<uLong>(bytes.size()), Z_DEFAULT_COMPRESSION);
  if (status != Z_OK) throw std::runtime_error("zlib cannot compress an array");
  packed.resize(size);
  return Base64(packed);
}

std::string PackMagnitudes(const Eigen::VectorXd& values, double largest) {
  constexpr double kDecades = 6.0, kLargestByte = 254.0;
  std::string bytes;
  bytes.reserve(static_cast<std::size_t>(values.size()));
  for (const double value : values) {
    const double q = kLargestByte * (1.0 + std::log10(value / largest) / kDecades);  // -inf for 0
    bytes +=
        std::isnan(value) ? '\xff' : static_cast<char>(static_cast<unsigned char>(std::clamp(q, 0.0, kLargestByte)));
  }
  return PackBytes(bytes);
}

PositionGrid GridOver(const Eigen::AlignedBox3d& box) {
  const double extent = box.sizes().maxCoeff();
  return {box.min(), extent > 0.0 ? extent / kLargestWord : 1.0};
}

GridPositions Quantize(const PositionGrid& grid, const Eigen::MatrixXd& positions, const std::vector<int>& frames) {
  const Eigen::Index num_points = positions.rows() / 3;
  GridPositions quantized(positions.rows(), static_cast<Eigen::Index>(frames.size()));
  for (std::size_t f = 0; f < frames.size(); ++f) {
    for (Eigen::Index p = 0; p < num_points; ++p) {
      const Eigen::Array3d q = ((positions.block<3, 1>(3 * p, frames[f]) - grid.origin) / grid.step).array().round();
      const bool is_inside = (q >= 0.0).all() && (q <= kLargestWord).all();  // false for NaN
      for (int axis = 0; axis < 3; ++axis) {
        quantized(3 * p + axis, static_cast<Eigen::Index>(f)) =
            is_inside ? static_cast<std::uint16_t>(q[axis]) : kUnseenCoordinate;
      }
    }
  }
  return quantized;
}

std::string PackPositions(const GridPositions& positions) {
  const std::size_t count = static_cast<std::size_t>(positions.size());
  std::string bytes(2 * count, '\0');
  std::vector<std::uint16_t> last(static_cast<std::size_t>(positions.rows()), 0);
  std::size_t i = 0;
  for (Eigen::Index frame = 0; frame < positions.cols(); ++frame) {
    for (Eigen::Index row = 0; row < positions.rows(); ++row, ++i) {
      std::uint16_t code = kUnseenCoordinate;
      if (positions(row, frame) != kUnseenCoordinate) {
        std::uint16_t& before = last[static_cast<std::size_t>(row)];
        code = ZigZag(static_cast<std::int16_t>(positions(row, frame) - before));
        // The one change whose code is taken by "not seen": off by one step instead, within 0 .. 65534.
        if (code == kUnseenCoordinate) code = positions(row, frame) > 0 ? 65534 : 65533;
        before = static_cast<std::uint16_t>(before + ((code >> 1) ^ (code & 1 ? 0xffff : 0)));
      }
      bytes[i] = static_cast<char>(code & 0xff);
      bytes[count + i] = static_cast<char>(code >> 8);
    }
  }
  return PackBytes(bytes);
}

}  // namespace clothid

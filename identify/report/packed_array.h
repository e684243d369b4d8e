// Large arrays as text inside of a page: 16 bits per coordinate, compressed with zlib, in base64.
#ifndef CLOTHID_IDENTIFY_REPORT_PACKED_ARRAY_H_
#define CLOTHID_IDENTIFY_REPORT_PACKED_ARRAY_H_

#include <Eigen/Core>
#include <Eigen/Geometry>
#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

namespace clothid {

// The zlib stream of `bytes` in base64, which `DecompressionStream('deflate')` of a browser reads.
std::string PackBytes(std::string_view bytes);

// position = origin + step q,  q = 0, 1, .., 65534 per coordinate: off by at most step/2.
struct PositionGrid {
  Eigen::Vector3d origin = Eigen::Vector3d::Zero();  // m
  double step = 1.0;                                 // m
};

// The finest grid that covers `box`, which must not be empty.
PositionGrid GridOver(const Eigen::AlignedBox3d& box);

// Values >= 0 in a byte each, through `PackBytes`: q stands for largest 10^(-6 (1 - q/254)), 0 for all that is less,
// 255 for NaN. No value is above `largest`.
std::string PackMagnitudes(const Eigen::VectorXd& values, double largest);

// Quantised positions; a point that is not seen, or lies outside of the grid, has kUnseenCoordinate in all coordinates.
inline constexpr std::uint16_t kUnseenCoordinate = 65535;
using GridPositions = Eigen::Matrix<std::uint16_t, Eigen::Dynamic, Eigen::Dynamic>;

// The columns `frames` of `positions` [3K x T] m: [3K x frames].
GridPositions Quantize(const PositionGrid& grid, const Eigen::MatrixXd& positions, const std::vector<int>& frames);

// Each coordinate as its change, modulo 65536, since the frame in which it was last seen (at first: since 0), in the
// order of the columns, 0, -1, 1, -2, .. as 0, 1, 2, 3, ..; 65535 is "not seen", so that a change by 32768 comes out
// off by one. All low bytes, then all high ones, through `PackBytes`.
std::string PackPositions(const GridPositions& positions);

}  // namespace clothid

#endif  // CLOTHID_IDENTIFY_REPORT_PACKED_ARRAY_H_

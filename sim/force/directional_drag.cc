#include "sim/force/directional_drag.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numeric>
#include <utility>

#include "sim/force/air_drag.h"
#include "sim/force/normal_slope.h"

namespace clothid {

// What a solve holds of a batch of triangles: n, and w at their centres, m/s.
struct alignas(64) AirBatch {
  double normal[3][kLanes];
  double wind[3][kLanes];
};

struct DragConstants {
  double normal = 0.0, tangential = 0.0;  // c_n and c_t: kg/(m^2 s), or kg/m^3 where the law is quadratic
};

namespace {

// The kernels have no clones for other instruction sets, as those of strain_rate_damping.cc.

// In one lane, with u_t and s as in the header.
struct Flow {
  double along;            // s
  double tangential[3];    // u_t
  double tangential_size;  // |u_t|
};

CLOTHID_ALWAYS_INLINE Flow FlowOf(const AirBatch& air, const CornerVectors& v, int lane) {
  Flow flow;
  flow.along = 0.0;
  for (int c = 0; c < 3; ++c) {
    flow.tangential[c] =
        air.wind[c][lane] - (v.values[0][c][lane] + v.values[1][c][lane] + v.values[2][c][lane]) * (1.0 / 3.0);
    flow.along += flow.tangential[c] * air.normal[c][lane];
  }
  double square = 0.0;
  for (int c = 0; c < 3; ++c) {
    flow.tangential[c] -= flow.along * air.normal[c][lane];
    square += flow.tangential[c] * flow.tangential[c];
  }
  flow.tangential_size = std::sqrt(square);
  return flow;
}

// Adds D to `potentials` [kLanes].
template <AirLaw law>
void DragForces(const TriangleBatch& __restrict__ batch, const AirBatch& __restrict__ air,
                const CornerVectors& __restrict__ v, DragConstants constants, CornerVectors* __restrict__ forces,
                double* __restrict__ potentials) {
  constexpr bool quadratic = law == AirLaw::kQuadratic;
  for (int lane = 0; lane < kLanes; ++lane) {
    const Flow flow = FlowOf(air, v, lane);
    const double s = flow.along, size = flow.tangential_size;
    const double normal = batch.area[lane] * constants.normal * (quadratic ? std::abs(s) : 1.0) * s;
    const double tangential = batch.area[lane] * constants.tangential * (quadratic ? size : 1.0);
    potentials[lane] += (quadratic ? 1.0 / 3.0 : 0.5) * (normal * s + tangential * size * size);
    for (int c = 0; c < 3; ++c) {
      const double third = (normal * air.normal[c][lane] + tangential * flow.tangential[c]) * (1.0 / 3.0);
      for (int corner = 0; corner < 3; ++corner) forces->values[corner][c][lane] = third;
    }
  }
}

// df/du = B = p n n^T + q (I - n n^T) + r u_t u_t^T, symmetric, by columns.
struct alignas(64) FlowBlocks {
  double values[9][kLanes];
};

template <AirLaw law>
void DragBlocks(const TriangleBatch& __restrict__ batch, const AirBatch& __restrict__ air,
                const CornerVectors& __restrict__ v, DragConstants constants, FlowBlocks* __restrict__ blocks) {
  constexpr bool quadratic = law == AirLaw::kQuadratic;
  for (int lane = 0; lane < kLanes; ++lane) {
    const Flow flow = FlowOf(air, v, lane);
    const double size = flow.tangential_size;
    const double c_n = batch.area[lane] * constants.normal, c_t = batch.area[lane] * constants.tangential;
    const double p = quadratic ? 2.0 * c_n * std::abs(flow.along) : c_n;
    const double q = quadratic ? c_t * size : c_t;
    const double r = quadratic ? c_t / std::max(size, std::numeric_limits<double>::min()) : 0.0;
    for (int column = 0; column < 3; ++column) {
      for (int row = 0; row < 3; ++row) {
        blocks->values[3 * column + row][lane] = (p - q) * (air.normal[row][lane] * air.normal[column][lane]) +
                                                 r * (flow.tangential[row] * flow.tangential[column]) +
                                                 (row == column ? q : 0.0);
      }
    }
  }
}

void FillBlocks(AirLaw law, const TriangleBatch& batch, const AirBatch& air, const CornerVectors& v,
                const DragConstants& constants, FlowBlocks* blocks) {
  if (law == AirLaw::kQuadratic) {
    DragBlocks<AirLaw::kQuadratic>(batch, air, v, constants, blocks);
  } else {
    DragBlocks<AirLaw::kLinear>(batch, air, v, constants, blocks);
  }
}

Eigen::Matrix3d BlockAt(const FlowBlocks& blocks, int lane) {
  Eigen::Matrix3d block;
  for (int k = 0; k < 9; ++k) block(k % 3, k / 3) = blocks.values[k][lane];
  return block;
}

void SetNormals(const CornerVectors& __restrict__ x, AirBatch* __restrict__ air) {
  for (int lane = 0; lane < kLanes; ++lane) {
    double e1[3], e2[3], m[3];
    for (int c = 0; c < 3; ++c) {
      e1[c] = x.values[1][c][lane] - x.values[0][c][lane];
      e2[c] = x.values[2][c][lane] - x.values[0][c][lane];
    }
    for (int c = 0; c < 3; ++c) m[c] = e1[(c + 1) % 3] * e2[(c + 2) % 3] - e1[(c + 2) % 3] * e2[(c + 1) % 3];
    const double size = std::sqrt(m[0] * m[0] + m[1] * m[1] + m[2] * m[2]);
    const double inverse = 1.0 / std::max(size, std::numeric_limits<double>::min());
    for (int c = 0; c < 3; ++c) air->normal[c][lane] = inverse * m[c];
  }
}

NormalSlope SlopeOf(AirLaw law, const DragConstants& constants, const TriangleBatch& batch, const AirBatch& air,
                    int lane, const Eigen::VectorXd& velocities, const Eigen::VectorXd& positions) {
  const Eigen::Vector3d normal(air.normal[0][lane], air.normal[1][lane], air.normal[2][lane]);
  const Eigen::Vector3d wind(air.wind[0][lane], air.wind[1][lane], air.wind[2][lane]);
  return NormalSlope(law, batch.area[lane] * constants.normal, batch.area[lane] * constants.tangential, batch, lane,
                     normal, wind - CornerMean(batch, lane, velocities.data()), positions);
}

// c_n and c_t.
DragConstants DragConstantsOf(const Material& material) { return {material.normal_drag, material.tangential_drag}; }

struct HeldAir final : HeldForce {
  std::vector<AirBatch> air;
};

const std::vector<AirBatch>& AirOf(const HeldForce* held) { return static_cast<const HeldAir*>(held)->air; }

}  // namespace

DirectionalDrag::DirectionalDrag(AirLaw law, std::vector<RestPlace> places,
                                 std::shared_ptr<const TriangleElements> triangles, const std::vector<int>& free_index,
                                 const BlockPattern& pattern)
    : law_(law), nodes_(std::move(places)), triangles_(std::move(triangles)), places_(triangles_->size()) {
  for (std::size_t b = 0; b < triangles_->size(); ++b) {
    const TriangleBatch& batch = (*triangles_)[b];
    for (int lane = 0; lane < kLanes; ++lane) {
      for (int i = 0; i < 3; ++i) {
        const RestPlace& corner = nodes_[batch.rows[i][lane] / 3];
        places_[b].centers[lane].position += corner.position / 3.0;
        places_[b].centers[lane].from_center += corner.from_center / 3.0;
        for (int j = 0; j < 3; ++j) {
          const int row = free_index[batch.rows[i][lane] / 3], column = free_index[batch.rows[j][lane] / 3];
          if (batch.area[lane] > 0.0 && row >= 0 && column >= 0) {
            places_[b].blocks[i][j][lane] = pattern.Find(row, column);
          }
        }
      }
    }
  }
}

void DirectionalDrag::Hold(const Parameters& parameters, double time, const ForceStart& start,
                           std::unique_ptr<HeldForce>* held) const {
  if (*held == nullptr) *held = std::make_unique<HeldAir>();
  std::vector<AirBatch>& air = static_cast<HeldAir*>(held->get())->air;
  air.resize(triangles_->size());
  CornerVectors x;
  for (std::size_t b = 0; b < triangles_->size(); ++b) {
    GatherCorners((*triangles_)[b], start.predicted.data(), &x);
    SetNormals(x, &air[b]);
    for (int lane = 0; lane < kLanes; ++lane) {
      const Eigen::Vector3d velocity = parameters.wind.At(time, places_[b].centers[lane]);
      for (int c = 0; c < 3; ++c) air[b].wind[c][lane] = velocity[c];
    }
  }
}

double DirectionalDrag::AddForceOf(const DragConstants& constants, const Eigen::VectorXd& velocities,
                                   const std::vector<AirBatch>& air, Eigen::VectorXd* force) const {
  CornerVectors v, forces;
  double potentials[kLanes] = {};
  for (std::size_t b = 0; b < triangles_->size(); ++b) {
    const TriangleBatch& batch = (*triangles_)[b];
    GatherCorners(batch, velocities.data(), &v);
    if (law_ == AirLaw::kQuadratic) {
      DragForces<AirLaw::kQuadratic>(batch, air[b], v, constants, &forces, potentials);
    } else {
      DragForces<AirLaw::kLinear>(batch, air[b], v, constants, &forces, potentials);
    }
    AddCorners(batch, forces, force->data());
  }
  return std::accumulate(potentials, potentials + kLanes, 0.0);
}

void DirectionalDrag::AddVelocityHessian(double factor, const ForcePoint& point, const HeldForce* held,
                                         BlockMatrix* hessian) const {
  const DragConstants constants = DragConstantsOf(point.parameters.material);
  const std::vector<AirBatch>& air = AirOf(held);
  CornerVectors v;
  FlowBlocks blocks;
  for (std::size_t b = 0; b < triangles_->size(); ++b) {
    GatherCorners((*triangles_)[b], point.velocities.data(), &v);
    FillBlocks(law_, (*triangles_)[b], air[b], v, constants, &blocks);
    for (int lane = 0; lane < kLanes; ++lane) {
      const Eigen::Matrix3d block = (factor / 9.0) * BlockAt(blocks, lane);
      for (const auto& row : places_[b].blocks) {
        for (const auto& position : row) {
          if (position[lane].valid()) hessian->block(position[lane]) += block;
        }
      }
    }
  }
}

void DirectionalDrag::AddVelocityProduct(double factor, const ForcePoint& point, const HeldForce* held,
                                         const Eigen::MatrixXd& columns, Eigen::MatrixXd* product) const {
  const DragConstants constants = DragConstantsOf(point.parameters.material);
  const std::vector<AirBatch>& air = AirOf(held);
  CornerVectors v;
  FlowBlocks blocks;
  for (std::size_t b = 0; b < triangles_->size(); ++b) {
    const TriangleBatch& batch = (*triangles_)[b];
    GatherCorners(batch, point.velocities.data(), &v);
    FillBlocks(law_, batch, air[b], v, constants, &blocks);
    for (int lane = 0; lane < kLanes; ++lane) {
      const Eigen::Matrix3d block = (factor / 3.0) * BlockAt(blocks, lane);
      for (Eigen::Index c = 0; c < columns.cols(); ++c) {
        const Eigen::Vector3d third = block * CornerMean(batch, lane, columns.col(c).data());
        for (int i = 0; i < 3; ++i) product->col(c).segment<3>(batch.rows[i][lane]) += third;
      }
    }
  }
}

void DirectionalDrag::AddPredictionProduct(double factor, const ForcePoint& point, const HeldForce* held,
                                           const Eigen::VectorXd& predicted, const Eigen::MatrixXd& columns,
                                           Eigen::MatrixXd* product) const {
  const DragConstants constants = DragConstantsOf(point.parameters.material);
  const std::vector<AirBatch>& air = AirOf(held);
  for (std::size_t b = 0; b < triangles_->size(); ++b) {
    const TriangleBatch& batch = (*triangles_)[b];
    for (int lane = 0; lane < kLanes && batch.area[lane] > 0.0; ++lane) {
      const NormalSlope slope = SlopeOf(law_, constants, batch, air[b], lane, point.velocities, predicted);
      for (Eigen::Index c = 0; c < columns.cols(); ++c) {
        const Eigen::Vector3d third = (factor / 3.0) * slope.Times(columns.col(c).data());
        for (int i = 0; i < 3; ++i) product->col(c).segment<3>(batch.rows[i][lane]) += third;
      }
    }
  }
}

void DirectionalDrag::AddPredictionProductTransposed(double factor, const ForcePoint& point, const HeldForce* held,
                                                     const Eigen::VectorXd& predicted, const Eigen::MatrixXd& columns,
                                                     Eigen::MatrixXd* product) const {
  const DragConstants constants = DragConstantsOf(point.parameters.material);
  const std::vector<AirBatch>& air = AirOf(held);
  for (std::size_t b = 0; b < triangles_->size(); ++b) {
    const TriangleBatch& batch = (*triangles_)[b];
    for (int lane = 0; lane < kLanes && batch.area[lane] > 0.0; ++lane) {
      const NormalSlope slope = SlopeOf(law_, constants, batch, air[b], lane, point.velocities, predicted);
      for (Eigen::Index c = 0; c < columns.cols(); ++c) {
        slope.AddTransposed(factor * CornerMean(batch, lane, columns.col(c).data()), product->col(c).data());
      }
    }
  }
}

void DirectionalDrag::AddWindDerivative(ParameterId id, double factor, const ForcePoint& point,
                                        const std::vector<AirBatch>& air, Eigen::VectorXd* force) const {
  const DragConstants constants = DragConstantsOf(point.parameters.material);
  CornerVectors v;
  FlowBlocks blocks;
  for (std::size_t b = 0; b < triangles_->size(); ++b) {
    const TriangleBatch& batch = (*triangles_)[b];
    GatherCorners(batch, point.velocities.data(), &v);
    FillBlocks(law_, batch, air[b], v, constants, &blocks);
    for (int lane = 0; lane < kLanes; ++lane) {
      const Eigen::Vector3d third = (factor / 3.0) * BlockAt(blocks, lane) *
                                    WindDerivative(point.parameters.wind, id, point.time, places_[b].centers[lane]);
      for (int i = 0; i < 3; ++i) force->segment<3>(batch.rows[i][lane]) += third;
    }
  }
}

double DirectionalDrag::AddForce(const ForcePoint& point, const HeldForce* held, Eigen::VectorXd* force) const {
  const DragConstants constants = DragConstantsOf(point.parameters.material);
  return point.time_step * AddForceOf(constants, point.velocities, AirOf(held), force);
}

void DirectionalDrag::AddDerivative(ParameterId id, double factor, const ForcePoint& point, const HeldForce* held,
                                    Eigen::VectorXd* force) const {
  const ParameterTerm term = RowOf(id.kind).term;
  if (term == ParameterTerm::kWind) {
    AddWindDerivative(id, factor, point, AirOf(held), force);
  } else if (term == ParameterTerm::kDirectionalDrag) {
    // The force is linear in its constants.
    Eigen::VectorXd unit = Eigen::VectorXd::Zero(force->size());
    const bool is_normal = id.kind == ParameterKind::kNormalDrag;
    AddForceOf({is_normal ? 1.0 : 0.0, is_normal ? 0.0 : 1.0}, point.velocities, AirOf(held), &unit);
    *force += factor * unit;
  }
}

std::unique_ptr<ForceTerm> DirectionalDrag::PartOf(const ForcePart& part) const {
  std::vector<RestPlace> places;
  for (const int node : part.nodes) places.push_back(nodes_[node]);
  return std::make_unique<DirectionalDrag>(law_, std::move(places), part.triangles, part.blocks, *part.pattern);
}

}  // namespace clothid

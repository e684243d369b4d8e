#include "sim/shell/strain_rate_damping.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numeric>

namespace clothid {
namespace {

// The kernels have no clones for other instruction sets (vector_clones.h): choosing one is work at the start of every
// program, also of those whose scene has no damping.

// C of the triangles in a batch.
void TriangleMetrics(const TriangleBatch& __restrict__ batch, const CornerVectors& __restrict__ x,
                     MetricBatch* __restrict__ metrics) {
  for (int lane = 0; lane < kLanes; ++lane) {
    const Symmetric2 c = Metric(DeformationGradient(batch, x, lane));
    metrics->values[0][lane] = c.m00;
    metrics->values[1][lane] = c.m01;
    metrics->values[2][lane] = c.m11;
  }
}

// Edot over a step of size `time_step` that starts with the metric of `start`.
CLOTHID_ALWAYS_INLINE Symmetric2 StrainRate(const Gradient& f, const MetricBatch& start, double time_step, int lane) {
  const Symmetric2 c = Metric(f);
  const double scale = 0.5 / time_step;
  return {scale * (c.m00 - start.values[0][lane]), scale * (c.m01 - start.values[1][lane]),
          scale * (c.m11 - start.values[2][lane])};
}

// Adds W/eta = h a/2 |Edot|^2 to `potentials` [kLanes]; the forces are -eta a F Edot g_i.
void DampingForces(const TriangleBatch& __restrict__ batch, const CornerVectors& __restrict__ x,
                   const MetricBatch& __restrict__ start, double damping, double time_step,
                   CornerVectors* __restrict__ forces, double* __restrict__ potentials) {
  for (int lane = 0; lane < kLanes; ++lane) {
    const Gradient f = DeformationGradient(batch, x, lane);
    const Symmetric2 rate = StrainRate(f, start, time_step, lane);
    const double square = rate.m00 * rate.m00 + 2.0 * rate.m01 * rate.m01 + rate.m11 * rate.m11;
    potentials[lane] += 0.5 * time_step * batch.area[lane] * square;
    SetCornerForces(batch, -damping * batch.area[lane], Times(f, rate), lane, forces);
  }
}

// With w = eta a:  d2W/(dx_i dx_j) = w (g_i . Edot g_j) I + w/(2 h) ((g_i . g_j) F F^T + (F g_j) (F g_i)^T).
template <HessianKind kind>
CLOTHID_ALWAYS_INLINE void SetDampingBlocks(const TriangleBatch& batch, const CornerVectors& x,
                                            const MetricBatch& start, double damping, double time_step, int lane,
                                            CornerBlocks* blocks) {
  const Gradient f = DeformationGradient(batch, x, lane);
  Symmetric2 rate = StrainRate(f, start, time_step, lane);
  if (kind == HessianKind::kClamped) rate = ClampEigenvalues(rate, 0.0, std::numeric_limits<double>::infinity());
  const double weight = damping * batch.area[lane], slope = 0.5 * weight / time_step;
  const ShapeGradients g = AllShapeGradients(batch, lane);
  const double(&f0)[3] = f.column[0];
  const double(&f1)[3] = f.column[1];
  double turned[3][3];  // F g_i
  for (int i = 0; i < 3; ++i) {
    for (int c = 0; c < 3; ++c) turned[i][c] = f0[c] * g.corner[i][0] + f1[c] * g.corner[i][1];
  }
  for (int pair = 0; pair < 3; ++pair) {
    const int i = kCornerPairs[pair][0], j = kCornerPairs[pair][1];
    const double stress = weight * Product(g.corner[i], rate, g.corner[j]);
    const double product = slope * (g.corner[i][0] * g.corner[j][0] + g.corner[i][1] * g.corner[j][1]);
    for (int column = 0; column < 3; ++column) {
      for (int row = 0; row < 3; ++row) {
        blocks->values[pair][3 * column + row][lane] = (row == column ? stress : 0.0) +
                                                       product * (f0[row] * f0[column] + f1[row] * f1[column]) +
                                                       slope * turned[j][row] * turned[i][column];
      }
    }
  }
}

void DampingBlocks(const TriangleBatch& __restrict__ batch, const CornerVectors& __restrict__ x,
                   const MetricBatch& __restrict__ start, double damping, double time_step,
                   CornerBlocks* __restrict__ blocks) {
  for (int lane = 0; lane < kLanes; ++lane) {
    SetDampingBlocks<HessianKind::kExact>(batch, x, start, damping, time_step, lane, blocks);
  }
}

void ClampedDampingBlocks(const TriangleBatch& __restrict__ batch, const CornerVectors& __restrict__ x,
                          const MetricBatch& __restrict__ start, double damping, double time_step,
                          CornerBlocks* __restrict__ blocks) {
  for (int lane = 0; lane < kLanes; ++lane) {
    SetDampingBlocks<HessianKind::kClamped>(batch, x, start, damping, time_step, lane, blocks);
  }
}

// d2(W/eta)/(dx_i dx_n,j) = -a/(2 h) [(g_i . g_j) F F_n^T + (F g_j) (F_n g_i)^T]: with dF = sum y_j g_j^T, the rows of
// node i in its product with y are -a/(2 h) F (dF^T F_n + F_n^T dF) g_i.
void MixedProducts(const TriangleBatch& __restrict__ batch, const CornerVectors& __restrict__ x,
                   const CornerVectors& __restrict__ start, const CornerVectors& __restrict__ y, double damping,
                   double time_step, CornerVectors* __restrict__ products) {
  for (int lane = 0; lane < kLanes; ++lane) {
    const Gradient start_gradient = DeformationGradient(batch, start, lane), df = DeformationGradient(batch, y, lane);
    const double(&n0)[3] = start_gradient.column[0];
    const double(&n1)[3] = start_gradient.column[1];
    Symmetric2 change = {0.0, 0.0, 0.0};
    for (int c = 0; c < 3; ++c) {
      change.m00 += 2.0 * n0[c] * df.column[0][c];
      change.m01 += n0[c] * df.column[1][c] + n1[c] * df.column[0][c];
      change.m11 += 2.0 * n1[c] * df.column[1][c];
    }
    SetCornerForces(batch, -0.5 * damping * batch.area[lane] / time_step,
                    Times(DeformationGradient(batch, x, lane), change), lane, products);
  }
}

}  // namespace

void StrainRateDamping::SetMetrics(const std::vector<StrainOrigin>& origins, std::vector<MetricBatch>* metrics) const {
  metrics->resize(triangles_->size());
  CornerVectors x;
  MetricBatch other;
  for (size_t b = 0; b < triangles_->size(); ++b) {
    const TriangleBatch& batch = (*triangles_)[b];
    GatherCorners(batch, origins[0].positions->data(), &x);
    TriangleMetrics(batch, x, &(*metrics)[b]);
    const MetricBatch first = (*metrics)[b];
    for (size_t k = 1; k < origins.size(); ++k) {
      GatherCorners(batch, origins[k].positions->data(), &x);
      TriangleMetrics(batch, x, &other);
      for (int i = 0; i < 3; ++i) {
        for (int lane = 0; lane < kLanes; ++lane) {
          (*metrics)[b].values[i][lane] += origins[k].share * (other.values[i][lane] - first.values[i][lane]);
        }
      }
    }
  }
}

double StrainRateDamping::AddForce(double damping, double time_step, const std::vector<MetricBatch>& start_metrics,
                                   const Eigen::VectorXd& positions, Eigen::VectorXd* force) const {
  CornerVectors x, forces;
  double potentials[kLanes] = {};
  for (size_t b = 0; b < triangles_->size(); ++b) {
    const TriangleBatch& batch = (*triangles_)[b];
    GatherCorners(batch, positions.data(), &x);
    DampingForces(batch, x, start_metrics[b], damping, time_step, &forces, potentials);
    AddCorners(batch, forces, force->data());
  }
  return std::accumulate(potentials, potentials + kLanes, 0.0);
}

void StrainRateDamping::AddHessian(double damping, double time_step, HessianKind kind,
                                   const std::vector<MetricBatch>& start_metrics, const Eigen::VectorXd& positions,
                                   BlockMatrix* hessian, ThreadTeam* team) const {
  const auto fill = [&](std::size_t b, CornerBlocks* blocks) {
    const TriangleBatch& batch = (*triangles_)[b];
    CornerVectors x;
    GatherCorners(batch, positions.data(), &x);
    if (kind == HessianKind::kExact) {
      DampingBlocks(batch, x, start_metrics[b], damping, time_step, blocks);
    } else {
      ClampedDampingBlocks(batch, x, start_metrics[b], damping, time_step, blocks);
    }
  };
  AddAllBlocks(*triangles_, team, fill, hessian);
}

void StrainRateDamping::AddMixedProduct(double damping, double time_step, const Eigen::VectorXd& positions,
                                        const Eigen::VectorXd& start_positions, const Eigen::MatrixXd& columns,
                                        Eigen::MatrixXd* product) const {
  CornerVectors x, start, y, products;
  for (const TriangleBatch& batch : *triangles_) {
    GatherCorners(batch, positions.data(), &x);
    GatherCorners(batch, start_positions.data(), &start);
    for (Eigen::Index c = 0; c < columns.cols(); ++c) {
      GatherCorners(batch, columns.col(c).data(), &y);
      MixedProducts(batch, x, start, y, damping, time_step, &products);
      AddCorners(batch, products, product->col(c).data());
    }
  }
}

}  // namespace clothid

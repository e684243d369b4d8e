#include "sim/shell/yarn_energy.h"

#include <algorithm>
#include <cmath>
#include <limits>

namespace clothid {
namespace {

constexpr double kSmall = 1e-2;  // b e below which series take the place of differences

// psi, psi', psi'' and dpsi'/db at a strain.
struct Response {
  double energy, stress, slope, by_stiffening;
};

// With z = b e: psi = e^2 (exp(z) - 1 - z)/z^2, dpsi'/db = e^2 (z exp(z) - exp(z) + 1)/z^2.
Response ResponseAt(double strain, double stiffening) {
  if (strain <= 0.0 || stiffening == 0.0) {
    const double square = strain * strain;
    return {0.5 * square, strain, 1.0, strain > 0.0 ? 0.5 * square : 0.0};
  }
  const double z = stiffening * strain, growth = std::expm1(z), square = strain * strain;
  double energy, by_stiffening;
  if (z < kSmall) {
    energy = 0.5 + z * (1.0 / 6.0 + z * (1.0 / 24.0 + z * (1.0 / 120.0 + z / 720.0)));
    by_stiffening = 0.5 + z * (1.0 / 3.0 + z * (1.0 / 8.0 + z * (1.0 / 30.0 + z / 144.0)));
  } else {
    energy = (growth - z) / (z * z);
    by_stiffening = (z * (growth + 1.0) - growth) / (z * z);
  }
  return {square * energy, growth / stiffening, growth + 1.0, square * by_stiffening};
}

// A triangle where it is.
struct Yarns {
  Eigen::Matrix<double, 3, 2> directions;  // u_k = f_k/|f_k|
  double length[2];                        // |f_k|
  double cosine;                           // gamma

  Yarns(const TriangleBatch& batch, const CornerVectors& x, int lane) {
    const Gradient f = DeformationGradient(batch, x, lane);
    for (int k = 0; k < 2; ++k) {
      const Eigen::Vector3d column(f.column[k][0], f.column[k][1], f.column[k][2]);
      length[k] = std::max(column.norm(), std::numeric_limits<double>::min());
      directions.col(k) = column / length[k];
    }
    cosine = directions.col(0).dot(directions.col(1));
  }

  double strain(int k) const { return length[k] - 1.0; }
  // |f_k| dgamma/df_k.
  Eigen::Vector3d Turn(int k) const { return directions.col(1 - k) - cosine * directions.col(k); }
};

// dE/df_k/a: along the yarn, and of its turning.
double Tension(const Yarns& yarns, const YarnConstants& constants, const Response& response, int k) {
  const double stiffness = k == 0 ? constants.k.c11 : constants.k.c22;
  return stiffness * response.stress + constants.k.c12 * yarns.strain(1 - k);
}

// -a dE/dF g_i of the corners, for the columns of `stress` dE/dF/a.
void SetForces(const TriangleBatch& batch, const Eigen::Matrix<double, 3, 2>& stress, int lane, CornerVectors* forces) {
  Gradient gradient;
  for (int k = 0; k < 2; ++k) {
    for (int c = 0; c < 3; ++c) gradient.column[k][c] = stress(c, k);
  }
  SetCornerForces(batch, -batch.area[lane], gradient, lane, forces);
}

// The forces at the corners where they are; returns E of the batch.
double YarnForces(const TriangleBatch& batch, const CornerVectors& x, const YarnConstants& constants,
                  CornerVectors* forces) {
  double energy = 0.0;
  for (int lane = 0; lane < kLanes; ++lane) {
    const Yarns yarns(batch, x, lane);
    const Response responses[2] = {ResponseAt(yarns.strain(0), constants.stiffening[0]),
                                   ResponseAt(yarns.strain(1), constants.stiffening[1])};
    Eigen::Matrix<double, 3, 2> stress;
    for (int k = 0; k < 2; ++k) {
      stress.col(k) = Tension(yarns, constants, responses[k], k) * yarns.directions.col(k) +
                      constants.k.c66 * yarns.cosine / yarns.length[k] * yarns.Turn(k);
    }
    energy += batch.area[lane] * (constants.k.c11 * responses[0].energy + constants.k.c22 * responses[1].energy +
                                  constants.k.c12 * yarns.strain(0) * yarns.strain(1) +
                                  0.5 * constants.k.c66 * yarns.cosine * yarns.cosine);
    SetForces(batch, stress, lane, forces);
  }
  return energy;
}

// d2E/(df_k df_l)/a.
Eigen::Matrix3d StiffnessBlock(const Yarns& yarns, const YarnConstants& constants, HessianKind kind,
                               const Response (&responses)[2], int k, int l) {
  const auto u_k = yarns.directions.col(k), u_l = yarns.directions.col(l);
  const double inverse = 1.0 / (yarns.length[k] * yarns.length[l]), shear = constants.k.c66;
  Eigen::Matrix3d block = shear * inverse * yarns.Turn(k) * yarns.Turn(l).transpose();
  const bool is_exact = kind == HessianKind::kExact;
  if (k == l) {
    const double tension = Tension(yarns, constants, responses[k], k) / yarns.length[k];
    const Eigen::Matrix3d across = Eigen::Matrix3d::Identity() - u_k * u_k.transpose();
    block += (k == 0 ? constants.k.c11 : constants.k.c22) * responses[k].slope * u_k * u_k.transpose() +
             (is_exact ? tension : std::max(tension, 0.0)) * across;
    if (!is_exact) return block;
    const Eigen::Matrix3d turn = yarns.Turn(k) * u_k.transpose();
    return block - shear * yarns.cosine * inverse * (turn + turn.transpose() + yarns.cosine * across);
  }
  block += constants.k.c12 * u_k * u_l.transpose();
  if (!is_exact) return block;
  const Eigen::Matrix3d across = Eigen::Matrix3d::Identity() - u_l * u_l.transpose() - u_k * u_k.transpose() +
                                 yarns.cosine * u_k * u_l.transpose();
  return block + shear * yarns.cosine * inverse * across;
}

}  // namespace

double YarnEnergy::AddForce(const YarnConstants& constants, const Eigen::VectorXd& positions,
                            Eigen::VectorXd* force) const {
  CornerVectors x, forces;
  double energy = 0.0;
  for (const TriangleBatch& batch : *triangles_) {
    GatherCorners(batch, positions.data(), &x);
    energy += YarnForces(batch, x, constants, &forces);
    AddCorners(batch, forces, force->data());
  }
  return energy;
}

void YarnEnergy::AddForceProducts(const YarnConstants& constants, const Eigen::VectorXd& positions,
                                  const Eigen::MatrixXd& columns, Eigen::Ref<Eigen::MatrixXd> products) const {
  CornerVectors x, forces;
  for (std::size_t b = 0; b < triangles_->size(); ++b) {
    const TriangleBatch& batch = (*triangles_)[b];
    GatherCorners(batch, positions.data(), &x);
    YarnForces(batch, x, constants, &forces);
    AddCornerProducts(batch, forces, columns, static_cast<Eigen::Index>(b) * kLanes, products);
  }
}

void YarnEnergy::AddStiffeningDerivative(int yarn, double factor, const YarnConstants& constants,
                                         const Eigen::VectorXd& positions, Eigen::VectorXd* force) const {
  const double stiffness = factor * (yarn == 0 ? constants.k.c11 : constants.k.c22);
  CornerVectors x, forces;
  for (const TriangleBatch& batch : *triangles_) {
    GatherCorners(batch, positions.data(), &x);
    for (int lane = 0; lane < kLanes; ++lane) {
      const Yarns yarns(batch, x, lane);
      const Response response = ResponseAt(yarns.strain(yarn), constants.stiffening[yarn]);
      Eigen::Matrix<double, 3, 2> stress = Eigen::Matrix<double, 3, 2>::Zero();
      stress.col(yarn) = stiffness * response.by_stiffening * yarns.directions.col(yarn);
      SetForces(batch, stress, lane, &forces);
    }
    AddCorners(batch, forces, force->data());
  }
}

// B_ij = a sum_kl g_ik g_jl d2E/(df_k df_l)/a.
void YarnEnergy::AddHessian(double factor, const YarnConstants& constants, HessianKind kind,
                            const Eigen::VectorXd& positions, BlockMatrix* hessian, ThreadTeam* team) const {
  const auto fill = [&](std::size_t b, CornerBlocks* blocks) {
    const TriangleBatch& batch = (*triangles_)[b];
    CornerVectors x;
    GatherCorners(batch, positions.data(), &x);
    for (int lane = 0; lane < kLanes; ++lane) {
      const Yarns yarns(batch, x, lane);
      const Response responses[2] = {ResponseAt(yarns.strain(0), constants.stiffening[0]),
                                     ResponseAt(yarns.strain(1), constants.stiffening[1])};
      const Eigen::Matrix3d along = StiffnessBlock(yarns, constants, kind, responses, 0, 0);
      const Eigen::Matrix3d between = StiffnessBlock(yarns, constants, kind, responses, 0, 1);
      const Eigen::Matrix3d across = StiffnessBlock(yarns, constants, kind, responses, 1, 1);
      const ShapeGradients g = AllShapeGradients(batch, lane);
      for (int pair = 0; pair < 3; ++pair) {
        const double(&gi)[2] = g.corner[kCornerPairs[pair][0]];
        const double(&gj)[2] = g.corner[kCornerPairs[pair][1]];
        const Eigen::Matrix3d block =
            (factor * batch.area[lane]) * (gi[0] * gj[0] * along + gi[0] * gj[1] * between +
                                           gi[1] * gj[0] * between.transpose() + gi[1] * gj[1] * across);
        for (int c = 0; c < 9; ++c) blocks->values[pair][c][lane] = block(c % 3, c / 3);
      }
    }
  };
  AddAllBlocks(*triangles_, team, fill, hessian);
}

double YarnEnergy::StiffnessGrowth(const YarnConstants& constants, const Eigen::VectorXd& positions) const {
  CornerVectors x;
  double growth = 1.0;
  for (const TriangleBatch& batch : *triangles_) {
    GatherCorners(batch, positions.data(), &x);
    for (int lane = 0; lane < kLanes; ++lane) {
      const Yarns yarns(batch, x, lane);
      for (int k = 0; k < 2; ++k) {
        growth = std::max(growth, ResponseAt(yarns.strain(k), constants.stiffening[k]).slope);
      }
    }
  }
  return growth;
}

}  // namespace clothid

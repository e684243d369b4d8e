#include "identify/prediction/random_force.h"

#include <algorithm>
#include <cmath>
#include <stdexcept>
#include <utility>

#include "identify/prediction/random_streams.h"
#include "sim/mesh/mesh.h"
#include "sim/shell/triangle_element.h"

namespace clothid {

SmoothField::SmoothField(const ClothModel& cloth, double length) : free_nodes_(cloth.free_nodes()) {
  const auto num_free = static_cast<Eigen::Index>(free_nodes_.size());
  Eigen::SparseMatrix<double> free(cloth.num_nodes(), num_free);
  for (Eigen::Index i = 0; i < num_free; ++i) free.insert(free_nodes_[static_cast<std::size_t>(i)], i) = 1.0;
  const Eigen::VectorXd areas = free.transpose() * cloth.node_areas();
  const Eigen::SparseMatrix<double> laplacian =
      free.transpose() * LaplacianMatrix(cloth.triangles(), cloth.num_nodes()) * free;
  const double smoothing = length * std::sqrt(2.0 / 3.14159265358979323846);
  Eigen::SparseMatrix<double> matrix = std::pow(smoothing, 4) * laplacian.transpose() *
                                       Eigen::SparseMatrix<double>(areas.cwiseInverse().asDiagonal() * laplacian);
  for (Eigen::Index i = 0; i < num_free; ++i) matrix.coeffRef(i, i) += areas[i];
  factor_.compute(matrix);
  if (factor_.info() != Eigen::Success) throw std::runtime_error("the smoothing of forces has no factor");
  roots_ = areas.cwiseSqrt();
  constexpr int kSamples = 400;  // of a field with few modes the root of its variance is known to 3 %
  NormalStream stream(0, 0, DrawStream::kScale);
  scale_ =
      std::sqrt(static_cast<double>(num_free * kSamples)) / Smooth(stream.Draw(cloth.num_nodes(), kSamples)).norm();
}

Eigen::MatrixXd SmoothField::Smooth(const Eigen::MatrixXd& noise) const {
  Eigen::MatrixXd field = Eigen::MatrixXd::Zero(noise.rows(), noise.cols());
  field(free_nodes_, Eigen::all) =
      scale_ * factor_.solve(Eigen::MatrixXd(roots_.asDiagonal() * noise(free_nodes_, Eigen::all)));
  return field;
}

RandomForce::RandomForce(const ClothModel& cloth, int num_steps)
    : changes_(Eigen::MatrixXd::Zero(3 * cloth.num_nodes(), num_steps)),
      reach_(kMovedShare * ClothSize(cloth.scene().mesh)) {
  if (cloth.scene().initial_velocities.isZero(0.0)) start_ = cloth.scene().initial_positions;
}

void RandomForce::Add(const LastingForce& force, const SmoothField& field, const ClothModel& cloth,
                      const Material& material, NormalStream* stream) {
  const int num_nodes = cloth.num_nodes();
  const double time_step = cloth.scene().time_step, kept = std::exp(-time_step / force.time);
  Eigen::ArrayXd accelerations = Eigen::ArrayXd::Zero(num_nodes);  // h a/m: m/s of 1 N/m^2
  for (const int node : cloth.free_nodes()) {
    accelerations[node] = time_step * cloth.node_areas()[node] / cloth.mass(material, node);
  }
  Eigen::MatrixXd own = force.size * field.Smooth(stream->Draw(num_nodes, 3));
  for (Eigen::Index step = 0; step < changes_.cols(); ++step) {
    if (step > 0)
      own = kept * own + force.size * std::sqrt(1.0 - kept * kept) * field.Smooth(stream->Draw(num_nodes, 3));
    const Eigen::Matrix3Xd changes = (own.array().colwise() * accelerations).matrix().transpose();
    changes_.col(step) += changes.reshaped();
  }
}

double RandomForce::MovedBy(const Eigen::VectorXd& positions) const {
  return (positions - start_).norm() / std::sqrt(static_cast<double>(positions.size()) / 3.0);
}

double RandomForce::Share(const Eigen::VectorXd& positions) const {
  return start_.size() == 0 ? 1.0 : std::min(1.0, MovedBy(positions) / reach_);
}

Eigen::VectorXd RandomForce::ShareGradient(const Eigen::VectorXd& positions) const {
  const double moved = start_.size() == 0 ? reach_ : MovedBy(positions);
  if (!(moved < reach_) || moved == 0.0) return Eigen::VectorXd::Zero(positions.size());
  return 3.0 / (static_cast<double>(positions.size()) * reach_ * moved) * (positions - start_);
}

void RandomForce::Evaluate(int step, const StepEnds& ends, Eigen::VectorXd* positions,
                           Eigen::VectorXd* velocities) const {
  positions->setZero(changes_.rows());
  *velocities = Share(ends.end) * changes_.col(step - 1);
}

void RandomForce::Times(int step, const StepEnds& ends, const Eigen::MatrixXd& /*start_changes*/,
                        const Eigen::MatrixXd& end_changes, Eigen::MatrixXd* positions,
                        Eigen::MatrixXd* velocities) const {
  positions->setZero(end_changes.rows(), end_changes.cols());
  *velocities = changes_.col(step - 1) * (ShareGradient(ends.end).transpose() * end_changes);
}

void RandomForce::TimesTransposed(int step, const StepEnds& ends, const Eigen::MatrixXd& /*by_positions*/,
                                  const Eigen::MatrixXd& by_velocities, Eigen::MatrixXd* by_start,
                                  Eigen::MatrixXd* by_end) const {
  by_start->setZero(by_velocities.rows(), by_velocities.cols());
  *by_end = ShareGradient(ends.end) * (changes_.col(step - 1).transpose() * by_velocities);
}

ForceSource::ForceSource(std::vector<LastingForce> parts, const ClothModel& cloth) : parts_(std::move(parts)) {
  for (const LastingForce& part : parts_) fields_.push_back(std::make_unique<SmoothField>(cloth, part.length));
}

std::shared_ptr<const Correction> ForceSource::Draw(double factor, const ClothModel& cloth, const Material& material,
                                                    int num_steps, std::uint64_t seed, int draw) const {
  auto force = std::make_shared<RandomForce>(cloth, num_steps);
  NormalStream stream(seed, draw, DrawStream::kForces);
  for (std::size_t i = 0; i < parts_.size(); ++i) {
    LastingForce part = parts_[i];
    part.size *= factor;
    force->Add(part, *fields_[i], cloth, material, &stream);
  }
  return force;
}

}  // namespace clothid

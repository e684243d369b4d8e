#include "datasets/motion/motion_validation.h"

#include <cfloat>
#include <cmath>
#include <set>

#include "datasets/files/safetensors.h"
#include "sim/base/error.h"

namespace clothid {
namespace {

constexpr double kBarycentricTolerance = 1e-6;

// Of all frames: more do not fit into a container.
constexpr long long kMaxCloudPoints = static_cast<long long>(kMaxContainerBytes / (3 * sizeof(float)));

class Validator {
 public:
  Validator(const MotionTensors& tensors, const std::string& path) : tensors_(tensors), path_(path) {}

  void Validate() const {
    ValidateTimes();
    ValidateSizes();
    ValidateMesh(tensors_.mesh, path_);
    ValidatePositions();
    ValidateIndices(tensors_.node_index, tensors_.mesh.num_nodes(), "node_index");
    ValidateIndices(tensors_.face_index, tensors_.mesh.num_faces(), "face_index");
    ValidateIndices(tensors_.handle_index, tensors_.mesh.num_nodes(), "handle_index");
    ValidateBarycentric();
    ValidateHandles();
    ValidateClouds();
    for (Eigen::Index i = 0; i < tensors_.sigma.size(); ++i) {
      const double sigma = tensors_.sigma[i];
      if (!std::isfinite(sigma) || !(sigma > 0.0)) Fail("sigma", "entry " + std::to_string(i) + " is not a number > 0");
    }
  }

 private:
  [[noreturn]] void Fail(const std::string& tensor, const std::string& message) const {
    throw Error(ErrorKind::kBadData, path_ + ": tensor '" + tensor + "': " + message);
  }

  Eigen::Index num_points() const { return tensors_.positions.rows() / 3; }

  void ValidateTimes() const {
    const Eigen::Index num_times = tensors_.times.size();
    if (num_times < 2) Fail("times", "expected at least two frames, found " + std::to_string(num_times));
    ExpectIncreasing(tensors_.times, "times");
    ExpectIncreasing(tensors_.handle_times, "handle_times");
  }

  void ExpectIncreasing(const Eigen::VectorXd& times, const std::string& tensor) const {
    for (Eigen::Index i = 0; i < times.size(); ++i) {
      if (!std::isfinite(times[i])) Fail(tensor, "entry " + std::to_string(i) + " is not finite");
      if (i > 0 && !(times[i] > times[i - 1])) {
        Fail(tensor, "entry " + std::to_string(i) + " is not above the one before it");
      }
    }
  }

  void ExpectSize(const std::string& tensor, Eigen::Index found, Eigen::Index expected) const {
    if (found == expected) return;
    Fail(tensor, "expected " + std::to_string(expected) + " numbers, found " + std::to_string(found));
  }

  void ValidateSizes() const {
    const Eigen::Index num_times = tensors_.times.size();
    const Eigen::Index num_handles = static_cast<Eigen::Index>(tensors_.handle_index.size());
    ExpectSize("positions", tensors_.positions.size(), 3 * num_points() * num_times);
    if (num_points() == 0 && tensors_.clouds.empty()) Fail("positions", "expected at least one point");
    ExpectSize("positions", tensors_.positions.cols(), num_times);
    if (!tensors_.node_index.empty() && !tensors_.face_index.empty()) {
      Fail("face_index", "expected either node_index or face_index");
    }
    if (!tensors_.node_index.empty()) {
      ExpectSize("node_index", static_cast<Eigen::Index>(tensors_.node_index.size()), num_points());
    }
    if (!tensors_.face_index.empty()) {
      ExpectSize("face_index", static_cast<Eigen::Index>(tensors_.face_index.size()), num_points());
    }
    ExpectSize("barycentric", tensors_.barycentric.size(), tensors_.face_index.empty() ? 0 : 3 * num_points());
    if (tensors_.node_index.empty() && tensors_.face_index.empty() && num_points() != tensors_.mesh.num_nodes() &&
        num_points() > 0) {
      Fail("positions", "expected the " + std::to_string(tensors_.mesh.num_nodes()) + " nodes of the mesh, found " +
                            std::to_string(num_points()) + " points and neither node_index nor face_index");
    }
    if (num_handles == 0) ExpectSize("handle_times", tensors_.handle_times.size(), 0);
    const Eigen::Index num_knots = tensors_.handle_times.size() > 0 ? tensors_.handle_times.size() : num_times;
    ExpectSize("handle_positions", tensors_.handle_positions.size(), 3 * num_handles * num_knots);
    if (num_handles > 0) ExpectSize("handle_positions", tensors_.handle_positions.cols(), num_knots);
    if (tensors_.sigma.size() > 0) ExpectSize("sigma", tensors_.sigma.size(), num_points());
  }

  void ValidatePositions() const {
    const double limit = tensors_.single_precision ? static_cast<double>(FLT_MAX) : DBL_MAX;
    for (Eigen::Index t = 0; t < tensors_.positions.cols(); ++t) {
      if ((tensors_.positions.col(t).array().abs() > limit).any()) {
        Fail("positions", "frame " + std::to_string(t) + " holds an infinite coordinate; expected numbers or NaN");
      }
    }
  }

  void ValidateIndices(const std::vector<int>& indices, int count, const std::string& tensor) const {
    for (std::size_t i = 0; i < indices.size(); ++i) {
      if (indices[i] >= 0 && indices[i] < count) continue;
      Fail(tensor, "entry " + std::to_string(i) + " is " + std::to_string(indices[i]) + "; expected 0 to " +
                       std::to_string(count - 1));
    }
  }

  void ValidateBarycentric() const {
    for (Eigen::Index i = 0; i < tensors_.barycentric.cols(); ++i) {
      if (!(std::abs(tensors_.barycentric.col(i).sum() - 1.0) <= kBarycentricTolerance)) {
        Fail("barycentric", "row " + std::to_string(i) + " does not sum to 1");
      }
    }
  }

  void ValidateHandles() const {
    std::set<int> seen;
    for (const int node : tensors_.handle_index) {
      if (!seen.insert(node).second) Fail("handle_index", "node " + std::to_string(node) + " is listed twice");
    }
    for (Eigen::Index t = 0; t < tensors_.handle_positions.cols(); ++t) {
      if (!tensors_.handle_positions.col(t).allFinite()) {
        Fail("handle_positions", (tensors_.handle_times.size() > 0 ? "time " : "frame ") + std::to_string(t) +
                                     " is not finite; a handle's path must have no gap");
      }
    }
  }

  void ValidateClouds() const {
    const double limit = tensors_.single_precision_clouds ? static_cast<double>(FLT_MAX) : DBL_MAX;
    if (!std::isfinite(tensors_.cloud_sigma) || tensors_.cloud_sigma < 0.0) {
      Fail("cloud_sigma", "is not a number > 0");
    }
    if (tensors_.clouds.empty()) {
      if (tensors_.cloud_sigma > 0.0) Fail("cloud_positions", "is missing; expected beside cloud_sigma");
      return;
    }
    if (static_cast<Eigen::Index>(tensors_.clouds.size()) != tensors_.times.size()) {
      Fail("cloud_offsets", "expected a cloud for each of the " + std::to_string(tensors_.times.size()) +
                                " times, found " + std::to_string(tensors_.clouds.size()));
    }
    long long num_points = 0;
    for (std::size_t i = 0; i < tensors_.clouds.size(); ++i) {
      num_points += tensors_.clouds[i].cols();
      if ((tensors_.clouds[i].array().abs() <= limit).all()) continue;
      Fail("cloud_positions", "the cloud of frame " + std::to_string(i) + " holds a coordinate that is not finite");
    }
    if (num_points == 0) Fail("cloud_positions", "expected at least one point");
    if (num_points > kMaxCloudPoints) {
      Fail("cloud_positions", "expected at most " + std::to_string(kMaxCloudPoints) + " points");
    }
  }

  const MotionTensors& tensors_;
  const std::string& path_;
};

}  // namespace

void ValidateMotionTensors(const MotionTensors& tensors, const std::string& path) {
  Validator(tensors, path).Validate();
}

}  // namespace clothid

// What people do wrong to a recording that is right: each takes the tensors of a file and gives those of another one
// that can be read, too.
#ifndef CLOTHID_TESTS_IDENTIFY_RECORDING_EDITS_H_
#define CLOTHID_TESTS_IDENTIFY_RECORDING_EDITS_H_

#include <Eigen/Geometry>
#include <functional>
#include <limits>
#include <nlohmann/json.hpp>
#include <string>
#include <utility>
#include <vector>

#include "datasets/motion/motion_file.h"

namespace clothid {

using Json = nlohmann::ordered_json;
using Edit = std::function<void(MotionTensors*)>;

inline Edit InScene(const std::function<void(Json*)>& change) {
  return [change](MotionTensors* tensors) {
    Json scene = Json::parse(tensors->scene_text);
    change(&scene);
    tensors->scene_text = scene.dump();
  };
}

inline Edit SetInScene(const std::string& pointer, const Json& value) {
  return InScene([=](Json* scene) { (*scene)[Json::json_pointer(pointer)] = value; });
}

// The cloth starts at the first frame.
inline Edit StartAtFrame() {
  return InScene([](Json* scene) { scene->erase("initial"); });
}

inline Edit MapPoints(const std::function<Eigen::Vector3d(const Eigen::Vector3d&)>& map) {
  return [map](MotionTensors* tensors) {
    for (auto point : tensors->positions.reshaped(3, tensors->positions.size() / 3).colwise()) {
      point = map(point).eval();
    }
    for (Eigen::Matrix3Xd& cloud : tensors->clouds) {
      for (auto point : cloud.colwise()) point = map(point).eval();
    }
  };
}

inline Edit MapHandles(const std::function<Eigen::Vector3d(const Eigen::Vector3d&)>& map) {
  return [map](MotionTensors* tensors) {
    for (auto point : tensors->handle_positions.reshaped(3, tensors->handle_positions.size() / 3).colwise()) {
      point = map(point).eval();
    }
  };
}

// Points and handles alike.
inline Edit MapAll(const std::function<Eigen::Vector3d(const Eigen::Vector3d&)>& map) {
  return [map](MotionTensors* tensors) {
    MapPoints(map)(tensors);
    MapHandles(map)(tensors);
  };
}

inline std::function<Eigen::Vector3d(const Eigen::Vector3d&)> Scaled(double factor) {
  return [factor](const Eigen::Vector3d& x) -> Eigen::Vector3d { return factor * x; };
}

inline std::function<Eigen::Vector3d(const Eigen::Vector3d&)> Shifted(double x, double y, double z) {
  return [=](const Eigen::Vector3d& p) -> Eigen::Vector3d { return p + Eigen::Vector3d(x, y, z); };
}

inline Eigen::Vector3d SwappedYZ(const Eigen::Vector3d& x) { return {x.x(), x.z(), x.y()}; }
inline Eigen::Vector3d AsACameraSeesIt(const Eigen::Vector3d& x) {
  return Eigen::AngleAxisd(2.0, Eigen::Vector3d(0.9, -0.3, 0.3).normalized()) * (x - Eigen::Vector3d(0.5, -1.0, 1.2));
}

// Point p becomes what point `order(p)` was, in all frames.
inline Edit Reorder(const std::function<int(int)>& order) {
  return [order](MotionTensors* tensors) {
    const Eigen::MatrixXd before = tensors->positions;
    for (int p = 0; p < static_cast<int>(before.rows() / 3); ++p) {
      tensors->positions.middleRows<3>(3 * p) = before.middleRows<3>(3 * static_cast<Eigen::Index>(order(p)));
    }
  };
}

inline Edit ScaleTimes(double factor) {
  return [factor](MotionTensors* tensors) { tensors->times *= factor; };
}

// Frames from `first` on, starting at the time of the first one.
inline Edit FromFrame(Eigen::Index first) {
  return [first](MotionTensors* tensors) {
    const Eigen::Index count = tensors->times.size() - first;
    const double start = tensors->times[0];
    tensors->positions = tensors->positions.rightCols(count).eval();
    tensors->times = (tensors->times.tail(count).array() - tensors->times[first] + start).matrix().eval();
  };
}

inline void Reverse(MotionTensors* tensors) {
  const double end = tensors->times[tensors->times.size() - 1] + tensors->times[0];
  tensors->times = (end - tensors->times.reverse().array()).matrix().eval();
  tensors->positions = tensors->positions.rowwise().reverse().eval();
}

// Frames first .. last show what the one before them shows.
inline Edit Freeze(Eigen::Index first, Eigen::Index last) {
  return [=](MotionTensors* tensors) {
    for (Eigen::Index frame = first; frame <= last; ++frame) {
      tensors->positions.col(frame) = tensors->positions.col(first - 1);
    }
  };
}

// Without the samples of the path between two times.
inline Edit CutPath(double from, double to) {
  return [=](MotionTensors* tensors) {
    std::vector<Eigen::Index> kept;
    for (Eigen::Index k = 0; k < tensors->handle_times.size(); ++k) {
      if (tensors->handle_times[k] < from || tensors->handle_times[k] > to) kept.push_back(k);
    }
    tensors->handle_times = tensors->handle_times(kept).eval();
    tensors->handle_positions = tensors->handle_positions(Eigen::all, kept).eval();
  };
}

// Handle i takes the path of handle `order(i)`.
inline Edit ReorderHandles(const std::function<Eigen::Index(Eigen::Index)>& order) {
  return [order](MotionTensors* tensors) {
    const Eigen::MatrixXd before = tensors->handle_positions;
    for (Eigen::Index i = 0; i < before.rows() / 3; ++i) {
      tensors->handle_positions.middleRows<3>(3 * i) = before.middleRows<3>(3 * order(i));
    }
  };
}

}  // namespace clothid

#endif  // CLOTHID_TESTS_IDENTIFY_RECORDING_EDITS_H_

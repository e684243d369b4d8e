// .npy: arrays of positions and of indices, and writing them again.
#include <algorithm>
#include <cmath>

#include "sim/base/npy_file.h"
#include "tests/fuzz/fuzz_target.h"

namespace clothid {
namespace {

// Reads with `read`, checks the sizes, and reads again what `NpyBytes` makes of it.
template <typename Array>
void ReadAndWrite(const MemoryFile& file, Array (*read)(const std::string&)) {
  Array array;
  if (!Accepts([&] { array = read(file.path()); }, file.path())) return;
  const bool is_empty = std::find(array.shape.begin(), array.shape.end(), 0) != array.shape.end();
  long long count = is_empty ? 0 : 1;
  for (std::size_t axis = 0; !is_empty && axis < array.shape.size(); ++axis) count *= array.shape[axis];
  Check(count == static_cast<long long>(array.values.size()), "as many values as the shape says");
  static const MemoryFile copy;
  copy.Write(NpyBytes(array));
  const Array again = read(copy.path());
  Check(again.shape == array.shape && again.values.size() == array.values.size(), "the shape that was written");
  for (std::size_t i = 0; i < array.values.size(); ++i) {
    const bool are_nan =
        std::isnan(static_cast<double>(array.values[i])) && std::isnan(static_cast<double>(again.values[i]));
    Check(again.values[i] == array.values[i] || are_nan, "the values that were written");
  }
}

}  // namespace
}  // namespace clothid

int clothid::FuzzNpy(const std::uint8_t* data, std::size_t size) {
  static const MemoryFile file;
  file.Write(AsText(data, size));
  ReadAndWrite(file, &ReadNpy);
  ReadAndWrite(file, &ReadNpyIntegers);
  return 0;
}

// .npy: arrays of positions.
#include "sim/npy_file.h"
#include "tests/fuzz/fuzz_target.h"

int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  using namespace clothid;
  static const MemoryFile file;
  file.Write(AsText(data, size));
  NpyArray array;
  if (!Accepts([&] { array = ReadNpy(file.path()); }, file.path())) return 0;
  long long count = 1;
  for (const long long length : array.shape) count *= length;
  Check(count == static_cast<long long>(array.values.size()), "as many values as the shape says");
  return 0;
}

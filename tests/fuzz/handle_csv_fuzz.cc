// Paths of handles as CSV. The first byte chooses the number of handles.
#include "sim/path/handle_csv.h"
#include "tests/fuzz/fuzz_target.h"

int clothid::FuzzHandleCsv(const std::uint8_t* data, std::size_t size) {
  constexpr int kMaxHandles = 4;
  if (size == 0) return 0;
  static const MemoryFile file;
  file.Write(AsText(data + 1, size - 1));
  HandlePath path;
  if (!Accepts([&] { path = ReadHandleCsv(file.path(), data[0] % (kMaxHandles + 1)); }, file.path())) return 0;
  for (Eigen::Index i = 0; i < path.times().size(); ++i) {
    const double time = path.times()[i], next = path.times()[std::min(i + 1, path.times().size() - 1)];
    for (const double share : {0.0, 0.3, 1.0}) {
      Check(path.At(time + share * (next - time)).allFinite(), "a path that is finite at every time");
    }
  }
  return 0;
}

// motion.bin: container, tensors, and the scene inside it. Checksums are made right.
#include <cstring>

#include "datasets/checking/motion_check.h"
#include "datasets/files/sha256.h"
#include "datasets/motion/motion_file.h"
#include "sim/base/text_file.h"
#include "tests/fuzz/fuzz_target.h"
#include "tests/temporary_folder.h"

namespace clothid {
namespace {

constexpr std::size_t kLengthSize = 8;

std::string WithDigests(std::string bytes) {
  std::uint64_t length = 0;
  if (bytes.size() < kLengthSize) return bytes;
  std::memcpy(&length, bytes.data(), kLengthSize);
  if (length > bytes.size() - kLengthSize) return bytes;
  std::string header = bytes.substr(kLengthSize, length);
  const std::string data = bytes.substr(kLengthSize + length), blank(64, ' ');
  SetDigest("sha256", Sha256Hex({data}), &header);
  SetDigest("header_sha256", blank, &header);
  SetDigest("header_sha256", Sha256Hex({header}), &header);
  return bytes.substr(0, kLengthSize) + header + data;
}

// What was read can be written, and from then on reading and writing change nothing.
void CheckRoundTrip(const MotionTensors& tensors) {
  constexpr std::uint64_t kMaxBytes = 1 << 20;
  static const TemporaryFolder folder;
  const std::string first = folder.File("first.motion.bin"), second = folder.File("second.motion.bin");
  Check(Accepts([&] { WriteMotion(tensors, first); }, first), "a recording that can be written");
  Check(Accepts([&] { WriteMotion(ReadMotionTensors(first), second); }, ""), "a recording that can be read back");
  Check(ReadFile(first, kMaxBytes) == ReadFile(second, kMaxBytes), "the same recording");
}

}  // namespace
}  // namespace clothid

int clothid::FuzzMotion(const std::uint8_t* data, std::size_t size) {
  static const MemoryFile file;
  file.Write(WithDigests(std::string(AsText(data, size))));
  MotionTensors tensors;
  if (!Accepts([&] { tensors = ReadMotionTensors(file.path()); }, file.path())) return 0;
  CheckRoundTrip(tensors);
  RecordedMotion motion;
  if (!Accepts([&] { motion = ReadMotion(file.path()); }, "")) return 0;
  Check(motion.num_frames() >= 2 && motion.scene.num_steps() >= 1, "two frames and a step between them");
  const std::vector<Finding> findings = CheckMotion(motion);
  Check(!FindingsTable(findings).empty() && !FindingsJson(findings, "motion.bin").empty(), "findings in words");
  return 0;
}

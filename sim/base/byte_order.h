// Numbers in the bytes of files. Like all of clothid, for machines that keep numbers little-endian.
#ifndef CLOTHID_SIM_BASE_BYTE_ORDER_H_
#define CLOTHID_SIM_BASE_BYTE_ORDER_H_

#include <algorithm>
#include <cstring>
#include <string>

namespace clothid {

enum class ByteOrder { kLittle, kBig };

// The number that starts at `bytes` [sizeof(T)], which need not be aligned.
template <typename T>
T LoadNumber(const char* bytes, ByteOrder order) {
  char ordered[sizeof(T)];
  std::memcpy(ordered, bytes, sizeof(T));
  if (order == ByteOrder::kBig) std::reverse(ordered, ordered + sizeof(T));
  T value;
  std::memcpy(&value, ordered, sizeof(T));
  return value;
}

template <typename T>
void AppendLittleEndian(T value, std::string* bytes) {
  bytes->append(reinterpret_cast<const char*>(&value), sizeof(T));
}

}  // namespace clothid

#endif  // CLOTHID_SIM_BASE_BYTE_ORDER_H_

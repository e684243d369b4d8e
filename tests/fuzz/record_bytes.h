// Inputs that become files of records (datasets/files/record_file.h).
#ifndef CLOTHID_TESTS_FUZZ_RECORD_BYTES_H_
#define CLOTHID_TESTS_FUZZ_RECORD_BYTES_H_

#include <algorithm>
#include <cstdint>
#include <cstring>
#include <string>
#include <string_view>

#include "datasets/files/sha256.h"

namespace clothid {

// What stands behind the header of the file. An even `choice` takes `input` as it is; an odd one makes records with
// right lengths and checksums of it, since no input would get past these: each is two bytes of length, then its
// payload.
inline std::string RecordBytes(std::uint8_t choice, std::string_view input) {
  if (choice % 2 == 0) return std::string(input);
  std::string bytes;
  std::uint16_t wanted = 0;
  while (input.size() >= sizeof(wanted)) {
    std::memcpy(&wanted, input.data(), sizeof(wanted));
    const std::string_view payload = input.substr(sizeof(wanted), wanted);
    const std::uint64_t lengths[] = {payload.size(), ~static_cast<std::uint64_t>(payload.size())};
    bytes.append(reinterpret_cast<const char*>(lengths), sizeof(lengths)).append(Sha256Hex({payload})).append(payload);
    input.remove_prefix(sizeof(wanted) + payload.size());
  }
  return bytes;
}

}  // namespace clothid

#endif  // CLOTHID_TESTS_FUZZ_RECORD_BYTES_H_

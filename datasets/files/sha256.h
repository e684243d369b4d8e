// SHA-256 (FIPS 180-4), by way of Nettle.
#ifndef CLOTHID_DATASETS_FILES_SHA256_H_
#define CLOTHID_DATASETS_FILES_SHA256_H_

#include <initializer_list>
#include <string>
#include <string_view>

namespace clothid {

// Of `parts` one after the other, as 64 lower-case hexadecimal digits.
std::string Sha256Hex(std::initializer_list<std::string_view> parts);

}  // namespace clothid

#endif  // CLOTHID_DATASETS_FILES_SHA256_H_

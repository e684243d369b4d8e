#include "sim/npy_file.h"

#include <cstdint>
#include <cstring>
#include <optional>
#include <string_view>

#include "sim/error.h"
#include "sim/text_file.h"

namespace clothid {
namespace {

constexpr std::string_view kMagic = "\x93NUMPY";

// The magic string and the two bytes of the version, then the length of the header in 2 bytes (version 1) or 4.
constexpr std::size_t kVersionEnd = 8;

// The parts of a file's bytes.
struct Parts {
  std::string_view header;  // a Python dictionary: {'descr': '<f8', 'fortran_order': False, 'shape': (64, 3), }
  std::string_view data;
};

class NpyReader {
 public:
  NpyReader(const std::string& path, std::string_view bytes) : path_(path), bytes_(bytes) {}

  NpyArray Read() const {
    const Parts parts = Split();
    const std::string_view type = Entry(parts.header, "'descr':");
    if (!StartsWith(Entry(parts.header, "'fortran_order':"), "False")) Fail("expected C order (fortran_order False)");
    NpyArray array;
    array.shape = Shape(Entry(parts.header, "'shape':"));
    const std::size_t count = Count(array.shape, parts.data.size());
    if (StartsWith(type, "'<f8'")) {
      array.values = Values<double>(parts.data, count);
    } else if (StartsWith(type, "'<f4'")) {
      array.values = Values<float>(parts.data, count);
    } else {
      Fail("expected elements of type '<f4' or '<f8', found " + Printable(type.substr(0, type.find(','))));
    }
    return array;
  }

 private:
  [[noreturn]] void Fail(const std::string& message) const { throw Error(ErrorKind::kBadData, path_ + ": " + message); }

  static bool StartsWith(std::string_view text, std::string_view start) {
    return text.substr(0, start.size()) == start;
  }

  Parts Split() const {
    if (!StartsWith(bytes_, kMagic) || bytes_.size() < kVersionEnd) Fail("is not a .npy file");
    const std::size_t length_size = bytes_[6] == 1 ? 2 : 4;
    if (bytes_[6] < 1 || bytes_[6] > 3) Fail("expected .npy format version 1, 2 or 3");
    if (bytes_.size() < kVersionEnd + length_size) Fail("ends within its header");
    std::uint32_t length = 0;
    std::memcpy(&length, bytes_.data() + kVersionEnd, length_size);
    const std::string_view rest = bytes_.substr(kVersionEnd + length_size);
    if (length > rest.size()) Fail("ends within its header");
    return {rest.substr(0, length), rest.substr(length)};
  }

  // What stands behind `key`, without leading blanks.
  std::string_view Entry(std::string_view header, std::string_view key) const {
    const std::size_t start = header.find(key);
    if (start == std::string_view::npos) Fail("its header lacks " + std::string(key));
    std::string_view rest = header.substr(start + key.size());
    rest.remove_prefix(std::min(rest.find_first_not_of(' '), rest.size()));
    return rest;
  }

  std::vector<long long> Shape(std::string_view text) const {
    const std::size_t close = text.find(')');
    if (!StartsWith(text, "(") || close == std::string_view::npos) Fail("expected a shape like (64, 3)");
    text = text.substr(1, close - 1);
    std::vector<long long> shape;
    while (!text.empty()) {
      std::string_view entry = text.substr(0, text.find(','));
      text.remove_prefix(std::min(entry.size() + 1, text.size()));
      entry = TakeWord(&entry);
      if (entry.empty()) continue;
      const std::optional<long long> size = ParseInteger(entry);
      if (!size || *size < 0) Fail("expected a shape of integers >= 0");
      shape.push_back(*size);
    }
    return shape;
  }

  // The number of elements, at most one per byte of the data.
  std::size_t Count(const std::vector<long long>& shape, std::size_t limit) const {
    unsigned long long count = 1;
    for (const long long size : shape) {
      if (size > 0 && count > limit / static_cast<unsigned long long>(size)) Fail("its shape is larger than its data");
      count *= static_cast<unsigned long long>(size);
    }
    return count;
  }

  template <typename T>
  std::vector<double> Values(std::string_view data, std::size_t count) const {
    if (data.size() != count * sizeof(T)) {
      Fail("expected " + std::to_string(count * sizeof(T)) + " bytes of data, found " + std::to_string(data.size()));
    }
    std::vector<double> values(count);
    for (std::size_t i = 0; i < count; ++i) {
      T value;
      std::memcpy(&value, data.data() + i * sizeof(T), sizeof(T));
      values[i] = static_cast<double>(value);
    }
    return values;
  }

  const std::string& path_;
  std::string_view bytes_;
};

}  // namespace

NpyArray ReadNpy(const std::string& path) {
  const std::string bytes = ReadFile(path, kMaxNpyBytes);
  return NpyReader(path, bytes).Read();
}

}  // namespace clothid

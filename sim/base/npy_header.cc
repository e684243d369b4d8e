#include "sim/base/npy_header.h"

#include <algorithm>
#include <cstdint>
#include <optional>
#include <utility>

#include "sim/base/byte_order.h"
#include "sim/base/error.h"
#include "sim/base/text_file.h"

namespace clothid {
namespace {

constexpr std::string_view kMagic = "\x93NUMPY";
constexpr std::size_t kVersionEnd = 8;  // of the magic string and the version
constexpr std::size_t kAlignment = 64;  // of the numbers, as NumPy writes them

// Where the dictionary stands in a file: its first byte and its length.
std::pair<std::size_t, std::size_t> FindDictionary(const std::string& path, std::string_view bytes) {
  if (bytes.substr(0, kMagic.size()) != kMagic || bytes.size() < kVersionEnd) FailOnData(path, "is not a .npy file");
  const char version = bytes[kMagic.size()];
  if (version < 1 || version > 3) FailOnData(path, "expected .npy format version 1, 2 or 3");
  const std::size_t begin = kVersionEnd + (version == 1 ? sizeof(std::uint16_t) : sizeof(std::uint32_t));
  if (bytes.size() < begin) FailOnData(path, "ends within its header");
  const char* length_bytes = bytes.data() + kVersionEnd;
  const std::size_t length = version == 1 ? LoadNumber<std::uint16_t>(length_bytes, ByteOrder::kLittle)
                                          : LoadNumber<std::uint32_t>(length_bytes, ByteOrder::kLittle);
  if (length > bytes.size() - begin) FailOnData(path, "ends within its header");
  return {begin, length};
}

// Reads the dictionary from its front.
class DictionaryReader {
 public:
  DictionaryReader(const std::string& path, std::string_view text) : path_(path), rest_(text) {}

  NpyHeader Read() {
    std::optional<std::string> descr;
    std::optional<bool> fortran_order;
    std::optional<std::vector<long long>> shape;
    if (!Take('{')) FailOnData(path_, "expected a header {..}, found '" + Printable(rest_) + "'");
    while (!Take('}')) {
      const std::string key = String("a key");
      if (!Take(':')) FailOnData(path_, "expected ':' after '" + Printable(key) + "' in its header");
      if (key == "descr") {
        descr = String("the type of its elements like '<f8'");
      } else if (key == "fortran_order") {
        fortran_order = Truth();
      } else if (key == "shape") {
        shape = Shape();
      } else {
        FailOnData(path_, "unexpected key '" + Printable(key) + "' in its header");
      }
      if (!Take(',') && Next() != '}') FailOnData(path_, "expected ',' or '}' after '" + key + "' in its header");
    }
    if (!rest_.empty() && Next() != '\0') FailOnData(path_, "expected blanks after the '}' of its header");
    Require(descr.has_value(), "descr");
    Require(fortran_order.has_value(), "fortran_order");
    Require(shape.has_value(), "shape");
    return {*descr, *fortran_order, *shape, 0};
  }

 private:
  void Require(bool is_there, const std::string& key) const {
    if (!is_there) FailOnData(path_, "its header lacks '" + key + "': expected 'descr', 'fortran_order' and 'shape'");
  }

  // The next character that is no blank; 0 at the end.
  char Next() {
    rest_.remove_prefix(std::min(rest_.find_first_not_of(" \t\r\n"), rest_.size()));
    return rest_.empty() ? '\0' : rest_.front();
  }
  bool Take(char c) {
    if (Next() != c || rest_.empty()) return false;
    rest_.remove_prefix(1);
    return true;
  }

  std::string String(const std::string& expected) {
    const char quote = Next();
    const std::size_t end = quote == '\'' || quote == '"' ? rest_.find(quote, 1) : std::string_view::npos;
    if (end == std::string_view::npos) {
      FailOnData(path_, "expected " + expected + " in its header, found '" + Printable(rest_) + "'");
    }
    const std::string text(rest_.substr(1, end - 1));
    rest_.remove_prefix(end + 1);
    return text;
  }

  bool Truth() {
    Next();
    for (const bool value : {false, true}) {
      const std::string_view word = value ? "True" : "False";
      if (rest_.substr(0, word.size()) != word) continue;
      rest_.remove_prefix(word.size());
      return value;
    }
    FailOnData(path_, "expected 'fortran_order' to be True or False");
  }

  std::vector<long long> Shape() {
    if (!Take('(')) FailOnData(path_, "expected a shape like (64, 3)");
    std::vector<long long> shape;
    while (!Take(')')) {
      Next();
      const std::size_t end = std::min(rest_.find_first_of(", \t\r\n)"), rest_.size());
      std::string_view digits = rest_.substr(0, end);
      if (!digits.empty() && digits.back() == 'L') digits.remove_suffix(1);  // a long integer of Python 2
      const std::optional<long long> size = ParseInteger(digits);
      if (!size || *size < 0) FailOnData(path_, "expected a shape of integers >= 0");
      if (shape.size() == kMaxNpyDimensions)
        FailOnData(path_, "has more than " + std::to_string(shape.size()) + " axes");
      shape.push_back(*size);
      rest_.remove_prefix(end);
      if (!Take(',') && Next() != ')') FailOnData(path_, "expected a shape like (64, 3)");
    }
    return shape;
  }

  const std::string& path_;
  std::string_view rest_;
};

}  // namespace

NpyHeader ReadNpyHeader(const std::string& path, std::string_view bytes) {
  const auto [begin, length] = FindDictionary(path, bytes);
  NpyHeader header = DictionaryReader(path, bytes.substr(begin, length)).Read();
  header.size = begin + length;
  return header;
}

std::string NpyHeaderBytes(const std::string& descr, const std::vector<long long>& shape) {
  std::string dictionary = "{'descr': '" + descr + "', 'fortran_order': False, 'shape': (";
  for (const long long size : shape) dictionary += std::to_string(size) + ", ";
  dictionary += "), }";
  const std::size_t begin = kVersionEnd + sizeof(std::uint16_t);
  const std::size_t end = begin + dictionary.size() + 1;
  dictionary.append((kAlignment - end % kAlignment) % kAlignment, ' ');
  dictionary += '\n';
  std::string bytes(kMagic);
  bytes.append({1, 0});
  AppendLittleEndian(static_cast<std::uint16_t>(dictionary.size()), &bytes);
  return bytes + dictionary;
}

}  // namespace clothid

// Reads back what a page holds.
#ifndef CLOTHID_TESTS_IDENTIFY_REPORT_PACKED_PAGE_H_
#define CLOTHID_TESTS_IDENTIFY_REPORT_PACKED_PAGE_H_

#include <gtest/gtest.h>
#include <zlib.h>

#include <cstdint>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

namespace clothid {

inline std::vector<unsigned char> Unpack(const std::string& text) {
  const std::string letters = "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
  std::vector<unsigned char> packed;
  unsigned group = 0;
  int bits = 0;
  for (const char letter : text) {
    if (letter == '=') break;
    group = group << 6 | static_cast<unsigned>(letters.find(letter));
    bits += 6;
    if (bits < 8) continue;
    bits -= 8;
    packed.push_back(static_cast<unsigned char>(group >> bits & 255));
  }
  uLongf size = 1 << 24;
  std::vector<unsigned char> bytes(size);
  EXPECT_EQ(uncompress(bytes.data(), &size, packed.data(), static_cast<uLong>(packed.size())), Z_OK);
  bytes.resize(size);
  return bytes;
}

// [frames][rows]; 65535: not seen.
inline std::vector<std::vector<int>> UnpackPositions(const std::string& text, std::size_t rows) {
  const std::vector<unsigned char> bytes = Unpack(text);
  const std::size_t count = bytes.size() / 2;
  std::vector<std::vector<int>> frames(count / rows, std::vector<int>(rows));
  std::vector<std::uint16_t> last(rows, 0);
  for (std::size_t i = 0; i < count; ++i) {
    const int code = bytes[i] | bytes[count + i] << 8;
    std::uint16_t& value = last[i % rows];
    if (code != 65535) value = static_cast<std::uint16_t>(value + (code % 2 == 0 ? code / 2 : -(code + 1) / 2));
    frames[i / rows][i % rows] = code == 65535 ? 65535 : value;
  }
  return frames;
}

inline nlohmann::ordered_json PageData(const std::string& html) {
  const std::string tag = "<script type=\"application/json\" id=\"data\">";
  const std::size_t start = html.find(tag) + tag.size();
  return nlohmann::ordered_json::parse(html.substr(start, html.find("</script>", start) - start));
}

}  // namespace clothid

#endif  // CLOTHID_TESTS_IDENTIFY_REPORT_PACKED_PAGE_H_

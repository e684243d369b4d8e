#include "sim/base/text_file.h"

#include <cerrno>
#include <charconv>
#include <cmath>
#include <cstdio>
#include <cstring>
#include <filesystem>
#include <memory>
#include <system_error>

#include "sim/base/error.h"

namespace clothid {
namespace {

constexpr std::size_t kChunk = 1 << 16;     // bytes per read
constexpr std::size_t kMaxPrintable = 120;  // characters of foreign text in a message

[[noreturn]] void ThrowUnreadable(const std::string& path, int error_number) {
  throw Error(ErrorKind::kIo, path + ": cannot be read: " + std::strerror(error_number));
}

std::string_view WithoutPlus(std::string_view text) {
  return text.size() > 1 && text[0] == '+' && text[1] != '-' ? text.substr(1) : text;
}

bool StartsWith(std::string_view text, std::string_view start) { return text.substr(0, start.size()) == start; }

bool IsControl(unsigned char c) { return c < 0x20 || c == 0x7f; }

template <typename T>
std::optional<T> ParseWhole(std::string_view text) {
  text = WithoutPlus(text);
  T value{};
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), value);
  if (error != std::errc() || end != text.data() + text.size()) return std::nullopt;
  return value;
}

}  // namespace

std::string ReadFile(const std::string& path, std::uint64_t max_bytes) {
  std::error_code ignored;
  if (std::filesystem::is_directory(path, ignored)) ThrowUnreadable(path, EISDIR);
  std::unique_ptr<std::FILE, int (*)(std::FILE*)> file(std::fopen(path.c_str(), "rb"), &std::fclose);
  if (!file) ThrowUnreadable(path, errno);
  std::string bytes;
  char chunk[kChunk];
  while (const std::size_t count = std::fread(chunk, 1, kChunk, file.get())) {
    if (bytes.size() + count > max_bytes) {
      throw Error(ErrorKind::kBadData, path + ": is larger than " + std::to_string(max_bytes) + " bytes");
    }
    bytes.append(chunk, count);
  }
  if (std::ferror(file.get())) ThrowUnreadable(path, errno);
  return bytes;
}

std::string ReadText(const std::string& path, std::uint64_t max_bytes) {
  std::string text = ReadFile(path, max_bytes);
  StripByteOrderMark(path, &text);
  return text;
}

void StripByteOrderMark(const std::string& path, std::string* start) {
  constexpr std::string_view kUtf8 = "\xef\xbb\xbf", kUtf16 = "\xff\xfe", kUtf16BigEndian = "\xfe\xff";
  if (StartsWith(*start, kUtf16) || StartsWith(*start, kUtf16BigEndian)) {
    throw Error(ErrorKind::kBadData, path + ": is text in UTF-16; expected UTF-8 or ASCII");
  }
  if (StartsWith(*start, kUtf8)) start->erase(0, kUtf8.size());
}

std::optional<std::string_view> TakeLine(std::string_view* rest) {
  if (rest->empty()) return std::nullopt;
  const auto is_end = [](char c) { return c == '\n' || c == '\r'; };
  const auto end = static_cast<std::size_t>(std::find_if(rest->begin(), rest->end(), is_end) - rest->begin());
  const std::string_view line = rest->substr(0, end);
  rest->remove_prefix(end);
  if (StartsWith(*rest, "\r\n")) rest->remove_prefix(1);
  if (!rest->empty()) rest->remove_prefix(1);
  return line;
}

std::string_view TakeWord(std::string_view* rest) {
  rest->remove_prefix(std::min(rest->find_first_not_of(" \t"), rest->size()));
  const std::string_view word = rest->substr(0, rest->find_first_of(" \t"));
  rest->remove_prefix(word.size());
  return word;
}

std::string_view Trimmed(std::string_view text) {
  constexpr char kBlanks[] = " \t";
  text.remove_prefix(std::min(text.find_first_not_of(kBlanks), text.size()));
  return text.substr(0, text.find_last_not_of(kBlanks) + 1);
}

std::vector<std::string> Split(std::string_view text, char separator) {
  std::vector<std::string> items;
  for (std::size_t end = text.find(separator); end != std::string_view::npos; end = text.find(separator)) {
    items.emplace_back(text.substr(0, end));
    text.remove_prefix(end + 1);
  }
  items.emplace_back(text);
  return items;
}

std::optional<double> ParseNumber(std::string_view text) {
  const std::optional<double> value = ParseWhole<double>(text);
  return value && std::isfinite(*value) ? value : std::nullopt;
}

std::optional<long long> ParseInteger(std::string_view text) { return ParseWhole<long long>(text); }

std::string ShortestText(double value) {
  char text[32];
  return {text, std::to_chars(text, text + sizeof(text), value).ptr};
}

std::string Printable(std::string_view text) {
  std::string result(text.substr(0, kMaxPrintable));
  for (char& c : result) {
    if (IsControl(static_cast<unsigned char>(c))) c = '?';
  }
  return text.size() > kMaxPrintable ? result + "..." : result;
}

std::string Escaped(std::string_view text) {
  constexpr char kDigits[] = "0123456789abcdef";
  std::string result;
  for (std::size_t i = 0; i < text.size(); ++i) {
    const unsigned char c = static_cast<unsigned char>(text[i]);
    const unsigned char next = i + 1 < text.size() ? static_cast<unsigned char>(text[i + 1]) : 0;
    const bool is_long_control = c == 0xc2 && next >= 0x80 && next < 0xa0;
    if (c == '\n') {
      result += "\\n";
    } else if (IsControl(c) || is_long_control) {
      const unsigned char code = is_long_control ? next : c;
      result += {'\\', 'x', kDigits[code >> 4], kDigits[code & 15]};
      i += is_long_control ? 1 : 0;
    } else {
      result += text[i];
    }
  }
  return result;
}

}  // namespace clothid

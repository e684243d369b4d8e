#include "sim/base/frame_names.h"

#include <algorithm>
#include <filesystem>
#include <iterator>
#include <map>
#include <numeric>
#include <optional>
#include <system_error>

#include "sim/base/error.h"

namespace clothid {
namespace {

namespace fs = std::filesystem;

bool IsDigit(char c) { return c >= '0' && c <= '9'; }

// Takes the digits off the front of `text`, and returns them without leading zeros.
std::string_view TakeDigits(std::string_view* text) {
  std::size_t end = 0;
  while (end < text->size() && IsDigit((*text)[end])) ++end;
  std::string_view digits = text->substr(0, end);
  text->remove_prefix(end);
  while (!digits.empty() && digits.front() == '0') digits.remove_prefix(1);
  return digits;
}

// Less than, equal to, or greater than 0, in natural order.
int CompareNaturally(std::string_view a, std::string_view b) {
  while (!a.empty() && !b.empty()) {
    if (IsDigit(a.front()) && IsDigit(b.front())) {
      const std::string_view left = TakeDigits(&a), right = TakeDigits(&b);
      if (left.size() != right.size()) return left.size() < right.size() ? -1 : 1;
      if (const int order = left.compare(right)) return order;
    } else {
      if (a.front() != b.front()) return a.substr(0, 1).compare(b.substr(0, 1));
      a.remove_prefix(1);
      b.remove_prefix(1);
    }
  }
  return a.empty() ? (b.empty() ? 0 : -1) : 1;
}

// A name with its runs of digits taken out of it.
struct NameParts {
  std::string text;                  // a '#' in place of every run
  std::vector<std::string> numbers;  // the runs, without leading zeros
};

NameParts SplitName(std::string_view name) {
  NameParts parts;
  while (!name.empty()) {
    if (IsDigit(name.front())) {
      parts.numbers.emplace_back(TakeDigits(&name));
      parts.text += '#';
    } else {
      parts.text += name.front();
      name.remove_prefix(1);
    }
  }
  return parts;
}

// The run of digits that names differ in; nothing where that is not one alone.
std::optional<std::size_t> RunThatDiffers(const std::vector<NameParts>& names) {
  std::optional<std::size_t> place;
  for (const NameParts& name : names) {
    if (name.text != names[0].text) return std::nullopt;
    for (std::size_t k = 0; k < name.numbers.size(); ++k) {
      if (name.numbers[k] == names[0].numbers[k]) continue;
      if (place.value_or(k) != k) return std::nullopt;
      place = k;
    }
  }
  return place;
}

// The name of a file with one run of '#'.
struct Pattern {
  std::string before, after;
  std::size_t width = 0;  // '#' in the run

  bool Matches(const std::string& name) const {
    if (name.size() <= before.size() + after.size()) return false;
    const std::string_view middle =
        std::string_view(name).substr(before.size(), name.size() - before.size() - after.size());
    return name.compare(0, before.size(), before) == 0 &&
           name.compare(name.size() - after.size(), after.size(), after) == 0 &&
           std::all_of(middle.begin(), middle.end(), IsDigit);
  }
};

Pattern SplitPattern(const std::string& path) {
  const std::string name = fs::path(path).filename().string();
  const std::size_t begin = name.find('#');
  const std::size_t end = std::min(name.find_first_not_of('#', begin), name.size());
  if (begin == std::string::npos || name.find('#', end) != std::string::npos) {
    throw Error(ErrorKind::kUsage, path + ": expected one run of '#' in the name of the file, like cloth_####.obj");
  }
  return {name.substr(0, begin), name.substr(end), end - begin};
}

bool HasExtension(const std::string& name, const std::string& extension) {
  if (name.front() == '.' || name.size() < extension.size()) return false;
  return std::equal(extension.rbegin(), extension.rend(), name.rbegin(), [](char expected, char found) {
    return expected == (found >= 'A' && found <= 'Z' ? found | 0x20 : found);
  });
}

}  // namespace

bool NaturalLess(std::string_view a, std::string_view b) {
  const int order = CompareNaturally(a, b);
  return order != 0 ? order < 0 : a < b;
}

bool IsFramePattern(const std::string& path) {
  return fs::path(path).filename().string().find('#') != std::string::npos;
}

std::vector<std::string> FramePaths(const std::string& path, const std::string& extension) {
  std::error_code error;
  const bool is_folder = fs::is_directory(path, error);
  const bool is_pattern = !is_folder && IsFramePattern(path);
  if (!is_folder && !is_pattern) return {path};
  const Pattern pattern = is_pattern ? SplitPattern(path) : Pattern();
  const fs::path folder = is_pattern ? fs::path(path).parent_path() : fs::path(path);
  std::vector<std::string> names;
  for (fs::directory_iterator entry(folder.empty() ? "." : folder, error); !error && entry != fs::directory_iterator();
       entry.increment(error)) {
    const std::string name = entry->path().filename().string();
    if (is_pattern ? pattern.Matches(name) : HasExtension(name, extension)) names.push_back(name);
  }
  if (error) throw Error(ErrorKind::kIo, folder.string() + ": cannot be read: " + error.message());
  if (names.empty()) {
    throw Error(ErrorKind::kUsage, path + ": expected files of a sequence, found none that " +
                                       (is_pattern ? "matches" : "ends in " + extension));
  }
  if (is_folder) ExpectOneSequence(path, names);
  std::sort(names.begin(), names.end(), &NaturalLess);
  const auto twin = std::adjacent_find(names.begin(), names.end(), [](const std::string& a, const std::string& b) {
    return CompareNaturally(a, b) == 0;
  });
  if (twin != names.end()) {
    throw Error(ErrorKind::kBadData, path + ": " + *twin + " and " + *(twin + 1) + " have the same number");
  }
  for (std::string& name : names) name = (folder / name).string();
  return names;
}

void ExpectOneSequence(const std::string& folder, std::vector<std::string> names) {
  std::sort(names.begin(), names.end(), &NaturalLess);  // folders list them in any order
  std::map<std::string, std::vector<std::string>> by_text;
  for (const std::string& name : names) by_text[SplitName(name).text].push_back(name);
  const auto fewer = [](const auto& a, const auto& b) { return a.second.size() < b.second.size(); };
  const auto most = std::max_element(by_text.begin(), by_text.end(), fewer);
  const bool is_numbered = most->first.find('#') != std::string::npos && most->second.size() > 1;
  if (by_text.size() == 1 || !is_numbered) return;
  const auto other = most == by_text.begin() ? std::next(most) : by_text.begin();
  throw Error(ErrorKind::kUsage, folder + ": " + other->second.front() + " is not numbered like " +
                                     most->second.front() + "; expected one sequence, or a pattern of its names");
}

std::vector<long long> FrameNumbers(const std::vector<std::string>& paths) {
  constexpr std::size_t kMaxDigits = 18;
  std::vector<NameParts> names;
  for (const std::string& path : paths) names.push_back(SplitName(path));
  const std::optional<std::size_t> place = RunThatDiffers(names);
  if (!place) return {};
  std::vector<long long> numbers;
  long long step = 0;
  for (const NameParts& name : names) {
    const std::string& digits = name.numbers[*place];
    if (digits.size() > kMaxDigits) return {};
    numbers.push_back(digits.empty() ? 0 : std::stoll(digits));
    step = std::gcd(step, numbers.back() - numbers.front());
  }
  const long long first = numbers.front();
  for (long long& number : numbers) number = (number - first) / step;
  return numbers.back() + 1 == static_cast<long long>(numbers.size()) ? std::vector<long long>() : numbers;
}

std::string FrameName(const std::string& path, long long number) {
  const Pattern pattern = SplitPattern(path);
  const std::string digits = std::to_string(number);
  return pattern.before + std::string(pattern.width - std::min(pattern.width, digits.size()), '0') + digits +
         pattern.after;
}

}  // namespace clothid

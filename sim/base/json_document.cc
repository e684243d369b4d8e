#include "sim/base/json_document.h"

#include <algorithm>
#include <cstdint>
#include <filesystem>
#include <iterator>
#include <limits>
#include <nlohmann/json.hpp>
#include <numeric>

#include "sim/base/error.h"
#include "sim/base/text_file.h"

namespace clothid {
namespace {

using Kind = JsonValue::Kind;

std::string Place(const std::string& source, int line) { return source + ":" + std::to_string(line) + ": "; }

// Where the parser stands in the text. Its lexer takes one character beyond a number, so a line end counts only when
// the character after it is taken.
struct Cursor {
  const char* next;
  int line = 1;
  bool at_line_end = false;

  void Advance() {
    if (at_line_end) ++line;
    at_line_end = *next == '\n';
    ++next;
  }
};

// Input iterator that moves a shared cursor: the parser copies its iterators, the cursor must be one.
class CountingIterator {
 public:
  using iterator_category = std::input_iterator_tag;
  using value_type = char;
  using difference_type = std::ptrdiff_t;
  using pointer = const char*;
  using reference = const char&;

  CountingIterator() = default;
  explicit CountingIterator(Cursor* cursor) : cursor_(cursor) {}
  CountingIterator(Cursor* cursor, const char* end) : cursor_(cursor), end_(end) {}

  reference operator*() const { return *cursor_->next; }
  CountingIterator& operator++() {
    cursor_->Advance();
    return *this;
  }
  // Compares a moving iterator with the end.
  bool operator==(const CountingIterator& other) const { return cursor_->next == (end_ ? end_ : other.end_); }
  bool operator!=(const CountingIterator& other) const { return !(*this == other); }

 private:
  Cursor* cursor_ = nullptr;
  const char* end_ = nullptr;
};

// Builds the tree from the parser's events.
class TreeBuilder : public nlohmann::json_sax<nlohmann::json> {
 public:
  TreeBuilder(const Cursor* cursor, const std::string& source) : cursor_(cursor), source_(source) {}

  JsonValue TakeRoot() { return std::move(root_); }

  bool null() override { return Add(Kind::kNull) != nullptr; }
  bool boolean(bool value) override {
    Add(Kind::kBoolean)->boolean = value;
    return true;
  }
  bool number_integer(std::int64_t value) override {
    AddNumber(static_cast<double>(value))->integer = value;
    return true;
  }
  bool number_unsigned(std::uint64_t value) override {
    JsonValue* number = AddNumber(static_cast<double>(value));
    if (value <= static_cast<std::uint64_t>(std::numeric_limits<long long>::max())) {
      number->integer = static_cast<long long>(value);
    }
    return true;
  }
  bool number_float(double value, const std::string&) override { return AddNumber(value) != nullptr; }
  bool string(std::string& value) override {
    Add(Kind::kString)->text = std::move(value);
    return true;
  }
  bool binary(nlohmann::json::binary_t&) override { return false; }
  bool start_object(std::size_t) override { return Open(Kind::kObject); }
  bool start_array(std::size_t) override { return Open(Kind::kArray); }
  bool end_array() override {
    open_.pop_back();
    return true;
  }
  bool end_object() override {
    RejectDuplicateKeys(*open_.back());
    open_.pop_back();
    return true;
  }
  bool key(std::string& name) override {
    open_.back()->keys.push_back(std::move(name));
    key_line_ = cursor_->line;
    return true;
  }
  bool parse_error(std::size_t, const std::string&, const nlohmann::detail::exception& error) override {
    // "[json.exception.parse_error.101] parse error at line 1, column 2: what is wrong"
    std::string message = error.what();
    message.erase(0, message.find("] ") + 2);
    if (message.compare(0, 11, "parse error") == 0) message.erase(0, message.find(": ") + 2);
    throw Error(ErrorKind::kBadData, Place(source_, cursor_->line) + "not valid JSON: " + Printable(message));
  }

 private:
  JsonValue* Add(Kind kind) {
    if (++num_values_ > kMaxJsonValues) {
      throw Error(ErrorKind::kBadData, Place(source_, cursor_->line) + "more than " + std::to_string(kMaxJsonValues) +
                                           " values in one JSON text");
    }
    JsonValue* value = &root_;
    if (!open_.empty()) value = &open_.back()->items.emplace_back();
    value->kind = kind;
    value->line = !open_.empty() && open_.back()->kind == Kind::kObject ? key_line_ : cursor_->line;
    return value;
  }

  JsonValue* AddNumber(double number) {
    JsonValue* value = Add(Kind::kNumber);
    value->number = number;
    return value;
  }

  // Items of an open value are never moved: its parent grows only after it is closed.
  bool Open(Kind kind) {
    if (open_.size() == kMaxJsonDepth) {
      throw Error(ErrorKind::kBadData,
                  Place(source_, cursor_->line) + "nested deeper than " + std::to_string(kMaxJsonDepth) + " levels");
    }
    open_.push_back(Add(kind));
    return true;
  }

  void RejectDuplicateKeys(const JsonValue& object) const {
    std::vector<std::size_t> order(object.keys.size());
    std::iota(order.begin(), order.end(), std::size_t{0});
    std::stable_sort(order.begin(), order.end(),
                     [&](std::size_t a, std::size_t b) { return object.keys[a] < object.keys[b]; });
    for (std::size_t i = 1; i < order.size(); ++i) {
      if (object.keys[order[i]] != object.keys[order[i - 1]]) continue;
      throw Error(ErrorKind::kBadData,
                  Place(source_, object.items[order[i]].line) + "key '" + Printable(object.keys[order[i]]) +
                      "': expected once, stands already in line " + std::to_string(object.items[order[i - 1]].line));
    }
  }

  const Cursor* cursor_;
  const std::string& source_;
  JsonValue root_;
  std::vector<JsonValue*> open_;
  int key_line_ = 1;
  std::size_t num_values_ = 0;
};

std::string Joined(const std::vector<const char*>& words) {
  std::string result;
  for (const char* word : words) result += (result.empty() ? "" : ", ") + std::string(word);
  return result;
}

}  // namespace

JsonValue ParseJson(const std::string& text, const std::string& source, std::size_t max_bytes) {
  if (text.size() > max_bytes) {
    throw Error(ErrorKind::kBadData, source + ": is longer than " + std::to_string(max_bytes) + " bytes of JSON");
  }
  Cursor cursor{text.data()};
  TreeBuilder builder(&cursor, source);
  nlohmann::json::sax_parse(CountingIterator(&cursor), CountingIterator(&cursor, text.data() + text.size()), &builder);
  return builder.TakeRoot();
}

void JsonNode::Fail(const std::string& message) const {
  const std::string key = path_.empty() ? "" : "key '" + path_ + "': ";
  throw Error(ErrorKind::kBadData, Place(*source_, value_->line) + key + message);
}

void JsonNode::Expect(Kind kind, const char* expected) const {
  if (!is(kind)) Fail(std::string("expected ") + expected);
}

void JsonNode::ExpectKeys(const std::vector<const char*>& known) const {
  for (const std::string& key : keys()) {
    if (std::find(known.begin(), known.end(), key) == known.end()) {
      Find(key)->Fail("unknown key; expected one of " + Joined(known));
    }
  }
}

const std::vector<std::string>& JsonNode::keys() const {
  Expect(Kind::kObject, "an object");
  return value_->keys;
}

std::optional<JsonNode> JsonNode::Find(const std::string& key) const {
  const auto found = std::find(keys().begin(), keys().end(), key);
  if (found == keys().end()) return std::nullopt;
  const JsonValue& item = value_->items[static_cast<std::size_t>(found - keys().begin())];
  return JsonNode(item, *source_, (path_.empty() ? "" : path_ + ".") + Printable(key));
}

JsonNode JsonNode::Require(const std::string& key, const std::string& expected) const {
  const std::optional<JsonNode> found = Find(key);
  if (found) return *found;
  const std::string path = path_.empty() ? key : path_ + "." + key;
  throw Error(ErrorKind::kBadData,
              Place(*source_, value_->line) + "key '" + path + "': is missing; expected " + expected);
}

std::vector<JsonNode> JsonNode::items() const {
  Expect(Kind::kArray, "an array");
  std::vector<JsonNode> nodes;
  for (std::size_t i = 0; i < value_->items.size(); ++i) {
    nodes.push_back(JsonNode(value_->items[i], *source_, path_ + "[" + std::to_string(i) + "]"));
  }
  return nodes;
}

double JsonNode::Number() const {
  Expect(Kind::kNumber, "a number");
  return value_->number;
}

double JsonNode::PositiveNumber() const {
  if (!is(Kind::kNumber) || !(value_->number > 0.0)) Fail("expected a number > 0");
  return value_->number;
}

double JsonNode::NonNegativeNumber() const {
  if (!is(Kind::kNumber) || !(value_->number >= 0.0)) Fail("expected a number >= 0");
  return value_->number;
}

int JsonNode::Integer(int minimum, int maximum) const { return static_cast<int>(LongInteger(minimum, maximum)); }

long long JsonNode::LongInteger(long long minimum, long long maximum) const {
  const std::optional<long long>& integer = value_->integer;
  if (!integer || *integer < minimum || *integer > maximum) {
    const std::string found = integer ? ", found " + std::to_string(*integer) : "";
    Fail("expected an integer from " + std::to_string(minimum) + " to " + std::to_string(maximum) + found);
  }
  return *integer;
}

bool JsonNode::Boolean() const {
  Expect(Kind::kBoolean, "true or false");
  return value_->boolean;
}

const std::string& JsonNode::String() const {
  Expect(Kind::kString, "a string");
  return value_->text;
}

std::string JsonNode::Path(const std::string& folder) const {
  if (String().empty()) Fail("expected the name of a file");
  return (std::filesystem::path(folder) / String()).string();
}

Eigen::Vector3d JsonNode::Vector3() const {
  if (!is(Kind::kArray) || value_->items.size() != 3) Fail("expected an array of three numbers");
  const std::vector<JsonNode> numbers = items();
  return {numbers[0].Number(), numbers[1].Number(), numbers[2].Number()};
}

}  // namespace clothid

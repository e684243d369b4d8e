// A JSON text as a tree that knows its lines, and typed access to it whose errors name key and line:
// "scene.json:12: key 'obstacles[0].mu': expected a number >= 0".
#ifndef CLOTHID_SIM_BASE_JSON_DOCUMENT_H_
#define CLOTHID_SIM_BASE_JSON_DOCUMENT_H_

#include <Eigen/Core>
#include <cstddef>
#include <optional>
#include <string>
#include <vector>

namespace clothid {

struct JsonValue {
  enum class Kind { kNull, kBoolean, kNumber, kString, kArray, kObject };

  Kind kind = Kind::kNull;
  int line = 1;  // of the key, for a member of an object; else of the value
  bool boolean = false;
  double number = 0.0;               // finite
  std::optional<long long> integer;  // of a number written without fraction and exponent
  std::string text;
  std::vector<std::string> keys;  // of an object, one per item
  std::vector<JsonValue> items;   // of an array or object
};

inline constexpr std::size_t kMaxJsonBytes = std::size_t{16} << 20;
inline constexpr std::size_t kMaxJsonDepth = 64;  // levels of arrays and objects
inline constexpr std::size_t kMaxJsonValues = 1000000;

// Throws `Error` (kBadData) of the form "SOURCE:LINE: ..." for text that is not JSON, holds a key twice or a number
// that no double can hold, is longer than `max_bytes`, deeper than kMaxJsonDepth or of more than kMaxJsonValues.
JsonValue ParseJson(const std::string& text, const std::string& source, std::size_t max_bytes = kMaxJsonBytes);

// A value of a document together with the path of its key. Does not own the value. Every accessor throws `Error`
// (kBadData) when the value is not what it is asked for.
class JsonNode {
 public:
  JsonNode(const JsonValue& value, const std::string& source) : JsonNode(value, source, "") {}

  const std::string& path() const { return path_; }  // "obstacles[0].mu"; empty at the root
  bool is(JsonValue::Kind kind) const { return value_->kind == kind; }

  // "SOURCE:LINE: key 'PATH': MESSAGE".
  [[noreturn]] void Fail(const std::string& message) const;

  // The value must be an object without any other key.
  void ExpectKeys(const std::vector<const char*>& known) const;
  std::optional<JsonNode> Find(const std::string& key) const;
  // `expected` completes the message where the key is missing: "expected " + `expected`.
  JsonNode Require(const std::string& key, const std::string& expected) const;
  const std::vector<std::string>& keys() const;  // of an object, in the order of the text
  std::vector<JsonNode> items() const;           // of an array

  double Number() const;
  double PositiveNumber() const;
  double NonNegativeNumber() const;
  int Integer(int minimum, int maximum) const;
  long long LongInteger(long long minimum, long long maximum) const;
  bool Boolean() const;
  const std::string& String() const;
  std::string Path(const std::string& folder) const;  // of the file that the value names, relative to `folder`
  Eigen::Vector3d Vector3() const;

 private:
  JsonNode(const JsonValue& value, const std::string& source, std::string path)
      : value_(&value), source_(&source), path_(std::move(path)) {}

  void Expect(JsonValue::Kind kind, const char* expected) const;

  const JsonValue* value_;
  const std::string* source_;
  std::string path_;
};

}  // namespace clothid

#endif  // CLOTHID_SIM_BASE_JSON_DOCUMENT_H_

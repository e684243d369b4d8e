#include "datasets/files/safetensors.h"

#include <algorithm>
#include <cerrno>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <limits>
#include <nlohmann/json.hpp>

#include "datasets/files/file_kind.h"
#include "sim/base/error.h"
#include "sim/base/json_document.h"
#include "sim/base/text_file.h"

#if !defined(__BYTE_ORDER__) || __BYTE_ORDER__ != __ORDER_LITTLE_ENDIAN__
#error "tensors are copied as they stand in the file, which is little-endian"
#endif

namespace clothid {
namespace {

constexpr std::size_t kLengthSize = 8;

struct TypeName {
  TensorType type;
  const char* name;
  std::size_t size;
};

constexpr TypeName kTypes[] = {
    {TensorType::kF32, "F32", 4}, {TensorType::kF64, "F64", 8}, {TensorType::kI32, "I32", 4}};

const TypeName& Describe(TensorType type) {
  return *std::find_if(std::begin(kTypes), std::end(kTypes), [&](const TypeName& t) { return t.type == type; });
}

std::uint64_t FileSize(const std::string& path) {
  std::error_code error;
  const auto status = std::filesystem::status(path, error);
  if (!error && std::filesystem::exists(status) && !std::filesystem::is_regular_file(status)) {
    throw Error(ErrorKind::kIo, path + ": cannot be read: is not a regular file");
  }
  const std::uint64_t size = std::filesystem::file_size(path, error);
  if (error) throw Error(ErrorKind::kIo, path + ": cannot be read: " + error.message());
  return size;
}

std::string ReadBytes(std::ifstream* file, const std::string& path, std::uint64_t count) {
  std::string bytes(count, '\0');
  if (!file->read(bytes.data(), static_cast<std::streamsize>(count))) {
    throw Error(ErrorKind::kIo, path + ": cannot be read to its end");
  }
  return bytes;
}

// Where the first bytes tell that the file is another's.
void RefuseOtherKinds(const std::string& start, const std::string& path) {
  const std::string kind = FileKind(start);
  if (!kind.empty()) FailOnData(path, "is " + kind + "; expected a recording, motion.bin");
}

std::uint64_t HeaderLength(const std::string& start, const std::string& path, std::uint64_t file_size) {
  std::uint64_t length = 0;
  std::memcpy(&length, start.data(), kLengthSize);
  const std::uint64_t limit = std::min(file_size - kLengthSize, kMaxHeaderBytes);
  if (length > limit || (start.size() > kLengthSize && start[kLengthSize] != '{')) RefuseOtherKinds(start, path);
  if (length > limit) {
    FailOnData(path, "its header claims " + std::to_string(length) + " bytes; expected at most " +
                         std::to_string(limit) + " in this file");
  }
  return length;
}

TensorType ReadType(const JsonNode& node) {
  for (const TypeName& type : kTypes) {
    if (node.String() == type.name) return type.type;
  }
  node.Fail("expected F32, F64 or I32, found " + Printable(node.String()));
}

// The number of bytes that a shape asks for; it is bounded by `limit` before it is multiplied.
std::size_t ShapeBytes(const JsonNode& node, std::size_t element_size, std::size_t limit,
                       std::vector<long long>* shape) {
  std::size_t bytes = element_size;
  for (const JsonNode& item : node.items()) {
    const long long size = item.LongInteger(0, std::numeric_limits<long long>::max());
    if (size > 0 && bytes > limit / static_cast<std::size_t>(size)) {
      node.Fail("its elements take more than the " + std::to_string(limit) + " bytes of data in the file");
    }
    bytes *= static_cast<std::size_t>(size);
    shape->push_back(size);
  }
  return bytes;
}

TensorInfo ReadTensorInfo(const JsonNode& node, std::size_t data_size) {
  node.ExpectKeys({"dtype", "shape", "data_offsets"});
  TensorInfo tensor;
  tensor.type = ReadType(node.Require("dtype", "F32, F64 or I32"));
  const std::size_t bytes =
      ShapeBytes(node.Require("shape", "an array of integers"), Describe(tensor.type).size, data_size, &tensor.shape);
  const JsonNode offsets = node.Require("data_offsets", "[begin, end]");
  const std::vector<JsonNode> ends = offsets.items();
  if (ends.size() != 2) offsets.Fail("expected [begin, end]");
  tensor.begin = static_cast<std::size_t>(ends[0].LongInteger(0, static_cast<long long>(data_size)));
  tensor.end = static_cast<std::size_t>(ends[1].LongInteger(0, static_cast<long long>(data_size)));
  if (tensor.end < tensor.begin || tensor.end - tensor.begin != bytes) {
    offsets.Fail("expected a range of the " + std::to_string(bytes) + " bytes that type and shape ask for");
  }
  return tensor;
}

// Of an object, not too many of them.
const std::vector<std::string>& CheckedKeys(const JsonNode& node) {
  if (node.keys().size() > kMaxHeaderKeys) node.Fail("expected at most " + std::to_string(kMaxHeaderKeys) + " keys");
  return node.keys();
}

void ReadHeader(const JsonNode& root, std::size_t data_size, Safetensors* result) {
  for (const std::string& name : CheckedKeys(root)) {
    const JsonNode node = *root.Find(name);
    if (name == "__metadata__") {
      for (const std::string& key : CheckedKeys(node)) result->metadata[key] = node.Find(key)->String();
    } else {
      result->tensors[name] = ReadTensorInfo(node, data_size);
    }
  }
}

void ExpectFullCover(const Safetensors& file, std::size_t data_size, const std::string& path) {
  std::vector<std::pair<std::string, TensorInfo>> order(file.tensors.begin(), file.tensors.end());
  std::sort(order.begin(), order.end(), [](const auto& a, const auto& b) {
    return std::make_pair(a.second.begin, a.second.end) < std::make_pair(b.second.begin, b.second.end);
  });
  std::size_t end = 0;
  for (const auto& [name, tensor] : order) {
    if (tensor.begin != end) {
      FailOnData(path, "tensor '" + Printable(name) + "': expected its data to begin at byte " + std::to_string(end) +
                           ", where the one before it ends, found " + std::to_string(tensor.begin));
    }
    end = tensor.end;
  }
  if (end != data_size) {
    FailOnData(path, "expected " + std::to_string(end) + " bytes of tensors, found " + std::to_string(data_size));
  }
}

}  // namespace

const char* TensorTypeName(TensorType type) { return Describe(type).name; }

std::size_t TensorInfo::num_elements() const { return (end - begin) / Describe(type).size; }

Safetensors ReadSafetensors(const std::string& path) {
  const std::uint64_t file_size = FileSize(path);
  std::ifstream file(path, std::ios::binary);
  if (!file) throw Error(ErrorKind::kIo, path + ": cannot be read: " + std::strerror(errno));
  if (file_size > kMaxContainerBytes) {
    FailOnData(path, "is larger than " + std::to_string(kMaxContainerBytes) + " bytes");
  }
  if (file_size < kLengthSize) FailOnData(path, "is shorter than the 8 bytes of a header length");
  Safetensors result;
  const std::string start = ReadBytes(&file, path, std::min<std::uint64_t>(file_size, kKindBytes));
  const std::uint64_t header_size = HeaderLength(start, path, file_size);
  file.seekg(kLengthSize);
  result.length_bytes = start.substr(0, kLengthSize);
  result.header = ReadBytes(&file, path, header_size);
  const std::size_t data_size = file_size - kLengthSize - header_size;
  const std::string source = path + ": header";
  const JsonValue document = ParseJson(result.header, source, kMaxHeaderBytes);
  ReadHeader(JsonNode(document, source), data_size, &result);
  ExpectFullCover(result, data_size, path);
  result.data = ReadBytes(&file, path, data_size);
  return result;
}

std::string SafetensorsHeader(const std::vector<std::pair<std::string, std::string>>& metadata,
                              const std::vector<TensorBytes>& tensors) {
  nlohmann::ordered_json header;
  for (const auto& [key, value] : metadata) header["__metadata__"][key] = value;
  std::size_t begin = 0;
  for (const TensorBytes& tensor : tensors) {
    const std::size_t end = begin + tensor.bytes.size();
    header[tensor.name] = {
        {"dtype", TensorTypeName(tensor.type)}, {"shape", tensor.shape}, {"data_offsets", {begin, end}}};
    begin = end;
  }
  // Strings of the user's that are not UTF-8 lose the odd byte rather than the file.
  std::string text = header.dump(-1, ' ', false, nlohmann::ordered_json::error_handler_t::replace);
  text.resize((text.size() + 7) / 8 * 8, ' ');
  return text;
}

std::string LengthBytes(std::size_t length) {
  const std::uint64_t value = length;
  std::string bytes(kLengthSize, '\0');
  std::memcpy(bytes.data(), &value, kLengthSize);
  return bytes;
}

}  // namespace clothid

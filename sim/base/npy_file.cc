#include "sim/base/npy_file.h"

#include <algorithm>
#include <cstdint>
#include <limits>
#include <string_view>
#include <type_traits>

#include "sim/base/byte_order.h"
#include "sim/base/error.h"
#include "sim/base/npy_header.h"
#include "sim/base/text_file.h"

namespace clothid {
namespace {

// `values` in Fortran order (the first index runs fastest) put into C order (the last one does).
template <typename Value>
std::vector<Value> InCOrder(const std::vector<Value>& values, const std::vector<long long>& shape) {
  std::vector<std::size_t> strides, index(shape.size(), 0);
  std::size_t stride = 1;
  for (const long long size : shape) {
    strides.push_back(stride);
    stride *= static_cast<std::size_t>(size);
  }
  std::vector<Value> ordered;
  ordered.reserve(values.size());
  std::size_t position = 0;
  while (ordered.size() < values.size()) {
    ordered.push_back(values[position]);
    for (std::size_t axis = shape.size(); axis-- > 0;) {
      position += strides[axis];
      if (++index[axis] < static_cast<std::size_t>(shape[axis])) break;
      position -= strides[axis] * index[axis];
      index[axis] = 0;
    }
  }
  return ordered;
}

// The numbers behind a header.
template <typename Value>
class NumberReader {
 public:
  NumberReader(const std::string& path, const NpyHeader& header, std::string_view data)
      : path_(path), header_(header), data_(data), count_(Count()) {}

  template <typename Stored>
  std::vector<Value> Read() const {
    if (data_.size() != count_ * sizeof(Stored)) {
      Fail("expected " + std::to_string(count_ * sizeof(Stored)) + " bytes of data, found " +
           std::to_string(data_.size()));
    }
    const ByteOrder order = header_.descr.front() == '>' ? ByteOrder::kBig : ByteOrder::kLittle;
    std::vector<Value> values(count_);
    for (std::size_t i = 0; i < count_; ++i) {
      const Stored stored = LoadNumber<Stored>(data_.data() + i * sizeof(Stored), order);
      if constexpr (std::is_same_v<Stored, std::uint64_t>) {
        if (stored > std::numeric_limits<std::int64_t>::max()) Fail("holds integers above 2^63 - 1");
      }
      values[i] = static_cast<Value>(stored);
    }
    return header_.fortran_order ? InCOrder(values, header_.shape) : values;
  }

  // The type of the elements without the byte order, "f8"; empty where that is none of '<', '>', '|'.
  std::string_view Type() const {
    const std::string_view descr = header_.descr;
    return descr.empty() || std::string_view("<>|").find(descr.front()) == std::string_view::npos ? std::string_view()
                                                                                                  : descr.substr(1);
  }

  [[noreturn]] void Fail(const std::string& message) const { throw Error(ErrorKind::kBadData, path_ + ": " + message); }

  [[noreturn]] void FailOfType(const std::string& expected) const {
    Fail("expected elements of type " + expected + ", found '" + Printable(header_.descr) + "'");
  }

 private:
  // The number of elements, at most one per byte of the data.
  std::size_t Count() const {
    if (std::find(header_.shape.begin(), header_.shape.end(), 0) != header_.shape.end()) return 0;
    unsigned long long count = 1;
    for (const long long size : header_.shape) {
      if (count > data_.size() / static_cast<unsigned long long>(size)) {
        Fail("its shape is larger than its data");
      }
      count *= static_cast<unsigned long long>(size);
    }
    return count;
  }

  const std::string& path_;
  const NpyHeader& header_;
  const std::string_view data_;
  const std::size_t count_;
};

std::vector<double> ReadFloats(const NumberReader<double>& reader) {
  if (reader.Type() == "f8") return reader.Read<double>();
  if (reader.Type() == "f4") return reader.Read<float>();
  reader.FailOfType("'<f4', '<f8', '>f4' or '>f8'");
}

std::vector<long long> ReadIntegers(const NumberReader<long long>& reader) {
  const std::string_view type = reader.Type();
  if (type == "i8") return reader.Read<std::int64_t>();
  if (type == "i4") return reader.Read<std::int32_t>();
  if (type == "i2") return reader.Read<std::int16_t>();
  if (type == "i1") return reader.Read<std::int8_t>();
  if (type == "u8") return reader.Read<std::uint64_t>();
  if (type == "u4") return reader.Read<std::uint32_t>();
  if (type == "u2") return reader.Read<std::uint16_t>();
  if (type == "u1") return reader.Read<std::uint8_t>();
  reader.FailOfType("an integer like '<i4' or '<i8'");
}

// Reads a file with `read_values`, which takes a NumberReader.
template <typename Array, typename Value>
Array ReadArray(const std::string& path, std::vector<Value> (*read_values)(const NumberReader<Value>&)) {
  const std::string bytes = ReadFile(path, kMaxNpyBytes);
  const NpyHeader header = ReadNpyHeader(path, bytes);
  const NumberReader<Value> reader(path, header, std::string_view(bytes).substr(header.size));
  return {header.shape, read_values(reader)};
}

template <typename Array>
std::string Bytes(const std::string& descr, const Array& array) {
  std::string bytes = NpyHeaderBytes(descr, array.shape);
  bytes.append(reinterpret_cast<const char*>(array.values.data()), array.values.size() * sizeof(array.values[0]));
  return bytes;
}

}  // namespace

NpyArray ReadNpy(const std::string& path) { return ReadArray<NpyArray>(path, &ReadFloats); }

NpyIntegers ReadNpyIntegers(const std::string& path) { return ReadArray<NpyIntegers>(path, &ReadIntegers); }

std::string NpyBytes(const NpyArray& array) { return Bytes("<f8", array); }

std::string NpyBytes(const NpyIntegers& array) { return Bytes("<i8", array); }

}  // namespace clothid

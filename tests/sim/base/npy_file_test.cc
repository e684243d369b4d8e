// .npy files byte by byte, as NumPy writes them, and what is refused.
#include "sim/base/npy_file.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <limits>
#include <string>
#include <vector>

#include "tests/expect_error.h"
#include "tests/temporary_folder.h"

namespace clothid::npy_file_test {
namespace {

// The bytes of a file of this version: the header is padded with blanks to a multiple of 64 bytes and ends in a
// newline.
std::string Npy(char version, std::string header, const std::string& data) {
  const std::size_t begin = version == 1 ? 10 : 12;
  while ((begin + header.size() + 1) % 64 != 0) header += ' ';
  header += '\n';
  std::string bytes = std::string("\x93NUMPY") + version + '\0';
  bytes += static_cast<char>(header.size() & 255);
  bytes += static_cast<char>(header.size() >> 8);
  if (version > 1) bytes.append(2, '\0');
  return bytes + header + data;
}

template <typename T>
std::string Raw(const std::vector<T>& values, bool is_big_endian = false) {
  std::string bytes;
  for (const T value : values) {
    std::string number(reinterpret_cast<const char*>(&value), sizeof(T));
    if (is_big_endian) std::reverse(number.begin(), number.end());
    bytes += number;
  }
  return bytes;
}

class NpyFileTest : public testing::Test {
 protected:
  NpyArray Read(const std::string& bytes) const { return ReadNpy(folder_.Write("array.npy", bytes)); }
  NpyIntegers ReadInts(const std::string& bytes) const { return ReadNpyIntegers(folder_.Write("array.npy", bytes)); }
  void ExpectRefused(const std::string& bytes, const char* reason) const {
    ExpectError([&] { Read(bytes); }, ErrorKind::kBadData, {"array.npy: ", reason});
  }

  TemporaryFolder folder_;
};

// np.save of np.array([[1.5, -2]]), byte by byte.
TEST_F(NpyFileTest, ReadsTheBytesOfNumPy) {
  std::string bytes("\x93NUMPY\x01\x00\x76\x00", 10);
  bytes += "{'descr': '<f8', 'fortran_order': False, 'shape': (1, 2), }";
  bytes.append(128 - 1 - bytes.size(), ' ');
  bytes += '\n';
  bytes.append("\x00\x00\x00\x00\x00\x00\xf8\x3f\x00\x00\x00\x00\x00\x00\x00\xc0", 16);
  const NpyArray array = Read(bytes);
  EXPECT_EQ(array.shape, (std::vector<long long>{1, 2}));
  EXPECT_EQ(array.values, (std::vector<double>{1.5, -2.0}));
  EXPECT_EQ(NpyBytes(array).substr(128), bytes.substr(128));
}

TEST_F(NpyFileTest, ReadsEveryVersionTypeAndByteOrder) {
  const std::vector<double> expected = {0.0, 0.5, -3.0, 4.0, 5.0, 6.25};
  const std::vector<float> single(expected.begin(), expected.end());
  for (const char version : {'\1', '\2', '\3'}) {
    for (const bool is_big : {false, true}) {
      for (const bool is_single : {false, true}) {
        const std::string descr = std::string(is_big ? ">" : "<") + (is_single ? "f4" : "f8");
        const std::string header = "{'descr': '" + descr + "', 'fortran_order': False, 'shape': (2, 3), }";
        const NpyArray array = Read(Npy(version, header, is_single ? Raw(single, is_big) : Raw(expected, is_big)));
        EXPECT_EQ(array.values, expected) << descr << " version " << int{version};
        EXPECT_EQ(array.shape, (std::vector<long long>{2, 3}));
      }
    }
  }
}

// Element (i, j, k) of shape (2, 3, 4) is 100 i + 10 j + k; in Fortran order the first index runs fastest.
TEST_F(NpyFileTest, PutsFortranOrderIntoCOrder) {
  std::vector<double> fortran, c_order;
  for (int k = 0; k < 4; ++k) {
    for (int j = 0; j < 3; ++j) {
      for (int i = 0; i < 2; ++i) fortran.push_back(100 * i + 10 * j + k);
    }
  }
  for (int i = 0; i < 2; ++i) {
    for (int j = 0; j < 3; ++j) {
      for (int k = 0; k < 4; ++k) c_order.push_back(100 * i + 10 * j + k);
    }
  }
  const std::string header = "{'descr': '>f8', 'fortran_order': True, 'shape': (2, 3, 4), }";
  EXPECT_EQ(Read(Npy(2, header, Raw(fortran, true))).values, c_order);
  EXPECT_EQ(Read(Npy(1, "{'descr': '<f8', 'fortran_order': True, 'shape': (3,), }", Raw<double>({1, 2, 3}))).values,
            (std::vector<double>{1, 2, 3}));
  EXPECT_EQ(Read(Npy(1, "{'descr': '<f8', 'fortran_order': True, 'shape': (), }", Raw<double>({7}))).values,
            (std::vector<double>{7}));
  EXPECT_TRUE(Read(Npy(1, "{'descr': '<f8', 'fortran_order': True, 'shape': (3, 0), }", "")).values.empty());
}

TEST_F(NpyFileTest, ReadsHeadersWrittenOtherwise) {
  const std::string data = Raw<double>({1, 2});
  for (const char* header : {"{'shape':(2,),'fortran_order':False,'descr':'<f8'}",
                             "{\"descr\": \"<f8\", \"shape\": (2L,), \"fortran_order\": False, }",
                             "\t{ 'fortran_order' : False , 'descr' : '<f8' , 'shape' : ( 2 , ) }  "}) {
    EXPECT_EQ(Read(Npy(1, header, data)).shape, std::vector<long long>{2}) << header;
  }
}

TEST_F(NpyFileTest, ReadsIntegersOfEverySize) {
  const auto read = [&](const std::string& descr, const std::string& data) {
    return ReadInts(Npy(1, "{'descr': '" + descr + "', 'fortran_order': False, 'shape': (2,), }", data)).values;
  };
  const std::vector<long long> expected = {-3, 7}, positive = {200, 7};
  EXPECT_EQ(read("|i1", Raw<std::int8_t>({-3, 7})), expected);
  EXPECT_EQ(read("<i2", Raw<std::int16_t>({-3, 7})), expected);
  EXPECT_EQ(read(">i4", Raw<std::int32_t>({-3, 7}, true)), expected);
  EXPECT_EQ(read("<i8", Raw<std::int64_t>({-3, 7})), expected);
  EXPECT_EQ(read("|u1", Raw<std::uint8_t>({200, 7})), positive);
  EXPECT_EQ(read(">u2", Raw<std::uint16_t>({200, 7}, true)), positive);
  EXPECT_EQ(read("<u4", Raw<std::uint32_t>({200, 7})), positive);
  EXPECT_EQ(read("<u8", Raw<std::uint64_t>({200, 7})), positive);
  ExpectError([&] { read("<u8", Raw<std::uint64_t>({1ull << 63, 7})); }, ErrorKind::kBadData, {"above 2^63"});
  ExpectError([&] { read("<f8", Raw<double>({1, 7})); }, ErrorKind::kBadData, {"array.npy: expected", "'<f8'"});
}

TEST_F(NpyFileTest, WritesWhatItReads) {
  const NpyArray array = {{2, 1, 2}, {0.1, std::numeric_limits<double>::quiet_NaN(), -1e300, 5e-324}};
  const std::string bytes = NpyBytes(array);
  EXPECT_EQ((bytes.size() - 4 * sizeof(double)) % 64, 0u);
  const NpyArray again = Read(bytes);
  EXPECT_EQ(again.shape, array.shape);
  EXPECT_TRUE(std::isnan(again.values[1]));
  for (const std::size_t i : {0, 2, 3}) EXPECT_EQ(again.values[i], array.values[i]);
  const NpyIntegers integers = {{3}, {-1, 0, 1ll << 40}};
  EXPECT_EQ(ReadInts(NpyBytes(integers)).values, integers.values);
}

TEST_F(NpyFileTest, RefusesWhatIsNoSuchArray) {
  const std::string data = Raw<double>({1, 2});
  const auto expect = [&](const std::string& header, const char* reason) {
    ExpectRefused(Npy(1, header, data), reason);
  };
  ExpectRefused("", "is not a .npy file");
  ExpectRefused("\x93NUMPZ\x01", "is not a .npy file");
  ExpectRefused(Npy(4, "{}", data), "version 1, 2 or 3");
  ExpectRefused(std::string("\x93NUMPY\x02\x00\xff\xff\xff\xff{}", 14), "ends within its header");
  expect("['descr', '<f8']", "expected a header");
  expect("{'descr': '<f8', 'fortran_order': False}", "lacks 'shape'");
  expect("{'descr': '<f8', 'shape': (2,)}", "lacks 'fortran_order'");
  expect("{'descr': '<f8', 'fortran_order': False, 'shape': (2,), 'more': 1}", "unexpected key 'more'");
  expect("{'descr': '<f8', 'fortran_order': 0, 'shape': (2,)}", "True or False");
  expect("{'descr': [('x', '<f8')], 'fortran_order': False, 'shape': (2,)}", "the type of its elements");
  expect("{'descr': '|O', 'fortran_order': False, 'shape': (2,)}", "'|O'");
  expect("{'descr': '=f8', 'fortran_order': False, 'shape': (2,)}", "'=f8'");
  expect("{'descr': '', 'fortran_order': False, 'shape': (2,)}", "''");
  expect("{'descr': '<f8', 'fortran_order': False, 'shape': 2}", "a shape like");
  expect("{'descr': '<f8', 'fortran_order': False, 'shape': (-2,)}", "integers >= 0");
  expect("{'descr': '<f8', 'fortran_order': False, 'shape': (__import__('os'),)}", "integers >= 0");
  expect("{'descr': '<f8', 'fortran_order': False, 'shape': (2, 2)}", "expected 32 bytes of data, found 16");
  expect("{'descr': '<f8', 'fortran_order': False, 'shape': (99999999, 99999999)}", "its shape is larger");
  expect("{'descr': '<f8', 'fortran_order': False, 'shape': (2,)} x", "blanks after");
  expect("{'descr': '<f8', 'fortran_order': False, 'shape': (2,) 'x'", "',' or '}'");
  std::string many = "{'descr': '<f8', 'fortran_order': False, 'shape': (";
  for (int i = 0; i < 33; ++i) many += "1,";
  expect(many + ")}", "more than 32 axes");
}

TEST_F(NpyFileTest, RefusesEveryTruncation) {
  const std::string whole =
      Npy(2, "{'descr': '<f4', 'fortran_order': True, 'shape': (1, 2), }", Raw<float>({1.0f, 2.0f}));
  for (std::size_t length = 0; length < whole.size(); ++length) ExpectRefused(whole.substr(0, length), "");
  EXPECT_NO_THROW(Read(whole));
}

}  // namespace
}  // namespace clothid::npy_file_test

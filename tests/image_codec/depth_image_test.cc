// Depth in the file formats that recorders write it in, by files made here byte for byte or by
// OpenCV.
#include "deepslam/image_codec/depth_image.h"

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <cstring>
#include <functional>
#include <vector>

#include <fmt/format.h>
#include <gmock/gmock.h>
#include <opencv2/core.hpp>
#include <opencv2/imgcodecs.hpp>

#include "deepslam/core/random.h"
#include "support/allocation_watch.h"

namespace deepslam::image_codec {
namespace {

using testing::AnyOf;
using testing::HasSubstr;

constexpr int kWidth = 7;
constexpr int kHeight = 5;

std::uint16_t Whole(int u, int v) { return static_cast<std::uint16_t>(1000 + 100 * v + 7 * u); }
float Real(int u, int v) {
  return 0.25F + 0.5F * static_cast<float>(v) + 0.03125F * static_cast<float>(u);
}

std::string Pgm(const std::string& comment = "") {
  std::string bytes = fmt::format("P5 {}{} {}\n65535\n", comment, kWidth, kHeight);
  for (int v = 0; v < kHeight; ++v) {
    for (int u = 0; u < kWidth; ++u) {
      bytes.push_back(static_cast<char>(Whole(u, v) >> 8));
      bytes.push_back(static_cast<char>(Whole(u, v) & 255));
    }
  }
  return bytes;
}

template <typename T>
void Put(std::string& bytes, T value, bool high_first) {
  char raw[sizeof(T)];
  std::memcpy(raw, &value, sizeof(T));
  if (high_first) std::reverse(raw, raw + sizeof(T));
  bytes.append(raw, sizeof(T));
}

std::string NpyHeader(const std::string& kind, const std::string& shape, bool by_columns = false) {
  std::string header = fmt::format("{{'descr': '{}', 'fortran_order': {}, 'shape': {}, }}",
                                   kind,
                                   by_columns ? "True" : "False",
                                   shape);
  header.resize(118, ' ');
  header.back() = '\n';
  return std::string("\x93NUMPY\x01\x00\x76\x00", 10) + header;
}

template <typename T>
std::string Npy(const std::string& kind, const std::function<T(int, int)>& value) {
  std::string bytes = NpyHeader(kind, fmt::format("({}, {})", kHeight, kWidth));
  for (int v = 0; v < kHeight; ++v) {
    for (int u = 0; u < kWidth; ++u) Put(bytes, value(u, v), kind[0] == '>');
  }
  return bytes;
}

template <typename T>
cv::Mat Picture(int type, T (*value)(int, int)) {
  cv::Mat image(kHeight, kWidth, type);
  for (int v = 0; v < kHeight; ++v) {
    for (int u = 0; u < kWidth; ++u) image.at<T>(v, u) = value(u, v);
  }
  return image;
}

std::string Encoded(const char* end, const cv::Mat& image) {
  ::setenv("OPENCV_IO_ENABLE_OPENEXR", "1", 1);
  std::vector<unsigned char> bytes;
  EXPECT_TRUE(cv::imencode(end, image, bytes));
  return {bytes.begin(), bytes.end()};
}

struct Written {
  std::string name;
  DepthFormat format;
  std::function<std::string()> bytes;
  bool real = false;
};
void PrintTo(const Written& written, std::ostream* out) { *out << written.name; }

class DepthFiles : public testing::TestWithParam<Written> {};

TEST_P(DepthFiles, HoldWhatWasWritten) {
  const std::string bytes = GetParam().bytes();
  EXPECT_EQ(DepthFormatOf(bytes), GetParam().format);
  const Result<DepthStructure> structure = DepthStructureOf(bytes);
  ASSERT_TRUE(structure.ok()) << structure.error().message;
  EXPECT_EQ(structure->width, kWidth);
  EXPECT_EQ(structure->height, kHeight);
  EXPECT_EQ(structure->real, GetParam().real);
  const Result<DepthPixels> pixels = DecodeDepth(bytes);
  ASSERT_TRUE(pixels.ok()) << pixels.error().message;
  for (int v = 0; v < kHeight; ++v) {
    for (int u = 0; u < kWidth; ++u) {
      if (GetParam().real) {
        EXPECT_EQ(std::get<Image<float>>(*pixels)(u, v), Real(u, v));
      } else {
        EXPECT_EQ(std::get<Image<std::uint16_t>>(*pixels)(u, v), Whole(u, v));
      }
    }
  }
}

TEST_P(DepthFiles, CutShortAreRefused) {
  const std::string bytes = GetParam().bytes();
  for (std::size_t size = 0; size + 1 < bytes.size(); size += 1 + size / 16) {
    const Result<DepthPixels> pixels = DecodeDepth(std::string_view(bytes).substr(0, size));
    if (GetParam().format == DepthFormat::kExr || GetParam().format == DepthFormat::kTiff) continue;
    EXPECT_FALSE(pixels.ok()) << size;
  }
}

TEST_P(DepthFiles, DamagedOnesNeverEndTheProgram) {
  Random random(9);
  const std::string whole = GetParam().bytes();
  for (int trial = 0; trial < 300; ++trial) {
    std::string bytes = whole;
    for (int k = 0; k < 3; ++k)
      bytes[random.Index(bytes.size())] = static_cast<char>(random.Index(256));
    testing_support::ForgetAllocations();
    const Result<DepthPixels> pixels = DecodeDepth(bytes);
    if (!pixels.ok()) {
      EXPECT_FALSE(pixels.error().message.empty());
    }
    EXPECT_LE(testing_support::LargestAllocation(), std::size_t{64} << 20);
  }
}

const auto kWholes = std::function<std::uint16_t(int, int)>(Whole);

INSTANTIATE_TEST_SUITE_P(
    All,
    DepthFiles,
    testing::Values(
        Written{"Pgm", DepthFormat::kPgm, [] { return Pgm(); }},
        Written{"PgmWithComment", DepthFormat::kPgm, [] { return Pgm("# depth, mm\n"); }},
        Written{"NpyWhole", DepthFormat::kNpy, [] { return Npy<std::uint16_t>("<u2", kWholes); }},
        Written{"NpyWholeHighFirst",
                DepthFormat::kNpy,
                [] { return Npy<std::uint16_t>(">u2", kWholes); }},
        Written{"NpySigned32",
                DepthFormat::kNpy,
                [] {
                  return Npy<std::int32_t>("<i4",
                                           [](int u, int v) { return std::int32_t{Whole(u, v)}; });
                }},
        Written{"NpyFloat", DepthFormat::kNpy, [] { return Npy<float>("<f4", Real); }, true},
        Written{"NpyDouble",
                DepthFormat::kNpy,
                [] { return Npy<double>("<f8", [](int u, int v) { return double{Real(u, v)}; }); },
                true},
        Written{"Png", DepthFormat::kPng, [] { return Encoded(".png", Picture(CV_16UC1, Whole)); }},
        Written{"TiffWhole",
                DepthFormat::kTiff,
                [] { return Encoded(".tiff", Picture(CV_16UC1, Whole)); }},
        Written{"TiffFloat",
                DepthFormat::kTiff,
                [] { return Encoded(".tiff", Picture(CV_32FC1, Real)); },
                true},
        Written{"Exr",
                DepthFormat::kExr,
                [] { return Encoded(".exr", Picture(CV_32FC1, Real)); },
                true}),
    [](const auto& test) { return test.param.name; });

TEST(DepthImage, NpyByColumnsIsTurned) {
  std::string bytes = NpyHeader("<f4", fmt::format("({}, {})", kHeight, kWidth), true);
  for (int u = 0; u < kWidth; ++u) {
    for (int v = 0; v < kHeight; ++v) Put(bytes, Real(u, v), false);
  }
  const Result<DepthPixels> pixels = DecodeDepth(bytes);
  ASSERT_TRUE(pixels.ok()) << pixels.error().message;
  EXPECT_EQ(std::get<Image<float>>(*pixels)(6, 1), Real(6, 1));
}

TEST(DepthImage, NumbersBeyond16BitsAreNothing) {
  const auto bytes = Npy<std::int32_t>("<i4", [](int u, int) {
    return u == 0 ? -5 : u == 1 ? 70000 : 9;
  });
  const auto image = std::get<Image<std::uint16_t>>(*DecodeDepth(bytes));
  EXPECT_EQ(image(0, 0), 0);
  EXPECT_EQ(image(1, 0), 0);
  EXPECT_EQ(image(2, 0), 9);
}

TEST(DepthImage, WhatIsNoDepthIsRefusedByName) {
  const std::string shape = fmt::format("({}, {})", kHeight, kWidth);
  for (const auto& [bytes, fault] : std::vector<std::pair<std::string, std::string>>{
           {NpyHeader("|O", shape), "NumPy array"},
           {NpyHeader("<c8", shape), "<c8"},
           {NpyHeader("<f4", "(5, 7, 3)"), "3 sides"},
           {NpyHeader("<f4", "(99999, 99999)"), ""},
           {NpyHeader("<f4", "(-5, 7)"), ""},
           {"P5 7 5 255\n" + std::string(35, 'x'), "255"},
           {"P5 999999999 999999999 65535\n", ""},
           {"P2 7 5 65535\n1 2 3", ""},
           {Encoded(".png", cv::Mat(5, 7, CV_8UC3, cv::Scalar(1, 2, 3))), ""},
           {Encoded(".tiff", cv::Mat(5, 7, CV_8UC3, cv::Scalar(1, 2, 3))), ""},
           {"no image at all", ""},
           {"", ""}}) {
    const Result<DepthPixels> pixels = DecodeDepth(bytes);
    ASSERT_FALSE(pixels.ok()) << bytes.substr(0, 40);
    EXPECT_THAT(pixels.error().message, HasSubstr(fault));
  }
}

}  // namespace
}  // namespace deepslam::image_codec

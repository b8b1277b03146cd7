// Captures in the layouts of others, written by code of the tests alone that follows each layout's
// own description. Images are encoded by OpenCV itself, everything else here.
#pragma once

#include <array>
#include <cmath>
#include <cstdint>
#include <cstring>
#include <filesystem>
#include <limits>
#include <string>
#include <vector>

#include <zlib.h>

#include <gtest/gtest.h>
#include <opencv2/core.hpp>
#include <opencv2/imgcodecs.hpp>

#include "support/temp_dir.h"

namespace deepslam::layouts::foreign {

inline constexpr int kWidth = 32;
inline constexpr int kHeight = 24;

// Raw depth of frame i at a pixel, in millimetres; 0 in the first column: nothing measured.
inline std::uint16_t DepthMm(int i, int u, int v) {
  return u == 0 ? std::uint16_t{0} : static_cast<std::uint16_t>(1000 + 10 * i + 3 * u + v);
}
inline std::array<std::uint8_t, 3> Rgb(int i, int u, int v) {
  return {static_cast<std::uint8_t>(20 * i + u),
          static_cast<std::uint8_t>(3 * v),
          static_cast<std::uint8_t>(200 - i)};
}

inline std::string Encoded(const std::string& end, const cv::Mat& image) {
  std::vector<unsigned char> bytes;
  EXPECT_TRUE(cv::imencode(end, image, bytes));
  return {bytes.begin(), bytes.end()};
}

inline std::string ColourFile(int i, const std::string& end = ".png", int scale = 1) {
  cv::Mat bgr(kHeight * scale, kWidth * scale, CV_8UC3);
  for (int v = 0; v < bgr.rows; ++v) {
    for (int u = 0; u < bgr.cols; ++u) {
      const auto rgb = Rgb(i, u / scale, v / scale);
      bgr.at<cv::Vec3b>(v, u) = {rgb[2], rgb[1], rgb[0]};
    }
  }
  return Encoded(end, bgr);
}

// `factor` raw units per millimetre; `no_depth` where nothing was measured.
inline std::string DepthFile(int i, int factor = 1, std::uint16_t no_depth = 0) {
  cv::Mat raw(kHeight, kWidth, CV_16UC1);
  for (int v = 0; v < kHeight; ++v) {
    for (int u = 0; u < kWidth; ++u) {
      const std::uint16_t mm = DepthMm(i, u, v);
      raw.at<std::uint16_t>(v, u) = mm == 0 ? no_depth : static_cast<std::uint16_t>(mm * factor);
    }
  }
  return Encoded(".png", raw);
}

// World from camera of frame i: a quarter turn about y and some metres.
inline std::array<double, 16> Matrix(int i) {
  const double a = 0.1 * i;
  return {std::cos(a),
          0,
          std::sin(a),
          0.5 * i,
          0,
          1,
          0,
          1.25,
          -std::sin(a),
          0,
          std::cos(a),
          -2,
          0,
          0,
          0,
          1};
}
// The same as `tx ty tz qx qy qz qw`.
inline std::string Tum(int i) {
  const double a = 0.1 * i;
  return std::to_string(0.5 * i) + " 1.25 -2 0 " + std::to_string(std::sin(a / 2)) + " 0 " +
         std::to_string(std::cos(a / 2));
}
inline std::string MatrixText(const std::array<double, 16>& matrix) {
  std::string text;
  for (std::size_t i = 0; i < 16; ++i) {
    char number[40];
    std::snprintf(number, sizeof number, "%.12g", matrix[i]);
    text += number + std::string(i % 4 == 3 ? "\n" : "\t");
  }
  return text;
}

inline std::string Digits(int number, int count) {
  std::string text = std::to_string(number);
  return std::string(static_cast<std::size_t>(count) - text.size(), '0') + text;
}

// .sens files, field by field as ScanNet's sensorData.h has them.
class SensBytes {
 public:
  template <typename T>
  SensBytes& Put(T value) {
    char raw[sizeof(T)];
    std::memcpy(raw, &value, sizeof(T));
    bytes.append(raw, sizeof(T));
    return *this;
  }
  SensBytes& PutMatrix(const std::array<double, 16>& matrix) {
    for (const double value : matrix) Put(static_cast<float>(value));
    return *this;
  }
  std::string bytes;
};

inline std::array<double, 16> Intrinsics(double f, double cx, double cy) {
  return {f, 0, cx, 0, 0, f, cy, 0, 0, 0, 1, 0, 0, 0, 0, 1};
}
inline constexpr std::array<double, 16> kIdentity = {
    1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1};

struct SensOptions {
  std::uint32_t version = 4;
  int colour_codec = 1;
  int depth_codec = 1;
  int num_frames = 3;
  int lost_frame = -1;
  float depth_shift = 1000;
  std::array<double, 16> depth_extrinsics = kIdentity;
  int num_motions = 0;
};

inline std::string RawDepth(int i) {
  SensBytes raw;
  for (int v = 0; v < kHeight; ++v) {
    for (int u = 0; u < kWidth; ++u) raw.Put(DepthMm(i, u, v));
  }
  return raw.bytes;
}

inline std::string ZlibDepth(int i) {
  const std::string raw = RawDepth(i);
  std::string packed(compressBound(raw.size()), '\0');
  uLongf size = packed.size();
  EXPECT_EQ(compress(reinterpret_cast<Bytef*>(packed.data()),
                     &size,
                     reinterpret_cast<const Bytef*>(raw.data()),
                     raw.size()),
            Z_OK);
  packed.resize(size);
  return packed;
}

// Bits, the first one highest.
class BitWriter {
 public:
  void Put(const std::string& bits) {
    for (const char bit : bits) {
      if (count_ % 8 == 0) bytes.push_back('\0');
      if (bit == '1')
        bytes.back() =
            static_cast<char>(static_cast<unsigned char>(bytes.back()) | 128 >> count_ % 8);
      ++count_;
    }
  }
  void PutNumber(int number, int num_bits) {
    for (int bit = num_bits - 1; bit >= 0; --bit) Put((number >> bit & 1) != 0 ? "1" : "0");
  }
  std::string bytes;

 private:
  int count_ = 0;
};

// Shifts that use every code: repeats long and short, steps of one and two, and new values.
inline int Shift(int u, int v) {
  if (v % 4 == 0) return u < 20 ? 0 : 700;
  return 400 + 5 * v + (u % 7 == 3 ? 2 : u % 7 == 5 ? -1 : 0) + (u > 24 ? 300 : 0);
}

inline std::string OcciDepth() {
  BitWriter bits;
  int last = 0;
  int repeats = 0;
  const auto flush = [&] {
    while (repeats > 0) {
      const int count = repeats < 5 ? 1 : std::min(repeats, 36);
      if (count == 1) {
        bits.Put("00");
      } else {
        bits.Put("010");
        bits.PutNumber(count - 5, 5);
      }
      repeats -= count;
    }
  };
  for (int v = 0; v < kHeight; ++v) {
    for (int u = 0; u < kWidth; ++u) {
      const int step = Shift(u, v) - last;
      last = Shift(u, v);
      if (step == 0) {
        ++repeats;
        continue;
      }
      flush();
      switch (step) {
        case 1:
          bits.Put("11");
          break;
        case -1:
          bits.Put("10");
          break;
        case 2:
          bits.Put("01101");
          break;
        case -2:
          bits.Put("01100");
          break;
        default:
          bits.Put("0111");
          bits.PutNumber(last, 11);
      }
    }
  }
  flush();
  return bits.bytes;
}

inline std::string RawColour(int i) {
  std::string bytes;
  for (int v = 0; v < kHeight; ++v) {
    for (int u = 0; u < kWidth; ++u) {
      for (const std::uint8_t value : Rgb(i, u, v)) bytes.push_back(static_cast<char>(value));
    }
  }
  return bytes;
}

inline std::string SensHeader(const SensOptions& options) {
  const std::string name = "StructureSensor";
  SensBytes out;
  out.Put(options.version).Put(static_cast<std::uint64_t>(name.size()));
  out.bytes += name;
  out.PutMatrix(Intrinsics(30.3, 15.5, 11.25)).PutMatrix(kIdentity);
  out.PutMatrix(Intrinsics(30.3, 15.5, 11.25)).PutMatrix(options.depth_extrinsics);
  out.Put(options.colour_codec).Put(options.depth_codec);
  for (const int size : {kWidth, kHeight, kWidth, kHeight})
    out.Put(static_cast<std::uint32_t>(size));
  out.Put(options.depth_shift);
  return out.bytes;
}

inline std::string Sens(const SensOptions& options) {
  SensBytes out{SensHeader(options)};
  out.Put(static_cast<std::uint64_t>(options.num_frames));
  for (int i = 0; i < options.num_frames; ++i) {
    std::array<double, 16> pose = Matrix(i);
    if (i == options.lost_frame) pose.fill(-std::numeric_limits<double>::infinity());
    const std::string colour = options.colour_codec == 0   ? RawColour(i)
                               : options.colour_codec == 1 ? ColourFile(i, ".png")
                                                           : ColourFile(i, ".jpg");
    const std::string depth = options.depth_codec == 0   ? RawDepth(i)
                              : options.depth_codec == 1 ? ZlibDepth(i)
                                                         : OcciDepth();
    out.PutMatrix(pose);
    out.Put(std::uint64_t{1000000} + static_cast<std::uint64_t>(33333 * i));
    out.Put(std::uint64_t{1000500} + static_cast<std::uint64_t>(33333 * i));
    out.Put(static_cast<std::uint64_t>(colour.size()))
        .Put(static_cast<std::uint64_t>(depth.size()));
    out.bytes += colour + depth;
  }
  if (options.version < 4) return out.bytes;
  out.Put(static_cast<std::uint64_t>(options.num_motions));
  out.bytes.append(static_cast<std::size_t>(options.num_motions) * 128, '\0');
  return out.bytes;
}

}  // namespace deepslam::layouts::foreign

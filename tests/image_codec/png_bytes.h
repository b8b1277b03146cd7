// PNG files of every kind, written by the format's own description, so that the truth about a
// decoder is no decoder's.
#pragma once

#include <cstdint>
#include <functional>
#include <string>

#include <zlib.h>

namespace deepslam::image_codec::testing_support {

enum PngType { kGrey = 0, kRgb = 2, kPalette = 3, kGreyAlpha = 4, kRgba = 6 };

struct PngKind {
  int type = kGrey;
  int bits = 8;
  bool interlaced = false;
  std::string chunks;  // between header and pixels
};

// Value of a channel, 0 ... 2^bits - 1.
using Sample = std::function<int(int u, int v, int channel)>;

inline std::string BigEndian32(std::uint32_t value) {
  std::string bytes;
  for (const int shift : {24, 16, 8, 0}) bytes.push_back(static_cast<char>(value >> shift));
  return bytes;
}

inline std::string Chunk(const std::string& type, const std::string& data) {
  const std::string checked = type + data;
  const auto crc = static_cast<std::uint32_t>(
      crc32(0, reinterpret_cast<const Bytef*>(checked.data()), static_cast<uInt>(checked.size())));
  return BigEndian32(static_cast<std::uint32_t>(data.size())) + checked + BigEndian32(crc);
}

inline std::string Header(std::uint32_t width, std::uint32_t height, const PngKind& kind) {
  return Chunk("IHDR",
               BigEndian32(width) + BigEndian32(height) + static_cast<char>(kind.bits) +
                   static_cast<char>(kind.type) + std::string(2, '\0') +
                   static_cast<char>(kind.interlaced ? 1 : 0));
}

inline int NumChannels(const PngKind& kind) {
  return kind.type == kRgb ? 3 : kind.type == kRgba ? 4 : kind.type == kGreyAlpha ? 2 : 1;
}

// The pixels from (u0, v0) on in steps of (du, dv), each row behind its filter (none).
inline std::string Rows(int width,
                        int height,
                        const PngKind& kind,
                        const Sample& sample,
                        int u0,
                        int v0,
                        int du,
                        int dv) {
  std::string rows;
  for (int v = v0; v < height && u0 < width; v += dv) {
    rows.push_back('\0');
    int bit = 0;
    for (int u = u0; u < width; u += du) {
      for (int c = 0; c < NumChannels(kind); ++c) {
        const int value = sample(u, v, c);
        for (int b = kind.bits - 1; b >= 0; --b, ++bit) {
          if (bit % 8 == 0) rows.push_back('\0');
          if ((value >> b & 1) != 0)
            rows.back() =
                static_cast<char>(static_cast<unsigned char>(rows.back()) | 128 >> bit % 8);
        }
      }
    }
  }
  return rows;
}

inline std::string Deflated(const std::string& bytes) {
  std::string packed(compressBound(bytes.size()), '\0');
  uLongf size = packed.size();
  compress(reinterpret_cast<Bytef*>(packed.data()),
           &size,
           reinterpret_cast<const Bytef*>(bytes.data()),
           bytes.size());
  packed.resize(size);
  return packed;
}

inline std::string PngBytes(int width, int height, const PngKind& kind, const Sample& sample) {
  constexpr int kPasses[7][4] = {{0, 0, 8, 8},
                                 {4, 0, 8, 8},
                                 {0, 4, 4, 8},
                                 {2, 0, 4, 4},
                                 {0, 2, 2, 4},
                                 {1, 0, 2, 2},
                                 {0, 1, 1, 2}};
  std::string rows;
  if (kind.interlaced) {
    for (const auto& pass : kPasses)
      rows += Rows(width, height, kind, sample, pass[0], pass[1], pass[2], pass[3]);
  } else {
    rows = Rows(width, height, kind, sample, 0, 0, 1, 1);
  }
  return std::string("\x89PNG\r\n\x1a\n", 8) +
         Header(static_cast<std::uint32_t>(width), static_cast<std::uint32_t>(height), kind) +
         kind.chunks + Chunk("IDAT", Deflated(rows)) + Chunk("IEND", "");
}

}  // namespace deepslam::image_codec::testing_support

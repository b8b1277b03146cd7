#include "deepslam/image_codec/png.h"

#include <gmock/gmock.h>

#include "deepslam/core/random.h"
#include "deepslam/image_codec/structure.h"
#include "image_codec/png_bytes.h"

namespace deepslam::image_codec {
namespace {

using namespace testing_support;
using testing::AllOf;
using testing::HasSubstr;

constexpr int kWidth = 21;  // no multiple of 8: the last bytes of rows are not full
constexpr int kHeight = 11;

Sample Some(int bits) {
  return [=](int u, int v, int c) { return (37 * u + 101 * v + 59 * c + u * v) % (1 << bits); };
}

// A palette of as many colours as `bits` name; colour i is (i, 2 i, 255 - i).
std::string Palette(int bits) {
  std::string colours;
  for (int i = 0; i < 1 << bits; ++i) {
    for (const int value : {i, 2 * i, 255 - i}) colours.push_back(static_cast<char>(value));
  }
  return Chunk("PLTE", colours);
}

Rgb8 Grey(int value) {
  const auto level = static_cast<std::uint8_t>(value);
  return {level, level, level};
}

// What a reader of colours must make of a pixel.
Rgb8 ColourOf(const PngKind& kind, const Sample& sample, int u, int v) {
  const auto byte = [&](int c) {
    const int value = sample(u, v, c);
    if (kind.bits == 16) return static_cast<std::uint8_t>(value >> 8);
    return static_cast<std::uint8_t>(value * 255 / ((1 << kind.bits) - 1));
  };
  if (kind.type == kPalette) {
    const int i = sample(u, v, 0);
    return {static_cast<std::uint8_t>(i),
            static_cast<std::uint8_t>(2 * i),
            static_cast<std::uint8_t>(255 - i)};
  }
  if (kind.type == kGrey || kind.type == kGreyAlpha) return Grey(byte(0));
  return {byte(0), byte(1), byte(2)};
}

std::vector<PngKind> EveryKind() {
  std::vector<PngKind> kinds;
  for (const bool interlaced : {false, true}) {
    for (const int bits : {1, 2, 4, 8, 16}) {
      kinds.push_back({kGrey, bits, interlaced, {}});
      if (bits <= 8) kinds.push_back({kPalette, bits, interlaced, Palette(bits)});
      if (bits < 8) continue;
      for (const int type : {kRgb, kGreyAlpha, kRgba})
        kinds.push_back({type, bits, interlaced, {}});
    }
  }
  return kinds;
}

TEST(DecodePng, ColoursOfEveryKind) {
  for (const PngKind& kind : EveryKind()) {
    const Sample sample = Some(kind.bits);
    const auto image = DecodePngColour(PngBytes(kWidth, kHeight, kind, sample));
    ASSERT_TRUE(image.ok()) << kind.type << ' ' << kind.bits << ": " << image.error().message;
    for (int v = 0; v < kHeight; ++v) {
      for (int u = 0; u < kWidth; ++u)
        ASSERT_EQ((*image)(u, v), ColourOf(kind, sample, u, v)) << kind.type << ' ' << kind.bits;
    }
  }
}

TEST(DecodePng, TransparencyAndGammaChangeNoPixel) {
  const Sample sample = Some(8);
  for (const PngKind& kind :
       {PngKind{kRgb, 8, false, Chunk("tRNS", std::string("\0\7\0\7\0\7", 6))},
        PngKind{kRgb, 8, false, Chunk("gAMA", BigEndian32(22000))},
        PngKind{kRgb, 8, false, Chunk("sBIT", "\5\5\5") + Chunk("bKGD", std::string(6, '\1'))}}) {
    const auto image = DecodePngColour(PngBytes(kWidth, kHeight, kind, sample));
    ASSERT_TRUE(image.ok()) << image.error().message;
    EXPECT_EQ((*image)(20, 10), ColourOf(kind, sample, 20, 10));
    EXPECT_EQ((*image)(3, 2), ColourOf(kind, sample, 3, 2));
  }
  const PngKind seen_through{kPalette, 8, false, Palette(8) + Chunk("tRNS", "\1\2\3")};
  const auto image =
      DecodePngColour(PngBytes(4, 1, seen_through, [](int u, int, int) { return u; }));
  ASSERT_TRUE(image.ok()) << image.error().message;
  EXPECT_EQ((*image)(2, 0), (Rgb8{2, 4, 253}));
}

TEST(DecodePng, DepthComesOutBitForBit) {
  for (const std::string& chunks : {std::string(), Chunk("gAMA", BigEndian32(45455))}) {
    for (const bool interlaced : {false, true}) {
      const auto image =
          DecodePngGrey16(PngBytes(kWidth, kHeight, {kGrey, 16, interlaced, chunks}, Some(16)));
      ASSERT_TRUE(image.ok()) << image.error().message;
      for (int v = 0; v < kHeight; ++v) {
        for (int u = 0; u < kWidth; ++u) ASSERT_EQ((*image)(u, v), Some(16)(u, v, 0));
      }
    }
  }
}

TEST(DecodePng, FewGreyLevelsAreStretched) {
  for (const int bits : {1, 2, 4, 8}) {
    const auto image =
        DecodePngGrey(PngBytes(kWidth, kHeight, {kGrey, bits, false, {}}, Some(bits)));
    ASSERT_TRUE(image.ok()) << image.error().message;
    EXPECT_EQ((*image)(20, 10), Some(bits)(20, 10, 0) * 255 / ((1 << bits) - 1));
  }
}

TEST(DecodePng, RefusesOtherKindsOfGrey) {
  const auto refusal = [](const auto& image) {
    return image.ok() ? std::string() : image.error().message;
  };
  const auto bytes = [](int type, int bits) {
    const PngKind kind{type, bits, false, type == kPalette ? Palette(bits) : ""};
    return PngBytes(kWidth, kHeight, kind, Some(bits));
  };
  EXPECT_THAT(refusal(DecodePngGrey16(bytes(kGrey, 8))), HasSubstr("has 1 of 8 bits"));
  EXPECT_THAT(refusal(DecodePngGrey16(bytes(kRgb, 16))), HasSubstr("has 3 of 16 bits"));
  EXPECT_THAT(refusal(DecodePngGrey16(bytes(kGreyAlpha, 16))), HasSubstr("has 2 of 16 bits"));
  EXPECT_THAT(refusal(DecodePngGrey(bytes(kPalette, 4))), HasSubstr("has 3 of 8 bits"));
  EXPECT_THAT(refusal(DecodePngGrey(bytes(kGrey, 16))), HasSubstr("has 1 of 16 bits"));
  EXPECT_THAT(refusal(DecodePngGrey("\xFF\xD8\xFF")), HasSubstr("no PNG"));
}

TEST(DecodePng, EveryTruncationIsRefused) {
  for (const bool interlaced : {false, true}) {
    const std::string whole = PngBytes(kWidth, kHeight, {kGrey, 16, interlaced, {}}, Some(16));
    ASSERT_TRUE(DecodePngGrey16(whole).ok());
    for (std::size_t size = 0; size < whole.size(); ++size)
      ASSERT_FALSE(DecodePngGrey16(whole.substr(0, size)).ok()) << size;
  }
}

// Pixels that are not all there, in a file whose own end is.
TEST(DecodePng, TooFewPixelsAreRefused) {
  const PngKind kind{kGrey, 8, false, {}};
  const std::string file = PngBytes(kWidth, kHeight, kind, Some(8));
  const std::string taller =
      file.substr(0, 8) + Header(kWidth, kHeight + 3, kind) + file.substr(33);
  EXPECT_THAT(DecodePngGrey(taller).error().message, HasSubstr("damaged PNG image"));
}

TEST(DecodePng, WrongChecksumsAreRefused) {
  const std::string whole = PngBytes(kWidth, kHeight, {kGrey, 16, false, {}}, Some(16));
  std::string header = whole, pixels = whole;
  header[29] ^= 1;                 // of the header: 8 + 8 + 13
  pixels[whole.size() - 14] ^= 1;  // of the pixels, before the 12 bytes of the end
  for (const std::string& damaged : {header, pixels})
    EXPECT_THAT(DecodePngGrey16(damaged).error().message,
                AllOf(HasSubstr("damaged PNG image"), HasSubstr("CRC")));
}

TEST(DecodePng, FlippedBytesNeverCrash) {
  const std::string whole = PngBytes(kWidth, kHeight, {kPalette, 4, true, Palette(4)}, Some(4));
  Random random(11);
  for (int round = 0; round < 2000; ++round) {
    std::string bytes = whole;
    bytes[random.Index(bytes.size())] ^= static_cast<char>(1 + random.Index(255));
    const Result<ColourImage> image = DecodePngColour(bytes);
    EXPECT_TRUE(image.ok() || !image.error().message.empty());
  }
}

TEST(DecodePng, HostileSizesTakeNoMemory) {
  const PngKind kind{kRgb, 8, false, {}};
  const std::string file = PngBytes(kWidth, kHeight, kind, Some(8));
  const auto refusal = [&](std::uint32_t width, std::uint32_t height) {
    const std::string bytes = file.substr(0, 8) + Header(width, height, kind) + file.substr(33);
    return DecodePngColour(bytes).error().message;
  };
  EXPECT_THAT(refusal(16384, 16384), HasSubstr("too few for 16384 x 16384 px"));
  EXPECT_THAT(refusal(0x7FFFFFFF, 0x7FFFFFFF), HasSubstr("too few"));
  EXPECT_THAT(refusal(0, 10), HasSubstr("ends too early"));
  EXPECT_THAT(refusal(10, 0), HasSubstr("ends too early"));
  EXPECT_THAT(refusal(0x80000010, 11), HasSubstr("damaged PNG image"));
}

// As far as Deflate goes: a picture of one colour must not be taken for a hostile one.
TEST(DecodePng, WhatIsOfOneColourIsRead) {
  const Sample zero = [](int, int, int) { return 0; };
  for (const int bits : {1, 8}) {
    const PngKind kind{kGrey, bits, false, {}};
    const auto image = DecodePngColour(PngBytes(2048, 1024, kind, zero));
    ASSERT_TRUE(image.ok()) << image.error().message;
    EXPECT_EQ((*image)(2047, 1023), (Rgb8{0, 0, 0}));
  }
}

TEST(EncodePng, ComesBackBitForBit) {
  Random random(5);
  ColourImage colour(kWidth, kHeight);
  for (Rgb8& c : colour) c = {static_cast<std::uint8_t>(random.Index(256)), 3, 250};
  Image<std::uint16_t> depth(kWidth, kHeight);
  for (std::uint16_t& d : depth) d = static_cast<std::uint16_t>(random.Index(65536));
  EXPECT_EQ(*DecodePngColour(*EncodePng(colour)), colour);
  EXPECT_EQ(*DecodePngGrey16(*EncodePng(depth)), depth);
  const ImageStructure structure = StructureOf(*EncodePng(depth));
  EXPECT_EQ(structure.channels, 1);
  EXPECT_EQ(structure.bits, 16);
  EXPECT_FALSE(EncodePng(ColourImage()).ok());
}

}  // namespace
}  // namespace deepslam::image_codec

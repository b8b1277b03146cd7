#include "deepslam/image_codec/decode.h"

#include <gmock/gmock.h>
#include <webp/encode.h>

#include "deepslam/core/random.h"
#include "deepslam/image_codec/jpeg.h"
#include "deepslam/image_codec/png.h"
#include "deepslam/image_codec/structure.h"
#include "deepslam/image_codec/webp.h"

namespace deepslam::image_codec {
namespace {

using testing::HasSubstr;

ColourImage Noise(int width, int height) {
  Random random(3);
  ColourImage image(width, height);
  for (Rgb8& c : image) {
    for (std::uint8_t* channel : {&c.r, &c.g, &c.b})
      *channel = static_cast<std::uint8_t>(random.Index(256));
  }
  return image;
}

std::string LosslessWebp(const ColourImage& image) {
  std::uint8_t* bytes = nullptr;
  const std::size_t size =
      WebPEncodeLosslessRGB(reinterpret_cast<const std::uint8_t*>(image.data()),
                            image.width(),
                            image.height(),
                            3 * image.width(),
                            &bytes);
  std::string written(reinterpret_cast<const char*>(bytes), size);
  WebPFree(bytes);
  return written;
}

TEST(DecodeColour, GoesByTheFirstBytes) {
  const ColourImage noise = Noise(19, 7);
  EXPECT_EQ(*DecodeColour(*EncodePng(noise)), noise);
  EXPECT_EQ(*DecodeColour(LosslessWebp(noise)), noise);
  EXPECT_EQ(DecodeColour(*EncodeJpeg(noise, 90))->width(), 19);
  for (const std::string& bytes :
       {std::string(), std::string("BM some bitmap"), std::string("GIF89a")})
    EXPECT_THAT(DecodeColour(bytes).error().message, HasSubstr("no PNG, JPEG or WebP"));
}

TEST(FormatOf, EveryFirstPartOfASignatureIsNone) {
  for (const std::string& bytes :
       {*EncodePng(Noise(2, 2)), *EncodeJpeg(Noise(2, 2), 90), LosslessWebp(Noise(2, 2))}) {
    EXPECT_NE(FormatOf(bytes), ImageFormat::kOther);
    for (const std::size_t size : {0u, 1u, 2u}) {
      EXPECT_EQ(FormatOf(bytes.substr(0, size)), ImageFormat::kOther);
      EXPECT_FALSE(CheckStructure(StructureOf(bytes.substr(0, size)), bytes).ok());
    }
  }
}

TEST(DecodeWebp, EveryTruncationIsRefused) {
  const std::string whole = LosslessWebp(Noise(19, 7));
  for (std::size_t size = 0; size < whole.size(); ++size)
    ASSERT_FALSE(DecodeWebp(whole.substr(0, size)).ok()) << size;
}

TEST(DecodeWebp, FlippedBytesNeverCrash) {
  const std::string whole = LosslessWebp(Noise(19, 7));
  Random random(4);
  for (int round = 0; round < 1000; ++round) {
    std::string bytes = whole;
    bytes[random.Index(bytes.size())] ^= static_cast<char>(1 + random.Index(255));
    const Result<ColourImage> image = DecodeWebp(bytes);
    EXPECT_TRUE(image.ok() || !image.error().message.empty());
  }
}

// Some fifty bytes are enough for any size in one colour.
TEST(DecodeWebp, SizesAreBounded) {
  std::string bytes = LosslessWebp(ColourImage(2048, 2048, Rgb8{7, 8, 9}));
  EXPECT_LT(bytes.size(), 1000U);
  EXPECT_EQ((*DecodeWebp(bytes))(2047, 5), (Rgb8{7, 8, 9}));
  bytes.replace(21, 4, "\xFF\xFF\xFF\x0F");  // both sides less one, of 14 bits
  EXPECT_THAT(DecodeWebp(bytes).error().message, HasSubstr("16384 x 16384 px, more than"));
}

}  // namespace
}  // namespace deepslam::image_codec

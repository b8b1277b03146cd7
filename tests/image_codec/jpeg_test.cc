#include "deepslam/image_codec/jpeg.h"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <functional>
#include <vector>

#include <gmock/gmock.h>
#include <jpeglib.h>

#include "deepslam/core/random.h"
#include "deepslam/image_codec/structure.h"

namespace deepslam::image_codec {
namespace {

using testing::HasSubstr;

constexpr int kWidth = 48;
constexpr int kHeight = 32;

ColourImage Waves(int width, int height) {
  ColourImage colour(width, height);
  for (int v = 0; v < height; ++v) {
    for (int u = 0; u < width; ++u) {
      const auto wave = [&](double a, double b) {
        return static_cast<std::uint8_t>(120 + 70 * std::sin(a * u + b * v));
      };
      colour(u, v) = {wave(0.11, 0.07), wave(0.05, 0.13), wave(0.17, 0.03)};
    }
  }
  return colour;
}

double Intensity(const Rgb8& c) { return 0.299 * c.r + 0.587 * c.g + 0.114 * c.b; }

// Written by libjpeg itself, for the kinds that EncodeJpeg does not write.
std::string Written(int width,
                    int height,
                    J_COLOR_SPACE colour_space,
                    int channels,
                    const std::function<void(jpeg_compress_struct&)>& configure,
                    const std::function<int(int u, int v, int channel)>& sample) {
  jpeg_compress_struct info{};
  jpeg_error_mgr errors{};
  info.err = jpeg_std_error(&errors);
  jpeg_create_compress(&info);
  unsigned char* bytes = nullptr;
  unsigned long size = 0;
  jpeg_mem_dest(&info, &bytes, &size);
  info.image_width = static_cast<JDIMENSION>(width);
  info.image_height = static_cast<JDIMENSION>(height);
  info.input_components = channels;
  info.in_color_space = colour_space;
  jpeg_set_defaults(&info);
  configure(info);
  jpeg_start_compress(&info, TRUE);
  std::vector<JSAMPLE> row(static_cast<std::size_t>(width * channels));
  for (int v = 0; v < height; ++v) {
    for (int u = 0; u < width; ++u) {
      for (int c = 0; c < channels; ++c)
        row[static_cast<std::size_t>(u * channels + c)] = static_cast<JSAMPLE>(sample(u, v, c));
    }
    JSAMPROW start = row.data();
    jpeg_write_scanlines(&info, &start, 1);
  }
  jpeg_finish_compress(&info);
  jpeg_destroy_compress(&info);
  std::string written(reinterpret_cast<const char*>(bytes), size);
  std::free(bytes);
  return written;
}

std::string WavesWritten(const std::function<void(jpeg_compress_struct&)>& configure) {
  const ColourImage waves = Waves(kWidth, kHeight);
  return Written(kWidth, kHeight, JCS_RGB, 3, configure, [&](int u, int v, int c) {
    const Rgb8& p = waves(u, v);
    return c == 0 ? p.r : c == 1 ? p.g : p.b;
  });
}

TEST(DecodeJpeg, IsWhatWasEncodedWithinWhatJpegLoses) {
  const ColourImage waves = Waves(kWidth, kHeight);
  const auto image = DecodeJpegColour(*EncodeJpeg(waves, 95));
  ASSERT_TRUE(image.ok()) << image.error().message;
  ASSERT_EQ(image->width(), kWidth);
  ASSERT_EQ(image->height(), kHeight);
  for (std::size_t i = 0; i < waves.size(); ++i)
    ASSERT_NEAR(Intensity(image->data()[i]), Intensity(waves.data()[i]), 3);
  EXPECT_LT(EncodeJpeg(waves, 50)->size(), EncodeJpeg(waves, 95)->size());
}

TEST(DecodeJpeg, ProgressiveOnesHoldTheSamePixels) {
  const auto plain = DecodeJpegColour(WavesWritten([](jpeg_compress_struct&) {}));
  for (const auto& configure : std::vector<std::function<void(jpeg_compress_struct&)>>{
           [](jpeg_compress_struct& info) { jpeg_simple_progression(&info); },
           [](jpeg_compress_struct& info) { info.arith_code = TRUE; },
           [](jpeg_compress_struct& info) { info.optimize_coding = TRUE; },
           [](jpeg_compress_struct& info) { info.restart_interval = 2; }}) {
    const auto image = DecodeJpegColour(WavesWritten(configure));
    ASSERT_TRUE(image.ok()) << image.error().message;
    EXPECT_EQ(*image, *plain);
  }
}

TEST(DecodeJpeg, RotationTagsAreLeftAlone) {
  const std::string plain = *EncodeJpeg(Waves(kWidth, kHeight), 90);
  const std::string turned(
      "\xFF\xE1\x00\x22"
      "Exif\0\0MM\0*\0\0\0\x08\0\x01\x01\x12\0\x03\0\0\0\x01\0\x06\0\0\0\0\0\0",
      36);
  EXPECT_EQ(*DecodeJpegColour(plain.substr(0, 2) + turned + plain.substr(2)),
            *DecodeJpegColour(plain));
}

TEST(DecodeJpeg, GreyOnesAreReadAsGreyAndAsColour) {
  const std::string bytes = Written(
      kWidth,
      kHeight,
      JCS_GRAYSCALE,
      1,
      [](jpeg_compress_struct&) {},
      [](int u, int, int) { return 40 + 4 * u; });
  EXPECT_EQ(StructureOf(bytes).channels, 1);
  const auto grey = DecodeJpegGrey(bytes);
  const auto colour = DecodeJpegColour(bytes);
  ASSERT_TRUE(grey.ok() && colour.ok());
  for (int u = 0; u < kWidth; ++u) {
    EXPECT_NEAR((*grey)(u, 9), 40 + 4 * u, 3);
    EXPECT_EQ((*colour)(u, 9), (Rgb8{(*grey)(u, 9), (*grey)(u, 9), (*grey)(u, 9)}));
  }
}

TEST(DecodeJpeg, ReducedOnesAreMeansOfBlocks) {
  const ColourImage waves = Waves(kWidth, kHeight);
  const std::string bytes = *EncodeJpeg(waves, 98);
  for (const int reduction : {1, 2, 4, 8}) {
    const auto grey = DecodeJpegGrey(bytes, reduction);
    ASSERT_TRUE(grey.ok()) << grey.error().message;
    ASSERT_EQ(grey->width(), kWidth / reduction);
    ASSERT_EQ(grey->height(), kHeight / reduction);
    for (int v = 0; v < grey->height(); ++v) {
      for (int u = 0; u < grey->width(); ++u) {
        double sum = 0;
        for (int k = 0; k < reduction * reduction; ++k)
          sum += Intensity(waves(u * reduction + k % reduction, v * reduction + k / reduction));
        ASSERT_NEAR((*grey)(u, v), sum / (reduction * reduction), 3) << reduction;
      }
    }
  }
}

// Adobe's: 255 is no ink.
TEST(DecodeJpeg, InksBecomeColours) {
  const auto inks = [](int c, int m, int y, int k) {
    return Written(
        8,
        8,
        JCS_CMYK,
        4,
        [](jpeg_compress_struct&) {},
        [=](int, int, int channel) {
          return channel == 0 ? c : channel == 1 ? m : channel == 2 ? y : k;
        });
  };
  const auto expect_near = [](const std::string& bytes, const Rgb8& expected) {
    const auto image = DecodeJpegColour(bytes);
    ASSERT_TRUE(image.ok()) << image.error().message;
    const Rgb8& c = (*image)(4, 4);
    EXPECT_NEAR(c.r, expected.r, 3);
    EXPECT_NEAR(c.g, expected.g, 3);
    EXPECT_NEAR(c.b, expected.b, 3);
  };
  expect_near(inks(255, 255, 255, 255), {255, 255, 255});
  expect_near(inks(0, 255, 255, 255), {0, 255, 255});
  expect_near(inks(255, 0, 255, 128), {128, 0, 128});
  expect_near(inks(255, 255, 255, 0), {0, 0, 0});
  EXPECT_EQ(StructureOf(inks(0, 0, 0, 0)).channels, 4);
}

TEST(DecodeJpeg, EveryTruncationIsRefused) {
  for (const bool progressive : {false, true}) {
    const std::string whole = WavesWritten([&](jpeg_compress_struct& info) {
      if (progressive) jpeg_simple_progression(&info);
    });
    ASSERT_TRUE(DecodeJpegColour(whole).ok());
    for (std::size_t size = 0; size < whole.size(); ++size) {
      ASSERT_FALSE(DecodeJpegColour(whole.substr(0, size)).ok()) << size;
      ASSERT_FALSE(DecodeJpegGrey(whole.substr(0, size), 2).ok()) << size;
    }
  }
}

// A file within a file, as thumbnails are, has an end of its own.
TEST(DecodeJpeg, TheEndOfAThumbnailIsNotTheEnd) {
  const std::string plain = *EncodeJpeg(Waves(kWidth, kHeight), 90);
  const std::string thumbnail("\xFF\xE1\x00\x06\xFF\xD9\xFF\xD9", 8);
  const std::string whole = plain.substr(0, 2) + thumbnail + plain.substr(2);
  EXPECT_TRUE(DecodeJpegColour(whole).ok());
  EXPECT_THAT(DecodeJpegColour(whole.substr(0, whole.size() * 2 / 3)).error().message,
              HasSubstr("ends too early"));
}

TEST(DecodeJpeg, FlippedBytesNeverCrash) {
  const std::string whole =
      WavesWritten([](jpeg_compress_struct& info) { jpeg_simple_progression(&info); });
  Random random(12);
  for (int round = 0; round < 2000; ++round) {
    std::string bytes = whole;
    bytes[random.Index(bytes.size())] ^= static_cast<char>(1 + random.Index(255));
    const Result<ColourImage> image = DecodeJpegColour(bytes);
    EXPECT_TRUE(image.ok() || !image.error().message.empty());
  }
}

TEST(DecodeJpeg, LostTablesAreRefused) {
  std::string bytes = *EncodeJpeg(Waves(kWidth, kHeight), 90);
  const std::size_t table = bytes.find("\xFF\xDB");
  bytes[table + 1] = '\xEE';  // a note of some program
  EXPECT_THAT(DecodeJpegColour(bytes).error().message, HasSubstr("damaged JPEG image"));
}

TEST(DecodeJpeg, HostileFilesAreRefused) {
  std::string bytes = *EncodeJpeg(Waves(kWidth, kHeight), 90);
  const std::size_t frame = bytes.find("\xFF\xC0");
  bytes.replace(frame + 5, 4, std::string("\xFF\xDC\xFF\xDC", 4));  // 65500 x 65500 px
  EXPECT_THAT(DecodeJpegColour(bytes).error().message, HasSubstr("too few for 65500 x 65500"));
  bytes.replace(frame + 5, 4, std::string(4, '\0'));
  EXPECT_THAT(DecodeJpegColour(bytes).error().message, HasSubstr("ends too early"));
  EXPECT_THAT(DecodeJpegGrey("\x89PNG\r\n\x1a\n").error().message, HasSubstr("no JPEG"));

  const std::string whole =
      WavesWritten([](jpeg_compress_struct& info) { jpeg_simple_progression(&info); });
  const std::size_t last_scan = whole.rfind("\xFF\xDA");
  const std::string scan = whole.substr(last_scan, whole.size() - 2 - last_scan);
  std::string many = whole.substr(0, whole.size() - 2);
  for (int i = 0; i < 600; ++i) many += scan;
  EXPECT_THAT(DecodeJpegColour(many + whole.substr(whole.size() - 2)).error().message,
              HasSubstr("too many scans"));
}

TEST(EncodeJpeg, RefusesWhatHasNoPixels) { EXPECT_FALSE(EncodeJpeg(ColourImage(), 90).ok()); }

}  // namespace
}  // namespace deepslam::image_codec

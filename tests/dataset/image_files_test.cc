#include "deepslam/dataset/image_files.h"

#include <cmath>
#include <filesystem>

#include <gmock/gmock.h>
#include <opencv2/core.hpp>
#include <opencv2/imgcodecs.hpp>

#include "deepslam/core/random.h"
#include "deepslam/dataset/read_bytes.h"
#include "deepslam/frames/intensity.h"
#include "support/temp_dir.h"

namespace deepslam::dataset {
namespace {

namespace fs = std::filesystem;

using testing::AllOf;
using testing::HasSubstr;
using testing_support::ReadText;
using testing_support::TempDir;
using testing_support::WriteText;

RawDepthImage RandomDepth(int width, int height) {
  Random random(5);
  RawDepthImage depth(width, height);
  for (std::uint16_t& d : depth) d = static_cast<std::uint16_t>(random.Index(65536));
  return depth;
}

TEST(DepthFile, ComesBackBitForBit) {
  const TempDir dir;
  const RawDepthImage depth = RandomDepth(40, 30);
  ASSERT_TRUE(WriteDepthFile(dir.path() / "d.png", depth).ok());
  EXPECT_EQ(*ReadDepthFile(dir.path() / "d.png", 40, 30), depth);
}

TEST(DepthFile, RefusesEightBitsAndColour) {
  const TempDir dir;
  cv::imwrite((dir.path() / "grey.png").string(), cv::Mat(30, 40, CV_8UC1, cv::Scalar(7)));
  cv::imwrite((dir.path() / "colour.png").string(), cv::Mat(30, 40, CV_16UC3, cv::Scalar(7, 7, 7)));
  EXPECT_THAT(ReadDepthFile(dir.path() / "grey.png", 40, 30).error().message,
              AllOf(HasSubstr("grey.png"), HasSubstr("8 bits")));
  EXPECT_THAT(ReadDepthFile(dir.path() / "colour.png", 40, 30).error().message,
              HasSubstr("has 3 of 16 bits"));
}

TEST(ColourFile, GreyAndAlphaBecomeColour) {
  const TempDir dir;
  cv::imwrite((dir.path() / "grey.png").string(), cv::Mat(30, 40, CV_8UC1, cv::Scalar(70)));
  cv::imwrite((dir.path() / "alpha.png").string(),
              cv::Mat(30, 40, CV_8UC4, cv::Scalar(1, 2, 3, 128)));
  EXPECT_EQ((*ReadColourFile(dir.path() / "grey.png", 40, 30))(39, 29), (Rgb8{70, 70, 70}));
  EXPECT_EQ((*ReadColourFile(dir.path() / "alpha.png", 40, 30))(0, 0), (Rgb8{3, 2, 1}));
}

TEST(ColourFile, RefusesOtherSizesBeforeDecoding) {
  const TempDir dir;
  ASSERT_TRUE(WriteColourFile(dir.path() / "c.jpg", ColourImage(40, 30)).ok());
  EXPECT_THAT(ReadColourFile(dir.path() / "c.jpg", 30, 40).error().message,
              AllOf(HasSubstr("c.jpg"), HasSubstr("40 x 30 px, the camera 30 x 40")));
  // A PNG whose header claims 100,000 x 100,000 px.
  ASSERT_TRUE(WriteColourFile(dir.path() / "bomb.png", ColourImage(40, 30)).ok());
  std::string bytes = ReadText(dir.path() / "bomb.png");
  for (const std::size_t at : {16u, 20u}) bytes.replace(at, 4, std::string("\x00\x01\x86\xA0", 4));
  WriteText(dir.path() / "bomb.png", bytes);
  EXPECT_THAT(ReadColourFile(dir.path() / "bomb.png", 40, 30).error().message,
              HasSubstr("100000 x 100000"));
}

// Waves of a few pixels, as textures are: what a reduced image keeps and what it averages away.
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

TEST(DecodeIntensity, IsThatOfTheColoursWhateverTheFileAndTheFactor) {
  const TempDir dir;
  const fs::path jpeg = dir.path() / "c.jpg", png = dir.path() / "c.png";
  ASSERT_TRUE(WriteColourFile(jpeg, Waves(160, 120)).ok());
  ASSERT_TRUE(WriteColourFile(png, Waves(160, 120)).ok());
  for (const int factor : {1, 2, 3, 4, 5, 6, 7, 8, 16, 32}) {
    for (const fs::path& file : {jpeg, png}) {
      const IntensityImage expected = IntensityOf(*ReadColourFile(file, 160, 120), factor);
      const Result<IntensityImage> read = DecodeIntensity(ReadText(file), file, 160, 120, factor);
      ASSERT_TRUE(read.ok()) << read.error().message;
      ASSERT_EQ(read->width(), expected.width());
      ASSERT_EQ(read->height(), expected.height());
      for (std::size_t k = 0; k < expected.size(); ++k)
        ASSERT_NEAR(read->data()[k], expected.data()[k], file == png ? 0.0F : 3.0F) << factor;
    }
  }
}

TEST(DecodeIntensity, RefusesWhatColoursRefuse) {
  const TempDir dir;
  const fs::path file = dir.path() / "c.jpg";
  ASSERT_TRUE(WriteColourFile(file, Waves(40, 30)).ok());
  const std::string jpeg = ReadText(file);
  EXPECT_THAT(DecodeIntensity(jpeg, file, 30, 40, 2).error().message,
              HasSubstr("40 x 30 px, the camera 30 x 40"));
  for (std::size_t percent = 0; percent < 100; percent += 7) {
    const std::string part = jpeg.substr(0, jpeg.size() * percent / 100);
    EXPECT_FALSE(DecodeIntensity(part, file, 40, 30, 2).ok()) << percent << " %";
  }
}

TEST(ImageFiles, EveryTruncationIsRefused) {
  const TempDir dir;
  ColourImage colour(40, 30);
  Random random(8);
  for (Rgb8& c : colour) c = {static_cast<std::uint8_t>(random.Index(256)), 0, 99};
  ASSERT_TRUE(WriteColourFile(dir.path() / "c.jpg", colour).ok());
  ASSERT_TRUE(WriteDepthFile(dir.path() / "d.png", RandomDepth(40, 30)).ok());
  const std::string jpeg = ReadText(dir.path() / "c.jpg");
  const std::string png = ReadText(dir.path() / "d.png");
  for (int percent = 0; percent < 100; percent += 7) {
    WriteText(dir.path() / "c.jpg",
              jpeg.substr(0, jpeg.size() * static_cast<std::size_t>(percent) / 100));
    WriteText(dir.path() / "d.png",
              png.substr(0, png.size() * static_cast<std::size_t>(percent) / 100));
    EXPECT_FALSE(ReadColourFile(dir.path() / "c.jpg", 40, 30).ok()) << percent << " %";
    EXPECT_FALSE(ReadDepthFile(dir.path() / "d.png", 40, 30).ok()) << percent << " %";
  }
}

TEST(ImageFiles, FlippedBytesNeverCrash) {
  const TempDir dir;
  ASSERT_TRUE(WriteDepthFile(dir.path() / "d.png", RandomDepth(40, 30)).ok());
  const std::string png = ReadText(dir.path() / "d.png");
  Random random(9);
  for (int round = 0; round < 60; ++round) {
    std::string bytes = png;
    bytes[random.Index(bytes.size())] ^= static_cast<char>(1 + random.Index(255));
    WriteText(dir.path() / "d.png", bytes);
    const Result<RawDepthImage> read = ReadDepthFile(dir.path() / "d.png", 40, 30);
    if (read.ok()) {
      EXPECT_EQ(read->width(), 40);
    } else {
      EXPECT_THAT(read.error().message, HasSubstr("d.png"));
    }
  }
}

TEST(ImageFiles, FoldersMissingAndHugeFilesAreErrors) {
  const TempDir dir;
  EXPECT_THAT(ReadFileBytes(dir.path()).error().message, HasSubstr("not a file"));
  EXPECT_THAT(ReadFileBytes(dir.path() / "x").error().message, HasSubstr("missing"));
  WriteText(dir.path() / "big", std::string(100, 'x'));
  EXPECT_THAT(ReadFileBytes(dir.path() / "big", 99).error().message,
              AllOf(HasSubstr("big"), HasSubstr("100 bytes")));
}

TEST(ImageFiles, UnwritablePlaceIsAFailure) {
  const TempDir dir;
  const Status written = WriteDepthFile(dir.path() / "no/such/folder/d.png", RandomDepth(4, 4));
  ASSERT_FALSE(written.ok());
  EXPECT_THAT(written.error().message, AllOf(HasSubstr("d.png"), HasSubstr("disk full")));
}

}  // namespace
}  // namespace deepslam::dataset

#include "deepslam/layouts/suggest_settings.h"

#include <gmock/gmock.h>

#include <fmt/format.h>

#include "deepslam/layouts/open_capture.h"
#include "foreign_captures.h"
#include "layout_writers.h"
#include "opened_capture.h"

namespace deepslam::layouts {
namespace {

namespace fs = std::filesystem;
using testing::AllOf;
using testing::Contains;
using testing::ElementsAre;
using testing::HasSubstr;
using testing_support::ReadText;
using testing_support::TempDir;
using testing_support::WriteText;

void WriteFolders(const fs::path& folder, cv::Size colour, cv::Size depth, int raw) {
  for (int i = 0; i < 3; ++i) {
    WriteText(folder / fmt::format("rgb/{}.png", i),
              foreign::Encoded(".png", cv::Mat(colour, CV_8UC3, cv::Scalar(9, 90, 30 * i))));
    WriteText(folder / fmt::format("depth/{}.png", i),
              foreign::Encoded(".png", cv::Mat(depth, CV_16UC1, cv::Scalar(raw))));
  }
}

TEST(SuggestSettings, WhatIsWrittenIsReadAndDoubted) {
  const TempDir dir;
  WriteFolders(dir.path(), {640, 480}, {640, 480}, 2000);
  ASSERT_FALSE(OpenCapture(dir.path()).ok());
  const auto settings = SuggestSettings(dir.path());
  ASSERT_TRUE(settings.ok()) << settings.error().message;
  EXPECT_THAT(settings->assumed, ElementsAre("camera", "depth_units_per_m"));
  ASSERT_TRUE(WriteSuggestedSettings(dir.path(), *settings).ok());
  const dataset::Capture capture = Open(dir.path());
  ASSERT_NE(capture.frames, nullptr);
  EXPECT_EQ(capture.frames->camera(), settings->camera);
  EXPECT_FLOAT_EQ(capture.frames->ReadDepth(FrameIdx{0})->depth_m(5, 5), 2);
  EXPECT_THAT(capture.doubts, Contains(AllOf(HasSubstr("'camera'"), HasSubstr("assumed"))));
  EXPECT_THAT(capture.doubts, Contains(HasSubstr("'depth_units_per_m'")));
}

TEST(SuggestSettings, NothingIsWrittenOver) {
  const TempDir dir;
  WriteFolders(dir.path(), {64, 48}, {64, 48}, 2000);
  WriteText(dir.path() / "capture.yaml", "max_frames: 7\n");
  const Status written = WriteSuggestedSettings(dir.path(), *SuggestSettings(dir.path()));
  ASSERT_FALSE(written.ok());
  EXPECT_THAT(written.error().message, AllOf(HasSubstr("capture.yaml"), HasSubstr("exists")));
  EXPECT_EQ(ReadText(dir.path() / "capture.yaml"), "max_frames: 7\n");
}

TEST(SuggestSettings, UnitsAreThoseOfARoom) {
  for (const auto& [raw, units] : {std::pair(1500, 1000.0), {9000, 5000.0}, {36000, 6553.5}}) {
    const TempDir dir;
    WriteFolders(dir.path(), {64, 48}, {64, 48}, raw);
    EXPECT_EQ(SuggestSettings(dir.path())->depth_units_per_m, units) << raw;
  }
}

TEST(SuggestSettings, RealNumbersAreMetres) {
  const TempDir dir;
  WriteText(dir.path() / "images/0.png", foreign::ColourFile(0));
  WriteText(dir.path() / "depth/0.npy", foreign::NpyDepth(0));
  const auto settings = SuggestSettings(dir.path());
  ASSERT_TRUE(settings.ok());
  EXPECT_THAT(settings->assumed, ElementsAre("camera"));
}

TEST(SuggestSettings, DepthOfAnotherShapeHasACameraOfItsOwn) {
  const TempDir dir;
  WriteFolders(dir.path(), {128, 72}, {64, 58}, 1000);
  const auto settings = SuggestSettings(dir.path());
  ASSERT_TRUE(settings.ok());
  ASSERT_TRUE(settings->depth_camera.has_value());
  EXPECT_EQ(settings->depth_camera->width, 64);
  EXPECT_THAT(settings->assumed, Contains("colour_from_depth"));
  ASSERT_TRUE(WriteSuggestedSettings(dir.path(), *settings).ok());
  EXPECT_NE(Open(dir.path()).frames, nullptr);
}

TEST(SuggestSettings, OtherFoldersAreRefused) {
  const TempDir dir;
  EXPECT_THAT(SuggestSettings(dir.path()).error().message, HasSubstr("holds none"));
  WriteText(dir.path() / "rgb/0.png", foreign::ColourFile(0));
  EXPECT_FALSE(SuggestSettings(dir.path()).ok());
  WriteText(dir.path() / "depth/0.png", "no image");
  EXPECT_THAT(SuggestSettings(dir.path()).error().message, HasSubstr("depth/0.png"));
}

}  // namespace
}  // namespace deepslam::layouts

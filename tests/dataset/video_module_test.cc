#include "deepslam/dataset/load_video_module.h"

#include <gmock/gmock.h>

#include "deepslam/dataset/video_file.h"
#include "deepslam/video/video_module.h"
#include "support/temp_dir.h"

namespace deepslam::dataset {
namespace {

using testing::AllOf;
using testing::HasSubstr;
using testing_support::TempDir;
using testing_support::WriteText;

TEST(LoadVideoModule, FindsTheOneThatWasBuilt) {
  const auto module = LoadVideoModule(video::kModuleFile);
  ASSERT_TRUE(module.ok()) << module.error().message;
  EXPECT_EQ((*module)->version, video::VideoModule::kVersion);
  EXPECT_EQ((*module)->open("/nonexistent/rgb.mp4"), nullptr);
}

TEST(LoadVideoModule, SaysWhatIsMissingWhereItWasLookedForAndWhatToDo) {
  const auto module = LoadVideoModule("libdeepslam_flicker_book.so");
  ASSERT_FALSE(module.ok());
  EXPECT_THAT(module.error().message,
              AllOf(HasSubstr("videos need libdeepslam_flicker_book.so"),
                    HasSubstr("No such file"),
                    HasSubstr("lib/deepslam"),
                    HasSubstr("install deepslam anew")));
}

TEST(LoadVideoModule, RefusesOtherLibraries) {
  EXPECT_THAT(LoadVideoModule("libm.so.6").error().message,
              AllOf(HasSubstr("libm.so.6"), HasSubstr("it has no deepslam_video_module")));
}

TEST(VideoFile, WhatIsNoVideoIsRefusedByName) {
  const TempDir dir;
  WriteText(dir.path() / "rgb.mp4", "no video");
  EXPECT_THAT(VideoFile::Open(dir.path() / "rgb.mp4").error().message,
              AllOf(HasSubstr("rgb.mp4"), HasSubstr("not a video")));
}

}  // namespace
}  // namespace deepslam::dataset

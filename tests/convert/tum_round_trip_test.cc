#include <gmock/gmock.h>

#include "deepslam/convert/tum_writer.h"
#include "deepslam/core/random.h"
#include "deepslam/dataset/memory_frame_source.h"
#include "deepslam/layouts/open_capture.h"
#include "support/pose_matchers.h"
#include "support/temp_dir.h"

namespace deepslam::convert {
namespace {

using testing::HasSubstr;
using testing_support::TempDir;

dataset::CaptureSettings Settings() {
  dataset::CaptureSettings settings;
  settings.camera = {40, 30, 35.25, 35.5, 19.5, 14.25};
  settings.depth_units_per_m = 1000;
  return settings;
}

Frame MakeFrame(int i) {
  Random random(static_cast<std::uint64_t>(i));
  Frame frame{FrameIdx{i},
              0.25 * i,
              ColourImage(40, 30, Rgb8{static_cast<std::uint8_t>(40 * i), 90, 30}),
              DepthImage(40, 30)};
  for (float& d : frame.depth_m) d = static_cast<float>(random.Uniform(0.3, 9.0));
  for (int v = 0; v < 30; ++v)
    for (int u = 32; u < 40; ++u) frame.colour(u, v) = {200, 210, 220};  // not all of one tone
  frame.depth_m(0, 0) = 0;
  frame.depth_m(1, 0) = 70;  // does not fit 16 bits at 1000 units per metre
  return frame;
}

TEST(TumRoundTrip, WriterAndReaderAgree) {
  const TempDir dir;
  Result<TumWriter> writer = TumWriter::Create(dir.path() / "capture", Settings());
  ASSERT_TRUE(writer.ok()) << writer.error().message;
  const auto pose = [](int i) {
    return Pose3{RotationFromVector({0.1 * i, 0.2, -0.3}), {1.0 * i, 2, -3}};
  };
  for (int i = 0; i < 3; ++i) ASSERT_TRUE(writer->AddFrame(MakeFrame(i), pose(i)).ok());
  ASSERT_TRUE(writer->Finish().ok());

  const Result<dataset::Capture> capture = layouts::OpenCapture(dir.path() / "capture");
  ASSERT_TRUE(capture.ok()) << capture.error().message;
  EXPECT_TRUE(capture->warnings.empty());
  EXPECT_EQ(capture->frames->camera(), Settings().camera);
  ASSERT_EQ(capture->frames->num_frames(), 3);
  for (int i = 0; i < 3; ++i) {
    const Frame written = MakeFrame(i);
    const Result<Frame> read = capture->frames->Read(FrameIdx{i});
    ASSERT_TRUE(read.ok());
    EXPECT_DOUBLE_EQ(read->time_s, written.time_s);
    EXPECT_THAT(*capture->frames->capture_world_from_camera(FrameIdx{i}),
                testing_support::PoseNear(pose(i), 1e-8, 1e-6));
    EXPECT_EQ(read->depth_m(0, 0), 0);
    EXPECT_EQ(read->depth_m(1, 0), 0);
    for (int v = 1; v < 30; ++v) {
      for (int u = 0; u < 40; ++u)
        ASSERT_NEAR(read->depth_m(u, v), written.depth_m(u, v), 0.00051f);
    }
    EXPECT_NEAR(read->colour(20, 15).r, written.colour(20, 15).r, 3) << "JPEG";
  }
}

TEST(TumWriter, LeavesFoldersOfOthersAlone) {
  const TempDir dir;
  testing_support::WriteText(dir.path() / "mine.txt", "x");
  const Result<TumWriter> writer = TumWriter::Create(dir.path(), Settings());
  ASSERT_FALSE(writer.ok());
  EXPECT_THAT(writer.error().message, HasSubstr("not an empty folder"));
  EXPECT_FALSE(std::filesystem::exists(dir.path() / "rgb"));
}

TEST(TumReader, SaturatedAndFarDepthIsInvalid) {
  const TempDir dir;
  dataset::CaptureSettings settings = Settings();
  Result<TumWriter> writer = TumWriter::Create(dir.path() / "capture", settings);
  ASSERT_TRUE(writer.ok());
  Frame frame = MakeFrame(0);
  for (float& d : frame.depth_m) d = 2;
  frame.depth_m(3, 3) = 19.9f;
  frame.depth_m(4, 3) = 20.1f;
  frame.depth_m(5, 3) = 65.535f;
  ASSERT_TRUE(writer->AddFrame(frame, std::nullopt).ok());
  ASSERT_TRUE(writer->Finish().ok());
  const Result<dataset::Capture> capture = layouts::OpenCapture(dir.path() / "capture");
  ASSERT_TRUE(capture.ok());
  EXPECT_FALSE(capture->has_poses);
  const Result<Frame> read = capture->frames->ReadDepth(FrameIdx{0});
  EXPECT_FLOAT_EQ(read->depth_m(3, 3), 19.9f);
  EXPECT_EQ(read->depth_m(4, 3), 0);
  EXPECT_EQ(read->depth_m(5, 3), 0);
}

TEST(MemoryFrameSource, GivesFramesBackAndNamesEmptyOnes) {
  std::vector<Frame> frames = {MakeFrame(5), Frame()};
  const dataset::MemoryFrameSource source(Settings().camera, frames, {Pose3(), std::nullopt});
  EXPECT_EQ(source.num_frames(), 2);
  EXPECT_EQ(source.Read(FrameIdx{0})->idx, FrameIdx{0});
  EXPECT_EQ(source.ReadDepth(FrameIdx{0})->depth_m, frames[0].depth_m);
  EXPECT_TRUE(source.capture_world_from_camera(FrameIdx{0}).has_value());
  EXPECT_FALSE(source.capture_world_from_camera(FrameIdx{1}).has_value());
  EXPECT_THAT(source.Read(FrameIdx{1}).error().message, HasSubstr("frame 1"));
}

}  // namespace
}  // namespace deepslam::convert

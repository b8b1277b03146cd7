// What holds for every layout that is read: whole captures are read as they were written; cut,
// damaged, hostile and future files are read or refused by name, and never end the program.
#include <algorithm>
#include <cctype>

#include <gmock/gmock.h>

#include <fmt/format.h>

#include "deepslam/core/random.h"
#include "deepslam/layouts/open_capture.h"
#include "foreign_captures.h"
#include "layout_writers.h"
#include "opened_capture.h"
#include "support/allocation_watch.h"
#include "support/pose_matchers.h"

namespace deepslam::layouts {
namespace {

namespace fs = std::filesystem;
using foreign::WrittenLayout;
using testing::HasSubstr;
using testing_support::PoseNear;
using testing_support::ReadText;
using testing_support::TempDir;
using testing_support::WriteText;

class EveryLayout : public testing::TestWithParam<WrittenLayout> {};

// Reads all there is of it; a refusal names the capture.
void ReadOrRefuse(const fs::path& folder) {
  const Result<dataset::Capture> capture = OpenCapture(folder);
  if (!capture.ok()) {
    EXPECT_EQ(capture.error().code, ErrorCode::kInvalidInput);
    EXPECT_THAT(capture.error().message, HasSubstr(folder.filename().string()));
    return;
  }
  for (int i = 0; i < capture->frames->num_frames(); ++i) {
    const Result<Frame> frame = capture->frames->Read(FrameIdx{i});
    if (!frame.ok()) {
      EXPECT_FALSE(frame.error().message.empty());
      continue;
    }
    EXPECT_TRUE(std::all_of(
        frame->depth_m.begin(), frame->depth_m.end(), [](float m) { return m >= 0 && m < 100; }));
  }
}

TEST_P(EveryLayout, IsReadAsItWasWritten) {
  const TempDir dir;
  GetParam().write(dir.path());
  const dataset::Capture capture = Open(dir.path());
  ASSERT_NE(capture.frames, nullptr);
  EXPECT_EQ(capture.format, GetParam().name);
  EXPECT_TRUE(capture.has_poses);
  const FrameSource& frames = *capture.frames;
  ASSERT_EQ(frames.num_frames(), foreign::kWrittenFrames);
  const PinholeCamera truth{32, 24, 30.3, 30.3, 15.5, 11.25};
  const PinholeCamera& camera = frames.camera();
  EXPECT_EQ(camera.width, truth.width);
  EXPECT_EQ(camera.height, truth.height);
  for (const auto& [read, written] : {std::pair(camera.fx, truth.fx),
                                      {camera.fy, truth.fy},
                                      {camera.cx, truth.cx},
                                      {camera.cy, truth.cy}}) {
    EXPECT_NEAR(read, written, 1e-9);
  }
  // Real numbers are held in thirds of a millimetre.
  const float tolerance_m = GetParam().real_depth ? 0.0002F : 1e-6F;
  for (int i = 0; i < foreign::kWrittenFrames; ++i) {
    const Result<Frame> frame = frames.Read(FrameIdx{i});
    ASSERT_TRUE(frame.ok()) << frame.error().message;
    EXPECT_NEAR(frame->time_s - frames.time_s(FrameIdx{0}), i * GetParam().time_step_s, 1e-6);
    for (int v = 0; v < foreign::kHeight; ++v) {
      for (int u = 0; u < foreign::kWidth; ++u) {
        ASSERT_NEAR(frame->depth_m(u, v), 0.001F * foreign::DepthMm(i, u, v), tolerance_m)
            << "frame " << i << " at " << u << ", " << v;
        const auto rgb = foreign::Rgb(i, u, v);
        ASSERT_EQ(frame->colour(u, v), (Rgb8{rgb[0], rgb[1], rgb[2]}));
      }
    }
    const auto m = foreign::Matrix(i);
    Eigen::Matrix4d matrix;
    for (int k = 0; k < 16; ++k) matrix(k / 4, k % 4) = m[static_cast<std::size_t>(k)];
    const std::optional<Pose3> pose = frames.capture_world_from_camera(FrameIdx{i});
    ASSERT_TRUE(pose.has_value()) << "frame " << i;
    EXPECT_THAT(*pose, PoseNear(Pose3::FromMatrix(matrix), 2e-5, 1e-2)) << "frame " << i;
  }
}

TEST_P(EveryLayout, GivesEveryNthFrame) {
  const TempDir dir;
  GetParam().write(dir.path());
  const dataset::Capture capture = Open(dir.path());
  ASSERT_NE(capture.frames, nullptr);
  ExpectEveryNthIsItself(capture);
}

TEST_P(EveryLayout, HashFollowsTextsAndImages) {
  const TempDir dir;
  GetParam().write(dir.path());
  const std::string hash = Open(dir.path()).content_hash;
  WriteText(dir.path() / "notes.md", "not part of the capture");
  EXPECT_EQ(Open(dir.path()).content_hash, hash);
  const std::string yaml = GetParam().name == "habitat" || GetParam().name == "folders"
                               ? ReadText(dir.path() / "capture.yaml")
                               : "";
  WriteText(dir.path() / "capture.yaml", yaml + "max_frames: 3\n");
  EXPECT_NE(Open(dir.path()).content_hash, hash);
}

TEST_P(EveryLayout, FilesOfMacOsAreNoImages) {
  const TempDir dir;
  GetParam().write(dir.path());
  std::vector<fs::path> files;
  for (const auto& entry : fs::recursive_directory_iterator(dir.path()))
    if (entry.is_regular_file()) files.push_back(entry.path());
  for (const fs::path& file : files)
    WriteText(file.parent_path() / ("._" + file.filename().string()), "Mac OS X resource fork");
  const dataset::Capture capture = Open(dir.path());
  ASSERT_NE(capture.frames, nullptr);
  EXPECT_EQ(capture.frames->num_frames(), foreign::kWrittenFrames);
  for (int i = 0; i < foreign::kWrittenFrames; ++i)
    EXPECT_TRUE(capture.frames->Read(FrameIdx{i}).ok());
}

TEST_P(EveryLayout, CutFilesAreReadOrRefused) {
  for (const std::string& name : GetParam().texts) {
    const TempDir dir;
    GetParam().write(dir.path());
    const std::string whole = ReadText(dir.path() / name);
    ASSERT_FALSE(whole.empty()) << name;
    const std::size_t step = std::max<std::size_t>(1, whole.size() / 12);
    for (std::size_t size = 0; size < whole.size(); size += step) {
      SCOPED_TRACE(fmt::format("{} cut at {}", name, size));
      WriteText(dir.path() / name, whole.substr(0, size));
      ReadOrRefuse(dir.path());
    }
    fs::remove(dir.path() / name);
    ReadOrRefuse(dir.path());
  }
}

TEST_P(EveryLayout, DamagedFilesAreReadOrRefused) {
  Random random(7);
  for (const std::string& name : GetParam().texts) {
    const TempDir dir;
    GetParam().write(dir.path());
    const std::string whole = ReadText(dir.path() / name);
    for (int trial = 0; trial < 12; ++trial) {
      SCOPED_TRACE(fmt::format("{} trial {}", name, trial));
      std::string bytes = whole;
      for (int k = 0; k < 3; ++k)
        bytes[random.Index(bytes.size())] = static_cast<char>(random.Index(256));
      WriteText(dir.path() / name, bytes);
      ReadOrRefuse(dir.path());
    }
  }
}

// Each number of a text in turn, taken for what a stranger may have put there.
TEST_P(EveryLayout, HostileNumbersAreReadOrRefusedWithoutTheirMemory) {
  const auto digit = [](char c) { return std::isdigit(static_cast<unsigned char>(c)) != 0; };
  for (const std::string& name : GetParam().texts) {
    if (name.ends_with(".db") || name.ends_with(".exr") || name.ends_with(".pgm")) continue;
    const TempDir dir;
    GetParam().write(dir.path());
    const std::string whole = ReadText(dir.path() / name);
    int num_numbers = 0;
    for (std::size_t at = 0; at < whole.size() && num_numbers < 12; ++at) {
      if (!digit(whole[at]) || (at > 0 && !std::isspace(static_cast<unsigned char>(whole[at - 1]))))
        continue;
      ++num_numbers;
      const std::size_t end =
          std::min(whole.find_first_not_of("0123456789.eE+-", at), whole.size());
      for (const char* lie : {"1e999", "-1", "99999999999999999999", "nan", "0"}) {
        SCOPED_TRACE(fmt::format("{} at {}: {}", name, at, lie));
        WriteText(dir.path() / name, whole.substr(0, at) + lie + whole.substr(end));
        testing_support::ForgetAllocations();
        ReadOrRefuse(dir.path());
        EXPECT_LE(testing_support::LargestAllocation(), std::size_t{32} << 20);
      }
    }
    EXPECT_GT(num_numbers, 0) << name;
  }
}

// Newer versions add files and fields; what is known stays what it was.
TEST_P(EveryLayout, FutureFilesAndFieldsChangeNothing) {
  const TempDir dir;
  GetParam().write(dir.path());
  WriteText(dir.path() / "session_v9.json", "{}");
  WriteText(dir.path() / "lidar/0.bin", "x");
  for (const std::string& name : GetParam().texts) {
    if (!name.ends_with(".json")) continue;
    std::string text = ReadText(dir.path() / name);
    text.insert(text.find('{') + 1, "\"formatRevision\": {\"of\": [9]}, ");
    WriteText(dir.path() / name, text);
  }
  const dataset::Capture capture = Open(dir.path());
  ASSERT_NE(capture.frames, nullptr);
  EXPECT_EQ(capture.format, GetParam().name);
  EXPECT_EQ(capture.frames->num_frames(), foreign::kWrittenFrames);
  EXPECT_TRUE(capture.frames->capture_world_from_camera(FrameIdx{3}).has_value());
}

INSTANTIATE_TEST_SUITE_P(All,
                         EveryLayout,
                         testing::ValuesIn(foreign::WrittenLayouts()),
                         [](const auto& test) {
                           std::string name;
                           for (const char c : test.param.name)
                             if (std::isalnum(static_cast<unsigned char>(c)) != 0) name += c;
                           return name;
                         });

}  // namespace
}  // namespace deepslam::layouts

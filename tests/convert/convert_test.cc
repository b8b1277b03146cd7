#include "deepslam/convert/convert.h"

#include <cmath>
#include <cstring>
#include <sstream>

#include <gmock/gmock.h>

#include <fmt/format.h>

#include "deepslam/convert/posed_frames.h"

#include "layouts/foreign_captures.h"
#include "layouts/opened_capture.h"
#include "support/pose_matchers.h"

namespace deepslam::convert {
namespace {

namespace fs = std::filesystem;
using testing::AllOf;
using testing::Contains;
using testing::HasSubstr;
using testing::IsEmpty;
using testing::Not;
using testing_support::PoseNear;
using testing_support::ReadText;
using testing_support::TempDir;
using testing_support::WriteText;

constexpr int kNumFrames = 4;
const std::string kCamera = "{width: 32, height: 24, fx: 30.3, fy: 30.3, cx: 15.5, cy: 11.25}";

ConversionReport Convert(const fs::path& from,
                         const fs::path& to,
                         const std::string& format,
                         double units = 0) {
  const dataset::Capture capture = layouts::Open(from);
  const Result<ConversionReport> report =
      ConvertCapture(capture, to, *FindOutputFormat(format), units, {});
  EXPECT_TRUE(report.ok()) << (report.ok() ? "" : report.error().message);
  return report.ok() ? *report : ConversionReport();
}

// JPEG colour, 5000 units per metre, times of today, colour earlier than depth, a pose missing.
void WriteTum(const fs::path& folder, int lost_frame = 2) {
  std::string associations;
  std::string poses;
  for (int i = 0; i < kNumFrames; ++i) {
    WriteText(folder / fmt::format("rgb/{}.jpg", i), layouts::foreign::ColourFile(i, ".jpg"));
    WriteText(folder / fmt::format("depth/{}.png", i), layouts::foreign::DepthFile(i, 5));
    const double colour_s = 1341841278.8427 + 0.25 * i;
    associations +=
        fmt::format("{0:.4f} rgb/{2}.jpg {1:.4f} depth/{2}.png\n", colour_s, colour_s + 0.0132, i);
    if (i != lost_frame)
      poses += fmt::format("{:.4f} {}\n", colour_s + 0.0132, layouts::foreign::Tum(i));
  }
  WriteText(folder / "associations.txt", associations);
  WriteText(folder / "groundtruth.txt", poses);
  WriteText(folder / "capture.yaml",
            "format: tum\ncamera: " + kCamera + "\ndepth_units_per_m: 5000\n");
}

void WriteSevenScenes(const fs::path& folder) {
  for (int i = 0; i < kNumFrames; ++i) {
    const std::string stem = "frame-" + layouts::foreign::Digits(i, 6);
    WriteText(folder / (stem + ".color.png"), layouts::foreign::ColourFile(i));
    WriteText(folder / (stem + ".depth.png"), layouts::foreign::DepthFile(i, 1, 65535));
    WriteText(folder / (stem + ".pose.txt"),
              layouts::foreign::MatrixText(layouts::foreign::Matrix(i)));
  }
  WriteText(folder / "capture.yaml", "camera: " + kCamera + "\n");
}

void ExpectEqualFrames(const dataset::Capture& a, const dataset::Capture& b) {
  ASSERT_EQ(a.frames->num_frames(), b.frames->num_frames());
  EXPECT_EQ(a.frames->camera(), b.frames->camera());
  for (int i = 0; i < a.frames->num_frames(); ++i) {
    const Result<Frame> frame_a = a.frames->Read(FrameIdx{i});
    const Result<Frame> frame_b = b.frames->Read(FrameIdx{i});
    ASSERT_TRUE(frame_a.ok() && frame_b.ok());
    EXPECT_EQ(frame_a->colour, frame_b->colour) << "frame " << i;
    EXPECT_EQ(frame_a->depth_m, frame_b->depth_m) << "frame " << i;
  }
}

void ExpectEqualPoses(const dataset::Capture& a,
                      const dataset::Capture& b,
                      double tolerance_m,
                      double tolerance_deg) {
  for (int i = 0; i < a.frames->num_frames(); ++i) {
    const std::optional<Pose3> pose_a = a.frames->capture_world_from_camera(FrameIdx{i});
    const std::optional<Pose3> pose_b = b.frames->capture_world_from_camera(FrameIdx{i});
    ASSERT_EQ(pose_a.has_value(), pose_b.has_value()) << "frame " << i;
    if (!pose_a) continue;
    EXPECT_THAT(*pose_b, PoseNear(*pose_a, tolerance_m, tolerance_deg)) << "frame " << i;
  }
}

void ExpectEqualTimes(const dataset::Capture& a, const dataset::Capture& b) {
  for (std::size_t i = 0; i < a.stored->frames().size(); ++i) {
    EXPECT_EQ(a.stored->frames()[i].colour_time_s, b.stored->frames()[i].colour_time_s);
    EXPECT_EQ(a.stored->frames()[i].depth_time_s, b.stored->frames()[i].depth_time_s);
  }
}

TEST(Convert, TumToSensToTumKeepsPixelsTimesAndUnits) {
  const TempDir dir;
  WriteTum(dir.path() / "tum");
  const ConversionReport there = Convert(dir.path() / "tum", dir.path() / "a.sens", "scannet");
  const ConversionReport back = Convert(dir.path() / "a.sens", dir.path() / "again", "tum");
  const dataset::Capture first = layouts::Open(dir.path() / "tum");
  const dataset::Capture last = layouts::Open(dir.path() / "again");
  EXPECT_EQ(last.format, "tum");
  EXPECT_THAT(last.warnings, IsEmpty());
  ExpectEqualFrames(first, last);
  ExpectEqualTimes(first, last);
  // .sens holds poses as 32-bit floats.
  ExpectEqualPoses(first, last, 3e-7, 2e-5);
  for (std::size_t i = 0; i < kNumFrames; ++i) {
    EXPECT_EQ(first.stored->ReadColour(i)->bytes, last.stored->ReadColour(i)->bytes)
        << "JPEG bytes";
    EXPECT_EQ(*first.stored->ReadDepth(i), *last.stored->ReadDepth(i)) << "raw values";
  }
  EXPECT_EQ(there.num_frames, kNumFrames);
  EXPECT_EQ(there.num_poses, kNumFrames - 1);
  EXPECT_THAT(there.losses, Contains(HasSubstr("32-bit floats")));
  EXPECT_THAT(there.losses, Not(Contains(HasSubstr("times"))));
  EXPECT_THAT(back.losses, Contains(HasSubstr("1 frames have no pose")));
}

TEST(Convert, SevenScenesToOpen3dToTumKeepsPixelsAndPoses) {
  const TempDir dir;
  WriteSevenScenes(dir.path() / "seq-01");
  Convert(dir.path() / "seq-01", dir.path() / "o3d", "open3d");
  Convert(dir.path() / "o3d", dir.path() / "tum", "tum");
  const dataset::Capture first = layouts::Open(dir.path() / "seq-01");
  const dataset::Capture middle = layouts::Open(dir.path() / "o3d");
  const dataset::Capture last = layouts::Open(dir.path() / "tum");
  EXPECT_EQ(middle.format, "open3d");
  EXPECT_FALSE(middle.has_times);
  ExpectEqualFrames(first, middle);
  ExpectEqualFrames(first, last);
  ExpectEqualTimes(first, last);
  ExpectEqualPoses(first, last, 1e-14, 1e-6);
  for (std::size_t i = 0; i < kNumFrames; ++i) {
    EXPECT_EQ(first.stored->ReadColour(i)->bytes, last.stored->ReadColour(i)->bytes) << "PNG bytes";
    RawDepthImage raw = *first.stored->ReadDepth(i);
    std::replace(raw.begin(), raw.end(), std::uint16_t{65535}, std::uint16_t{0});
    EXPECT_EQ(raw, *last.stored->ReadDepth(i)) << "raw values but that of nothing";
  }
  // And home again: 0 becomes 65535.
  Convert(dir.path() / "tum", dir.path() / "seq-02", "7scenes");
  const dataset::Capture home = layouts::Open(dir.path() / "seq-02");
  for (std::size_t i = 0; i < kNumFrames; ++i)
    EXPECT_EQ(*first.stored->ReadDepth(i), *home.stored->ReadDepth(i));
  ExpectEqualPoses(first, home, 1e-14, 1e-6);
}

TEST(Convert, EveryPairOfLayoutsGivesTheSameDepthWithinAMillimetre) {
  const TempDir dir;
  WriteTum(dir.path() / "source", -1);
  const dataset::Capture first = layouts::Open(dir.path() / "source");
  for (const OutputFormat& a : OutputFormats()) {
    if (!a.holds_depth) continue;
    const fs::path middle = dir.path() / fmt::format("{}{}", a.name, a.is_file ? ".sens" : "");
    Convert(dir.path() / "source", middle, std::string(a.name));
    for (const OutputFormat& b : OutputFormats()) {
      if (!b.holds_depth) continue;
      const fs::path last =
          dir.path() / fmt::format("{}-{}{}", a.name, b.name, b.is_file ? ".sens" : "");
      Convert(middle, last, std::string(b.name));
      const dataset::Capture read = layouts::Open(last);
      ASSERT_EQ(read.frames->num_frames(), kNumFrames) << a.name << " " << b.name;
      for (int i = 0; i < kNumFrames; ++i) {
        const DepthImage before = first.frames->ReadDepth(FrameIdx{i})->depth_m;
        const DepthImage after = read.frames->ReadDepth(FrameIdx{i})->depth_m;
        for (std::size_t p = 0; p < before.size(); ++p)
          ASSERT_NEAR(before.data()[p], after.data()[p], 0.00051f) << a.name << " " << b.name;
        EXPECT_EQ(first.frames->ReadColour(FrameIdx{i})->colour,
                  read.frames->ReadColour(FrameIdx{i})->colour);
      }
      ExpectEqualPoses(first, read, 5e-7, 3e-5);
    }
  }
}

TEST(Layouts, GiveEveryNthFrame) {
  const TempDir dir;
  WriteTum(dir.path() / "source", -1);
  for (const OutputFormat& format : OutputFormats()) {
    if (!format.holds_depth) continue;
    SCOPED_TRACE(format.name);
    const fs::path to =
        dir.path() / fmt::format("{}{}", format.name, format.is_file ? ".sens" : "");
    Convert(dir.path() / "source", to, std::string(format.name));
    layouts::ExpectEveryNthIsItself(layouts::Open(to));
  }
}

TEST(Convert, TakesAllFramesWhateverARunTakes) {
  const TempDir dir;
  WriteTum(dir.path() / "source");
  const std::string settings = ReadText(dir.path() / "source" / "capture.yaml");
  WriteText(dir.path() / "source" / "capture.yaml", settings + "max_frames: 2\n");
  EXPECT_LE(layouts::Open(dir.path() / "source").frames->num_frames(), 2);
  const Result<dataset::Capture> all =
      layouts::OpenCapture(dir.path() / "source", layouts::FramesTaken::kAll);
  ASSERT_TRUE(all.ok());
  EXPECT_EQ(all->frames->num_frames(), kNumFrames);
  EXPECT_THAT(all->warnings, IsEmpty());
}

TEST(Convert, SaysWhatIsLost) {
  const TempDir dir;
  WriteTum(dir.path() / "tum");
  EXPECT_THAT(Convert(dir.path() / "tum", dir.path() / "same", "tum").losses,
              testing::ElementsAre(HasSubstr("1 frames have no pose")));
  WriteText(dir.path() / "tum/accelerometer.txt", "0 1 2 3\n");
  const ConversionReport report = Convert(dir.path() / "tum", dir.path() / "seven", "7scenes");
  EXPECT_THAT(report.losses, Contains(HasSubstr("accelerometer.txt")));
  EXPECT_THAT(report.losses, Contains(HasSubstr("times: 7scenes has no place")));
  EXPECT_THAT(report.losses,
              Contains(AllOf(HasSubstr("1/1000 m instead of 1/5000 m"), HasSubstr("0.0005"))));
  EXPECT_THAT(report.notes, Contains(HasSubstr("4 colour images were decoded")));
  const std::string json = ReadText(dir.path() / "seven/conversion.json");
  EXPECT_THAT(
      json,
      AllOf(HasSubstr("\"losses\""), HasSubstr("times: 7scenes"), HasSubstr("\"from\": \"tum\"")));
  Convert(dir.path() / "tum", dir.path() / "b.sens", "scannet");
  EXPECT_TRUE(fs::exists(dir.path() / "b.sens.conversion.json"));
}

TEST(Convert, UnitsMayBeChosen) {
  const TempDir dir;
  WriteTum(dir.path() / "tum");
  const ConversionReport report = Convert(dir.path() / "tum", dir.path() / "o3d", "open3d", 1000);
  EXPECT_EQ(report.cameras.depth_units_per_m, 1000);
  EXPECT_FALSE(fs::exists(dir.path() / "o3d/config.json"));
  Convert(dir.path() / "tum", dir.path() / "o3d5000", "open3d");
  EXPECT_THAT(ReadText(dir.path() / "o3d5000/config.json"), HasSubstr("\"depth_scale\": 5000"));
  const dataset::Capture capture = layouts::Open(dir.path() / "tum");
  const auto refused =
      ConvertCapture(capture, dir.path() / "s", *FindOutputFormat("7scenes"), 5000, {});
  ASSERT_FALSE(refused.ok());
  EXPECT_EQ(refused.error().code, ErrorCode::kInvalidConfig);
  // 13 m do not fit 16 bits at 10000 units per metre: such pixels become invalid and are counted.
  cv::Mat far(layouts::foreign::kHeight, layouts::foreign::kWidth, CV_16UC1, cv::Scalar(50000));
  WriteText(dir.path() / "tum/depth/1.png", layouts::foreign::Encoded(".png", far));
  const ConversionReport fine = Convert(dir.path() / "tum", dir.path() / "fine", "tum", 10000);
  EXPECT_THAT(fine.losses, Contains(HasSubstr("768 pixels does not fit")));
}

TEST(Convert, UnregisteredDepthIsKeptWhereItCanBe) {
  const TempDir dir;
  layouts::foreign::SensOptions options;
  options.depth_extrinsics[3] = -0.1;
  WriteText(dir.path() / "a.sens", layouts::foreign::Sens(options));
  const dataset::Capture first = layouts::Open(dir.path() / "a.sens");
  Convert(dir.path() / "a.sens", dir.path() / "seven", "7scenes");
  Convert(dir.path() / "seven", dir.path() / "b.sens", "scannet");
  const dataset::Capture again = layouts::Open(dir.path() / "b.sens");
  for (std::size_t i = 0; i < first.stored->frames().size(); ++i) {
    EXPECT_EQ(*first.stored->ReadDepth(i), *again.stored->ReadDepth(i));
    EXPECT_EQ(first.stored->ReadColour(i)->bytes, again.stored->ReadColour(i)->bytes);
  }
  ExpectEqualPoses(first, again, 3e-7, 2e-5);
  const ConversionReport report = Convert(dir.path() / "a.sens", dir.path() / "tum", "tum");
  EXPECT_THAT(report.losses, Contains(HasSubstr("depth was registered to colour")));
  const dataset::Capture tum = layouts::Open(dir.path() / "tum");
  for (int i = 0; i < 3; ++i) {
    const DepthImage before = first.frames->ReadDepth(FrameIdx{i})->depth_m;
    const DepthImage after = tum.frames->ReadDepth(FrameIdx{i})->depth_m;
    for (std::size_t p = 0; p < before.size(); ++p)
      ASSERT_NEAR(before.data()[p], after.data()[p], 0.00051f);
  }
}

TEST(Convert, LeavesNothingBehindAndNothingOfOthersTouched) {
  const TempDir dir;
  WriteTum(dir.path() / "tum");
  const dataset::Capture capture = layouts::Open(dir.path() / "tum");
  const OutputFormat& tum = *FindOutputFormat("tum");
  WriteText(dir.path() / "mine/notes.txt", "x");
  const auto taken = ConvertCapture(capture, dir.path() / "mine", tum, 0, {});
  ASSERT_FALSE(taken.ok());
  EXPECT_EQ(taken.error().code, ErrorCode::kInvalidConfig);
  EXPECT_EQ(ReadText(dir.path() / "mine/notes.txt"), "x");
  const auto stopped = ConvertCapture(
      capture, dir.path() / "out", tum, 0, [](std::size_t done, std::size_t) { return done < 2; });
  ASSERT_FALSE(stopped.ok());
  EXPECT_EQ(stopped.error().code, ErrorCode::kInterrupted);
  const auto no_file =
      ConvertCapture(capture, dir.path() / "out", *FindOutputFormat("scannet"), 0, {});
  ASSERT_FALSE(no_file.ok());
  EXPECT_THAT(no_file.error().message, HasSubstr(".sens"));
  std::vector<std::string> left;
  for (const auto& entry : fs::directory_iterator(dir.path()))
    left.push_back(entry.path().filename().string());
  EXPECT_THAT(left, testing::UnorderedElementsAre("mine", "tum"));
  // An empty folder, named with a slash, is as good as a new one.
  fs::create_directories(dir.path() / "out");
  EXPECT_TRUE(ConvertCapture(capture, dir.path() / "out" / "", tum, 0, {}).ok());
}

TEST(Convert, UnreadableFramesAreLeftOutAndSaid) {
  const TempDir dir;
  WriteTum(dir.path() / "tum");
  WriteText(dir.path() / "tum/rgb/1.jpg", layouts::foreign::ColourFile(1, ".jpg").substr(0, 300));
  for (const char* format : {"tum", "open3d"}) {
    const fs::path out = dir.path() / fmt::format("out-{}", format);
    const ConversionReport report = Convert(dir.path() / "tum", out, format);
    EXPECT_EQ(report.num_frames, 3);
    EXPECT_THAT(report.losses,
                Contains(AllOf(HasSubstr("1 frames cannot be read"), HasSubstr("rgb/1.jpg"))));
    const dataset::Capture read = layouts::Open(out);
    ASSERT_EQ(read.frames->num_frames(), 3);
    // Frame 2 of the source, the one without a pose, is now the second.
    EXPECT_FALSE(read.frames->capture_world_from_camera(FrameIdx{1}));
    EXPECT_TRUE(read.frames->capture_world_from_camera(FrameIdx{2}));
  }
}

TEST(Convert, SameInputGivesTheSameBytes) {
  const TempDir dir;
  WriteTum(dir.path() / "tum");
  Convert(dir.path() / "tum", dir.path() / "a.sens", "scannet");
  Convert(dir.path() / "tum", dir.path() / "b.sens", "scannet");
  EXPECT_EQ(ReadText(dir.path() / "a.sens"), ReadText(dir.path() / "b.sens"));
}

// --- for training elsewhere

TEST(Convert, TumToNerfstudioKeepsPixelsAndPoses) {
  const TempDir dir;
  WriteTum(dir.path() / "tum", -1);
  const ConversionReport report = Convert(dir.path() / "tum", dir.path() / "ns", "nerfstudio");
  EXPECT_EQ(report.num_frames, kNumFrames);
  const dataset::Capture first = layouts::Open(dir.path() / "tum");
  const dataset::Capture last = layouts::Open(dir.path() / "ns");
  EXPECT_EQ(last.format, "nerfstudio");
  ASSERT_EQ(last.frames->num_frames(), kNumFrames);
  const PinholeCamera& camera = last.frames->camera();
  EXPECT_NEAR(camera.fx, 30.3, 1e-9);
  EXPECT_NEAR(camera.cx, 15.5, 1e-9);
  EXPECT_NEAR(camera.cy, 11.25, 1e-9);
  for (int i = 0; i < kNumFrames; ++i) {
    const Result<Frame> a = first.frames->Read(FrameIdx{i});
    const Result<Frame> b = last.frames->Read(FrameIdx{i});
    ASSERT_TRUE(a.ok() && b.ok());
    EXPECT_EQ(a->colour, b->colour);
    // Millimetres there.
    for (int v = 0; v < 24; ++v) {
      for (int u = 0; u < 32; ++u) ASSERT_NEAR(a->depth_m(u, v), b->depth_m(u, v), 0.00051);
    }
  }
  ExpectEqualPoses(first, last, 1e-9, 1e-6);
  // The centre of the first pixel is at (0.5, 0.5) there, and the camera's y up, its z back.
  const std::string text = ReadText(dir.path() / "ns/transforms.json");
  EXPECT_THAT(text, AllOf(HasSubstr("\"cx\": 16.0"), HasSubstr("\"cy\": 11.75")));
}

// Fields of the lines that are no comments.
std::vector<std::vector<std::string>> Rows(const fs::path& file) {
  std::vector<std::vector<std::string>> rows;
  std::istringstream lines(ReadText(file));
  for (std::string line; std::getline(lines, line);) {
    std::istringstream fields(line);
    std::vector<std::string> row;
    for (std::string field; fields >> field;) row.push_back(field);
    if (!row.empty() && !row.front().starts_with('#')) rows.push_back(row);
  }
  return rows;
}

TEST(Convert, TumToColmapHasCamerasPosesAndPointsOfTheDepth) {
  const TempDir dir;
  WriteTum(dir.path() / "tum", -1);
  const ConversionReport report = Convert(dir.path() / "tum", dir.path() / "colmap", "colmap");
  EXPECT_THAT(report.losses, Contains(HasSubstr("depth")));
  const fs::path model = dir.path() / "colmap/sparse/0";
  const auto cameras = Rows(model / "cameras.txt");
  ASSERT_EQ(cameras.size(), 1U);
  EXPECT_EQ(cameras[0],
            (std::vector<std::string>{"1", "PINHOLE", "32", "24", "30.3", "30.3", "16", "11.75"}));
  const dataset::Capture capture = layouts::Open(dir.path() / "tum");
  const auto images = Rows(model / "images.txt");
  ASSERT_EQ(images.size(), std::size_t{kNumFrames});
  for (int i = 0; i < kNumFrames; ++i) {
    const std::vector<std::string>& row = images[static_cast<std::size_t>(i)];
    ASSERT_EQ(row.size(), 10U);
    const auto number = [&](std::size_t k) { return std::stod(row[k]); };
    const Pose3 camera_from_world{
        Eigen::Quaterniond(number(1), number(2), number(3), number(4)).normalized(),
        {number(5), number(6), number(7)}};
    EXPECT_THAT(camera_from_world.Inverse(),
                PoseNear(*capture.frames->capture_world_from_camera(FrameIdx{i}), 1e-9, 1e-6));
    EXPECT_EQ(ReadText(dir.path() / "colmap/images" / row[9]),
              ReadText(dir.path() / fmt::format("tum/rgb/{}.jpg", i)));
  }
  // Each point lies on what some frame measured.
  const auto points = Rows(model / "points3D.txt");
  EXPECT_GT(points.size(), 50U);
  for (const std::vector<std::string>& row : points) {
    const Eigen::Vector3d p(std::stod(row[1]), std::stod(row[2]), std::stod(row[3]));
    double nearest_m = 1e9;
    for (int i = 0; i < kNumFrames; ++i) {
      const Frame frame = *capture.frames->ReadDepth(FrameIdx{i});
      const Eigen::Vector3d p_camera =
          capture.frames->capture_world_from_camera(FrameIdx{i})->Inverse() * p;
      const auto pixel = capture.frames->camera().Project(p_camera);
      if (!pixel) continue;
      const auto u = static_cast<int>(std::lround(pixel->x()));
      const auto v = static_cast<int>(std::lround(pixel->y()));
      if (!frame.depth_m.Contains(u, v)) continue;
      nearest_m =
          std::min(nearest_m, std::abs(static_cast<double>(frame.depth_m(u, v)) - p_camera.z()));
    }
    EXPECT_LT(nearest_m, 0.001);
  }
}

TEST(Convert, TrainingNeedsPosesWhichARunGives) {
  const TempDir dir;
  WriteTum(dir.path() / "tum");
  for (const char* format : {"nerfstudio", "colmap"}) {
    const ConversionReport report = Convert(dir.path() / "tum", dir.path() / format, format);
    EXPECT_EQ(report.num_frames, kNumFrames - 1);
    EXPECT_THAT(report.losses, Contains(HasSubstr("1 frames without a pose were left out")));
  }
  fs::remove(dir.path() / "tum/groundtruth.txt");
  dataset::Capture capture = layouts::Open(dir.path() / "tum");
  const Result<ConversionReport> refused =
      ConvertCapture(capture, dir.path() / "none", *FindOutputFormat("colmap"), 0, {});
  ASSERT_FALSE(refused.ok());
  EXPECT_THAT(refused.error().message, HasSubstr("--trajectory"));
  EXPECT_FALSE(fs::exists(dir.path() / "none"));
  // The path of a run, as it lies there.
  std::string path;
  for (int i = 0; i < kNumFrames; ++i)
    path += fmt::format("{:.9f} {} 0 0 0 0 0 1\n", capture.frames->time_s(FrameIdx{i}), i);
  WriteText(dir.path() / "run/track/trajectory.tum", path);
  ASSERT_TRUE(TakePosesOf(dir.path() / "run", capture).ok());
  const Result<ConversionReport> taken =
      ConvertCapture(capture, dir.path() / "ns", *FindOutputFormat("nerfstudio"), 0, {});
  ASSERT_TRUE(taken.ok()) << taken.error().message;
  EXPECT_THAT(*layouts::Open(dir.path() / "ns").frames->capture_world_from_camera(FrameIdx{3}),
              PoseNear(Pose3{Eigen::Quaterniond::Identity(), {3, 0, 0}}, 1e-9, 1e-6));
  EXPECT_FALSE(TakePosesOf(dir.path() / "nowhere", capture).ok());
  WriteText(dir.path() / "other.tum", "5 0 0 0 0 0 0 1\n");
  EXPECT_THAT(TakePosesOf(dir.path() / "other.tum", capture).error().message,
              HasSubstr("no pose at the time"));
}

// A .sens may hold moments twice; readers of lists drop repeated times.
TEST(Convert, FramesThatRepeatATimeAreAllReadBack) {
  const TempDir dir;
  layouts::foreign::SensOptions options;
  options.num_frames = 24;
  std::string bytes = layouts::foreign::Sens(options);
  std::size_t at = layouts::foreign::SensHeader(options).size() + 8;
  std::uint64_t before[2] = {0, 0};
  for (int i = 0; i < options.num_frames; ++i) {
    std::uint64_t sizes[2];
    std::memcpy(sizes, bytes.data() + at + 80, sizeof sizes);
    if (i == 10) std::memcpy(bytes.data() + at + 64, before, sizeof before);
    std::memcpy(before, bytes.data() + at + 64, sizeof before);
    at += 96 + sizes[0] + sizes[1];
  }
  WriteText(dir.path() / "a.sens", bytes);
  const dataset::Capture capture = layouts::Open(dir.path() / "a.sens");
  ASSERT_TRUE(capture.has_times);
  const ConversionReport report = Convert(dir.path() / "a.sens", dir.path() / "tum", "tum");
  EXPECT_THAT(report.losses, Contains(HasSubstr("repeat the time")));
  const dataset::Capture back = layouts::Open(dir.path() / "tum");
  ASSERT_EQ(back.frames->num_frames(), options.num_frames);
  for (int i = 0; i < options.num_frames; ++i)
    EXPECT_EQ(back.frames->ReadDepth(FrameIdx{i})->depth_m,
              capture.frames->ReadDepth(FrameIdx{i})->depth_m);
}

}  // namespace
}  // namespace deepslam::convert

// Captures that look as if they were read: units, orders, numberings and conventions that people
// get wrong. Each is read as meant, or refused or doubted with what would fit.
#include <gmock/gmock.h>
#include <opencv2/videoio.hpp>

#include <fmt/format.h>

#include "capture_files.h"
#include "deepslam/layouts/open_capture.h"
#include "foreign_captures.h"
#include "layout_writers.h"
#include "opened_capture.h"
#include "support/box_world.h"

namespace deepslam::layouts {
namespace {

namespace fs = std::filesystem;
using testing::AllOf;
using testing::Contains;
using testing::HasSubstr;
using testing::IsEmpty;
using testing::Not;
using testing_support::TempDir;
using testing_support::WriteText;

const std::string kCamera = "{width: 32, height: 24, fx: 30, fy: 30, cx: 15.5, cy: 11.5}";

std::string Refusal(const fs::path& path) {
  const Result<dataset::Capture> capture = OpenCapture(path);
  if (capture.ok()) return "";
  EXPECT_EQ(capture.error().code, ErrorCode::kInvalidInput);
  return capture.error().message;
}

float DepthMean(const dataset::Capture& capture, int i) {
  const Frame frame = *capture.frames->ReadDepth(FrameIdx{i});
  double sum = 0;
  for (const float d : frame.depth_m) sum += static_cast<double>(d);
  return static_cast<float>(sum / static_cast<double>(frame.depth_m.size()));
}

std::string Replaced(std::string text, const std::string& what, const std::string& by) {
  const std::size_t at = text.find(what);
  EXPECT_NE(at, std::string::npos) << what;
  return text.replace(at, what.size(), by);
}

void WriteLayout(const std::string& name, const fs::path& folder) {
  for (const auto& layout : foreign::WrittenLayouts())
    if (layout.name == name) layout.write(folder);
}

// --- units

void WriteRealSenseFolder(const fs::path& folder, const std::string& scale) {
  for (int i = 0; i < 3; ++i) {
    WriteText(folder / fmt::format("color/{:05d}.jpg", i), foreign::ColourFile(i, ".jpg"));
    WriteText(folder / fmt::format("depth/{:05d}.png", i), foreign::DepthFile(i, 4));
  }
  WriteText(folder / "intrinsic.json",
            fmt::format(R"({{"width": 32, "height": 24, "depth_scale": {},
                            "intrinsic_matrix": [30, 0, 0, 0, 30, 0, 15.5, 11.5, 1]}})",
                        scale));
}

TEST(Misread, DepthScaleAmongTheIntrinsicsIsTheUnit) {
  const TempDir dir;
  WriteRealSenseFolder(dir.path(), "3999.999756");
  const dataset::Capture capture = Open(dir.path());
  ASSERT_NE(capture.frames, nullptr);
  EXPECT_NEAR(DepthMean(capture, 0), 1.03, 0.1);
  EXPECT_THAT(capture.warnings, Contains(AllOf(HasSubstr("depth_scale"), HasSubstr("3999.99"))));
  WriteText(dir.path() / "config.json", R"({"depth_scale": 4000})");
  EXPECT_NEAR(DepthMean(Open(dir.path()), 0), 1.03, 0.1) << "the same but for rounding";
  WriteText(dir.path() / "config.json", R"({"depth_scale": 1000})");
  EXPECT_THAT(Refusal(dir.path()),
              AllOf(HasSubstr("depth_scale"), HasSubstr("1000"), HasSubstr("3999")));
  fs::remove(dir.path() / "config.json");
  for (const char* bad : {"0", "-1", "1e12", "\"4000\"", "null"}) {
    WriteRealSenseFolder(dir.path(), bad);
    EXPECT_THAT(Refusal(dir.path()), AllOf(HasSubstr("intrinsic.json"), HasSubstr("depth_scale")));
  }
}

// The names that scripts give it, wherever it stands; less than 1 is what one unit has in metres.
TEST(Misread, DepthScaleHasSeveralNames) {
  for (const char* field : {R"("depthScale": 4000)",
                            R"("Depth_Scale": 4000.0)",
                            R"("depth-units": 4000)",
                            R"("depth_map_factor": 4000)",
                            R"("depth_scale": 0.00025)",
                            R"("camera": {"depth_scale": 4000, "w": 32})",
                            R"("sensors": {"depth": {"depthUnits": 0.00025}})"}) {
    const TempDir dir;
    WriteRealSenseFolder(dir.path(), "4000");
    WriteText(dir.path() / "intrinsic.json",
              fmt::format(R"({{"width": 32, "height": 24, {},
                              "intrinsic_matrix": [30, 0, 0, 0, 30, 0, 15.5, 11.5, 1]}})",
                          field));
    const dataset::Capture capture = Open(dir.path());
    ASSERT_NE(capture.frames, nullptr) << field;
    EXPECT_NEAR(DepthMean(capture, 0), 1.03, 0.1) << field;
  }
  const TempDir dir;
  WriteRealSenseFolder(dir.path(), "4000");
  WriteText(dir.path() / "config.json", R"({"depth_scale": 4000, "camera": {"depthScale": 1000}})");
  EXPECT_THAT(Refusal(dir.path()),
              AllOf(HasSubstr("config.json"), HasSubstr("depthScale"), HasSubstr("4000")));
}

// --- conventions of poses

const PinholeCamera kPosed{96, 72, 80, 80, 47.5, 35.5};

Pose3 OnTheWay(int i) {
  return testing_support::LookAt({-1.2 + 0.12 * i, -2.4 + 0.03 * i, 1.3 + 0.02 * i},
                                 {-0.3 + 0.05 * i, 0.1, 0.5 + 0.03 * i});
}

// A walk past boxes; `written` is how its poses stand in groundtruth.txt.
void WriteWalk(const fs::path& folder, const std::function<std::string(const Pose3&)>& written) {
  std::vector<testing_support::Cuboid> world = testing_support::TableAt(0, 0, 0);
  world.push_back({-1, {-3, 1.6, 0}, {3, 1.7, 2.6}});
  world.push_back({-1, {-1.8, -0.2, 0}, {-1.2, 0.5, 0.9}});
  std::string rgb, depth, poses;
  for (int i = 0; i < 10; ++i) {
    const auto view = testing_support::RenderBoxes(world, kPosed, OnTheWay(i));
    RawDepthImage raw(kPosed.width, kPosed.height);
    std::transform(view.frame.depth_m.begin(), view.frame.depth_m.end(), raw.begin(), [](float m) {
      return static_cast<std::uint16_t>(1000 * m + 0.5F);
    });
    fs::create_directories(folder / "rgb");
    fs::create_directories(folder / "depth");
    ASSERT_TRUE(
        dataset::WriteColourFile(folder / fmt::format("rgb/{}.png", i), view.frame.colour).ok());
    ASSERT_TRUE(dataset::WriteDepthFile(folder / fmt::format("depth/{}.png", i), raw).ok());
    rgb += fmt::format("{:.2f} rgb/{}.png\n", 0.1 * i, i);
    depth += fmt::format("{:.2f} depth/{}.png\n", 0.1 * i, i);
    poses += fmt::format("{:.2f} {}\n", 0.1 * i, written(OnTheWay(i)));
  }
  WriteText(folder / "rgb.txt", rgb);
  WriteText(folder / "depth.txt", depth);
  WriteText(folder / "groundtruth.txt", poses);
  WriteText(folder / "capture.yaml",
            "camera: {width: 96, height: 72, fx: 80, fy: 80, cx: 47.5, cy: "
            "35.5}\ndepth_units_per_m: 1000\n");
}

std::string AsTum(const Pose3& p) {
  const Eigen::Vector3d& t = p.translation_m;
  const Eigen::Quaterniond& q = p.rotation;
  return fmt::format("{} {} {} {} {} {} {}", t.x(), t.y(), t.z(), q.x(), q.y(), q.z(), q.w());
}

TEST(Misread, PosesThatContradictDepthAreToldWithTheReadingThatFits) {
  const std::vector<std::pair<std::string, std::function<std::string(const Pose3&)>>> ways = {
      {"y up, z back",
       [](const Pose3& p) {
         return AsTum({p.rotation * Eigen::Quaterniond(0, 1, 0, 0), p.translation_m});
       }},
      {"qw qx qy qz",
       [](const Pose3& p) {
         const Eigen::Vector3d& t = p.translation_m;
         const Eigen::Quaterniond& q = p.rotation;
         return fmt::format(
             "{} {} {} {} {} {} {}", t.x(), t.y(), t.z(), q.w(), q.x(), q.y(), q.z());
       }},
      {"camera from world", [](const Pose3& p) { return AsTum(p.Inverse()); }},
      {"millimetres", [](const Pose3& p) {
         return AsTum({p.rotation, 1000 * p.translation_m});
       }}};
  for (const auto& [words, written] : ways) {
    const TempDir dir;
    WriteWalk(dir.path(), written);
    const dataset::Capture capture = Open(dir.path());
    EXPECT_THAT(capture.poses_fault, AllOf(HasSubstr("groundtruth.txt"), HasSubstr(words)));
    EXPECT_THAT(capture.warnings, Contains(HasSubstr(words)));
  }
  const TempDir dir;
  WriteWalk(dir.path(), AsTum);
  EXPECT_EQ(Open(dir.path()).poses_fault, "");
}

// --- pictures turned and numbered otherwise

void WriteStray(const fs::path& folder, bool turned, int first_colour, int first_row) {
  std::string odometry = "timestamp, frame, x, y, z, qx, qy, qz, qw\n";
  for (int i = 0; i < 4; ++i) {
    cv::Mat colour(turned ? 64 : 48, turned ? 48 : 64, CV_8UC3, cv::Scalar(10, 20 + 40 * i, 30));
    WriteText(folder / fmt::format("rgb/{:06d}.png", i + first_colour),
              foreign::Encoded(".png", colour));
    WriteText(folder / fmt::format("depth/{:06d}.png", i), foreign::DepthFile(i));
    odometry += fmt::format("{}, {:06d}, 0, 0, {}, 0, 0, 0, 1\n", 5 + 0.1 * i, i + first_row, i);
  }
  WriteText(folder / "odometry.csv", odometry);
  WriteText(folder / "camera_matrix.csv",
            turned ? "60,0,23.5\n0,60,31.5\n0,0,1\n" : "60,0,31.5\n0,60,23.5\n0,0,1\n");
}

TEST(Misread, ColourOnItsSideIsRefused) {
  const TempDir dir;
  WriteStray(dir.path(), true, 0, 0);
  EXPECT_THAT(Refusal(dir.path()),
              AllOf(HasSubstr("48 x 64"), HasSubstr("32 x 24"), HasSubstr("-noautorotate")));
}

TEST(Misread, ImagesNumberedFrom1ArePairedInOrder) {
  for (const auto& [first_colour, first_row] : {std::pair(1, 0), {0, 3}, {7, 3}}) {
    const TempDir dir;
    WriteStray(dir.path(), false, first_colour, first_row);
    const dataset::Capture capture = Open(dir.path());
    ASSERT_NE(capture.frames, nullptr);
    ASSERT_EQ(capture.frames->num_frames(), 4);
    EXPECT_THAT(capture.warnings, Contains(AllOf(HasSubstr("numbered"), HasSubstr("in order"))));
    for (int i = 0; i < 4; ++i) {
      const Frame frame = *capture.frames->Read(FrameIdx{i});
      EXPECT_EQ(frame.colour(3, 3).g, 20 + 40 * i);
      EXPECT_NEAR(frame.depth_m(8, 8), 0.001F * foreign::DepthMm(i, 4, 4), 0.01F);
      EXPECT_EQ(capture.frames->capture_world_from_camera(FrameIdx{i})->translation_m.z(), i);
    }
  }
}

TEST(Misread, OneMissingImageIsNoOtherNumbering) {
  const TempDir dir;
  WriteStray(dir.path(), false, 0, 0);
  fs::remove(dir.path() / "rgb/000000.png");
  const dataset::Capture capture = Open(dir.path());
  ASSERT_EQ(capture.frames->num_frames(), 3);
  EXPECT_EQ(capture.frames->Read(FrameIdx{0})->colour(3, 3).g, 60) << "frame 1's own";
  EXPECT_THAT(capture.warnings, Contains(HasSubstr("000000")));
}

TEST(Misread, TwoFoldersNumberedApartArePairedInOrder) {
  const TempDir dir;
  WriteRealSenseFolder(dir.path(), "4000");
  fs::rename(dir.path() / "color", dir.path() / "old");
  for (int i = 0; i < 3; ++i) {
    fs::create_directories(dir.path() / "color");
    fs::rename(dir.path() / fmt::format("old/{:05d}.jpg", i),
               dir.path() / fmt::format("color/{:05d}.jpg", i + 1));
  }
  const dataset::Capture capture = Open(dir.path());
  ASSERT_EQ(capture.frames->num_frames(), 3);
  EXPECT_THAT(capture.warnings, Contains(AllOf(HasSubstr("numbered"), HasSubstr("in order"))));
  EXPECT_NEAR(capture.frames->Read(FrameIdx{2})->colour(9, 9).b, 198, 12);
}

TEST(Misread, VideoWithFewerFramesThanRowsIsDoubted) {
  const TempDir dir;
  WriteStray(dir.path(), false, 0, 0);
  fs::remove_all(dir.path() / "rgb");
  cv::VideoWriter video((dir.path() / "rgb.mp4").string(),
                        cv::VideoWriter::fourcc('m', 'p', '4', 'v'),
                        30,
                        cv::Size(64, 48));
  ASSERT_TRUE(video.isOpened());
  for (int i = 0; i < 3; ++i) video.write(cv::Mat(48, 64, CV_8UC3, cv::Scalar(40, 40, 120)));
  video.release();
  const dataset::Capture capture = Open(dir.path());
  ASSERT_NE(capture.frames, nullptr);
  EXPECT_EQ(capture.frames->num_frames(), 3);
  EXPECT_THAT(capture.doubts, Contains(AllOf(HasSubstr("rgb.mp4"), HasSubstr("3 frames"))));
}

// --- shapes

// An app that keeps every second frame numbers them by the camera's.
TEST(Misread, AVideoOfAsManyFramesAsRowsIsPairedInOrder) {
  const TempDir dir;
  WriteStray(dir.path(), false, 0, 0);
  fs::remove_all(dir.path() / "rgb");
  fs::remove_all(dir.path() / "confidence");
  std::string rows = "timestamp, frame, x, y, z, qx, qy, qz, qw\n";
  fs::remove_all(dir.path() / "depth");
  for (int i = 0; i < 4; ++i) {
    rows += fmt::format("{}, {}, 0, 0, 0, 0, 0, 0, 1\n", 0.1 * i, 2 * i);
    WriteText(dir.path() / fmt::format("depth/{:06d}.png", 2 * i), foreign::DepthFile(i));
  }
  WriteText(dir.path() / "odometry.csv", rows);
  cv::VideoWriter video((dir.path() / "rgb.mp4").string(),
                        cv::VideoWriter::fourcc('m', 'p', '4', 'v'),
                        30,
                        cv::Size(64, 48));
  ASSERT_TRUE(video.isOpened());
  for (int i = 0; i < 4; ++i) video.write(cv::Mat(48, 64, CV_8UC3, cv::Scalar(0, 0, 60 * i)));
  video.release();
  const dataset::Capture capture = Open(dir.path());
  ASSERT_NE(capture.frames, nullptr);
  ASSERT_EQ(capture.frames->num_frames(), 4);
  for (int i = 0; i < 4; ++i)
    EXPECT_NEAR(capture.frames->Read(FrameIdx{i})->colour(9, 9).r, 60 * i, 20) << i;
}

TEST(Misread, DepthOfAnotherShapeHasToHaveACameraOfItsOwn) {
  const TempDir dir;
  WriteCapture(dir.path(), 3);
  for (int i = 0; i < 3; ++i) {
    ASSERT_TRUE(dataset::WriteDepthFile(dir.path() / fmt::format("depth/{}.png", i),
                                        RawDepthImage(20, 18, 900))
                    .ok());
  }
  EXPECT_THAT(Refusal(dir.path()),
              AllOf(HasSubstr("20 x 18"),
                    HasSubstr("32 x 24"),
                    HasSubstr("depth_camera"),
                    HasSubstr("colour_from_depth"),
                    HasSubstr("k4a_transformation")));
  WriteText(dir.path() / "capture.yaml",
            std::string(kTestSettings) +
                "depth_camera: {width: 20, height: 18, fx: 19, fy: 19, cx: 9.5, cy: 8.5}\n"
                "colour_from_depth: {translation_m: [-0.03, 0, 0], rotation_xyzw: [0, 0, 0, 1]}\n");
  EXPECT_GT(Open(dir.path()).frames->ReadDepth(FrameIdx{0})->depth_m(14, 11), 0.8F);
}

// --- times

TEST(Misread, TimesOfAFewFramesAreNone) {
  const TempDir dir;
  const fs::path file = dir.path() / "scene.sens";
  foreign::SensOptions options;
  options.num_frames = 6;
  std::string bytes = foreign::Sens(options);
  // All but two frames' times are 0: behind each frame's matrix (64 bytes).
  std::size_t at = foreign::SensHeader(options).size() + 8;
  for (int i = 0; i < 6; ++i) {
    std::uint64_t sizes[2];
    std::memcpy(sizes, bytes.data() + at + 80, 16);
    const std::uint64_t time = i == 2 ? 813000000000 : i == 4 ? 5 : 0;
    for (const std::size_t field : {64U, 72U}) std::memcpy(bytes.data() + at + field, &time, 8);
    at += 96 + sizes[0] + sizes[1];
  }
  WriteText(file, bytes);
  const dataset::Capture capture = Open(file);
  ASSERT_NE(capture.frames, nullptr);
  EXPECT_FALSE(capture.has_times);
  EXPECT_THAT(capture.doubts, IsEmpty());
  for (int i = 0; i < 6; ++i) EXPECT_NEAR(capture.frames->time_s(FrameIdx{i}), i / 30.0, 1e-6);
}

TEST(Misread, TimesInOtherUnitsAreNamed) {
  struct Unit {
    double per_s;
    double epoch;
    std::string words;
  };
  for (const Unit& unit : {Unit{1e3, 0, "milliseconds"},
                           {1e6, 0, "microseconds"},
                           {1e9, 0, "nanoseconds"},
                           {1e3, 1.7e9, "milliseconds"},
                           {1e6, 1.7e9, "microseconds"},
                           {1e9, 1.7e9, "nanoseconds"}}) {
    const TempDir dir;
    WriteCapture(dir.path(), 6);
    std::string rgb, depth;
    for (int i = 0; i < 6; ++i) {
      // Depth comes 6 ms behind colour.
      rgb += fmt::format("{:.0f} rgb/{}.png\n", unit.per_s * (unit.epoch + 5 + 0.1 * i), i);
      depth += fmt::format("{:.0f} depth/{}.png\n", unit.per_s * (unit.epoch + 5.006 + 0.1 * i), i);
    }
    WriteText(dir.path() / "rgb.txt", rgb);
    WriteText(dir.path() / "depth.txt", depth);
    EXPECT_THAT(Refusal(dir.path()),
                AllOf(HasSubstr(unit.words), HasSubstr("seconds"), Not(HasSubstr("clock"))))
        << rgb;
  }
}

TEST(Misread, PosesOfAnotherClockAreToldAndNotTaken) {
  for (const auto& [per_s, start_s, words] : {std::tuple(1e3, 0.0, "milliseconds"),
                                              {1e9, 0.0, "nanoseconds"},
                                              {1.0, 1.7e9, "no pose lies within"}}) {
    const TempDir dir;
    WriteCapture(dir.path(), 6);
    std::string poses;
    for (int i = 0; i < 6; ++i)
      poses += fmt::format("{:.3f} 0 0 0 0 0 0 1\n", per_s * (start_s + 0.1 * i));
    WriteText(dir.path() / "groundtruth.txt", poses);
    const dataset::Capture capture = Open(dir.path());
    ASSERT_NE(capture.frames, nullptr);
    EXPECT_FALSE(capture.has_poses);
    EXPECT_THAT(capture.warnings, Contains(AllOf(HasSubstr("groundtruth.txt"), HasSubstr(words))));
  }
}

TEST(Misread, SecondsSinceTheEpochAreTimes) {
  const TempDir dir;
  WriteCapture(dir.path(), 3);
  std::string rgb, depth;
  for (int i = 0; i < 3; ++i) {
    rgb += fmt::format("{:.6f} rgb/{}.png\n", 1.7e9 + 0.1 * i, i);
    depth += fmt::format("{:.6f} depth/{}.png\n", 1.7e9 + 0.006 + 0.1 * i, i);
  }
  WriteText(dir.path() / "rgb.txt", rgb);
  WriteText(dir.path() / "depth.txt", depth);
  EXPECT_THAT(Open(dir.path()).warnings, IsEmpty());
}

// --- texts as recorders and editors leave them

TEST(Misread, AListThatEndsWithinALineLosesThatLine) {
  const TempDir dir;
  WriteCapture(dir.path(), 4);
  WriteText(dir.path() / "rgb.txt", "0.0 rgb/0.png\n0.1 rgb/1.png\n0.2 rgb/2.png\n0.30");
  const dataset::Capture capture = Open(dir.path());
  ASSERT_NE(capture.frames, nullptr);
  EXPECT_EQ(capture.frames->num_frames(), 3);
  EXPECT_THAT(capture.warnings, Contains(AllOf(HasSubstr("rgb.txt:4"), HasSubstr("left out"))));
  WriteText(dir.path() / "rgb.txt", "0.0 rgb/0.png\n0.10\n0.2 rgb/2.png\n");
  EXPECT_THAT(Refusal(dir.path()), HasSubstr("rgb.txt:2"));
}

TEST(Misread, AnUnfinishedLineOfPosesLosesThatPoseAlone) {
  const TempDir dir;
  WriteLayout("folders", dir.path());
  const fs::path file = dir.path() / "pose.txt";
  const std::string whole = testing_support::ReadText(file);
  WriteText(file, whole.substr(0, whole.size() - 9));
  const dataset::Capture capture = Open(dir.path());
  ASSERT_NE(capture.frames, nullptr);
  EXPECT_TRUE(capture.frames->capture_world_from_camera(FrameIdx{2}).has_value());
  EXPECT_FALSE(capture.frames->capture_world_from_camera(FrameIdx{3}).has_value());
}

TEST(Misread, ListsOfOtherEditorsAreRead) {
  const auto wide = [](const std::string& text, int zeros, const std::string& mark) {
    std::string bytes = mark;
    for (const char c : text) bytes += c + std::string(static_cast<std::size_t>(zeros), '\0');
    return bytes;
  };
  const std::string list = "0.0 rgb/0.png\n0.1 rgb/1.png\n";
  const std::string mark32 = std::string("\xFF\xFE\0\0", 4);
  for (const std::string& text : {wide(list, 1, ""),
                                  wide(list, 3, mark32),
                                  std::string("0.0 rgb/0.png\r0.1 rgb/1.png\r"),
                                  std::string("# a\r0.0\trgb/0.png\r0.1,rgb/1.png")}) {
    const TempDir dir;
    WriteCapture(dir.path(), 2);
    WriteText(dir.path() / "rgb.txt", text);
    const dataset::Capture capture = Open(dir.path());
    ASSERT_NE(capture.frames, nullptr);
    EXPECT_EQ(capture.frames->num_frames(), 2);
  }
}

TEST(Misread, ListsInUtf16AreRead) {
  const auto wide = [](const std::string& text, bool high_first) {
    std::string bytes = high_first ? "\xFE\xFF" : "\xFF\xFE";
    for (const char c : text) {
      if (high_first) bytes += std::string(1, '\0') + c;
      if (!high_first) bytes += std::string(1, c) + '\0';
    }
    return bytes;
  };
  for (const bool high_first : {false, true}) {
    const TempDir dir;
    WriteCapture(dir.path(), 2);
    WriteText(dir.path() / "rgb.txt", wide("0.0 rgb/0.png\r\n0.1 rgb/1.png\r\n", high_first));
    WriteText(dir.path() / "capture.yaml", wide(kTestSettings, high_first));
    EXPECT_EQ(Open(dir.path()).frames->num_frames(), 2);
  }
}

TEST(Misread, AssociationsHaveSeveralNames) {
  for (const char* name :
       {"associations.txt", "associated.txt", "associate.txt", "association.txt", "assoc.txt"}) {
    const TempDir dir;
    WriteCapture(dir.path(), 2);
    fs::remove(dir.path() / "rgb.txt");
    fs::remove(dir.path() / "depth.txt");
    WriteText(dir.path() / name, "0.0 rgb/0.png 0.0 depth/0.png\n0.1 rgb/1.png 0.1 depth/1.png\n");
    EXPECT_EQ(Open(dir.path()).frames->num_frames(), 2) << name;
  }
}

TEST(Misread, NinthColumnOfRtabMapsPosesIsItsNode) {
  const TempDir dir;
  WriteCapture(dir.path(), 2);
  WriteText(dir.path() / "groundtruth.txt",
            "#timestamp x y z qx qy qz qw id\n0.0 1 2 3 0 0 0 1 1\n0.1 4 5 6 0 0 0 1 2\n");
  const dataset::Capture capture = Open(dir.path());
  EXPECT_EQ(capture.frames->capture_world_from_camera(FrameIdx{1})->translation_m,
            Eigen::Vector3d(4, 5, 6));
}

TEST(Misread, Record3dsMatrixByRowsIsReadAsMeant) {
  for (const char* k : {"[30.3, 0, 15.5, 0, 30.3, 11.25, 0, 0, 1]",
                        "[[30.3, 0, 15.5], [0, 30.3, 11.25], [0, 0, 1]]",
                        "[[30.3, 0, 0], [0, 30.3, 0], [15.5, 11.25, 1]]"}) {
    const TempDir dir;
    WriteLayout("record3d", dir.path());
    const fs::path file = dir.path() / "metadata.json";
    WriteText(
        file,
        Replaced(testing_support::ReadText(file), "[30.3, 0, 0, 0, 30.3, 0, 15.5, 11.25, 1]", k));
    const dataset::Capture capture = Open(dir.path());
    ASSERT_NE(capture.frames, nullptr) << k;
    EXPECT_EQ(capture.frames->camera(), (PinholeCamera{32, 24, 30.3, 30.3, 15.5, 11.25})) << k;
  }
}

TEST(Misread, Record3dsTimesThatDoNotAscendAreNone) {
  for (const char* times : {"[0, 0.5, 0.5, 0.7]", "[3, 2, 1, 0]", "[0, 0.1]", "[0, null, 1, 2]"}) {
    const TempDir dir;
    WriteLayout("record3d", dir.path());
    const fs::path file = dir.path() / "metadata.json";
    WriteText(file,
              Replaced(testing_support::ReadText(file),
                       "\"fps\"",
                       fmt::format("\"frameTimestamps\": {}, \"fps\"", times)));
    const dataset::Capture capture = Open(dir.path());
    ASSERT_NE(capture.frames, nullptr) << times;
    for (int i = 0; i < foreign::kWrittenFrames; ++i)
      EXPECT_NEAR(capture.frames->time_s(FrameIdx{i}), 0.1 * i, 1e-6) << times;
  }
}

TEST(Misread, NamesMayEndInCapitals) {
  const TempDir dir;
  for (int i = 0; i < 3; ++i) {
    WriteText(dir.path() / fmt::format("color/{}.JPG", i), foreign::ColourFile(i, ".jpg"));
    WriteText(dir.path() / fmt::format("depth/{}.PNG", i), foreign::DepthFile(i));
  }
  WriteText(dir.path() / "capture.yaml", "camera: " + kCamera + "\ndepth_units_per_m: 1000\n");
  EXPECT_EQ(Open(dir.path()).frames->num_frames(), 3);
  WriteText(dir.path() / "SCENE/ROOM.SENS", foreign::Sens({}));
  EXPECT_EQ(Open(dir.path() / "SCENE").format, "scannet");
  EXPECT_EQ(Open(dir.path() / "SCENE/ROOM.SENS").format, "scannet");
}

// --- what lies there

TEST(Misread, NoCameraIsGuessedBesideAFileThatTells) {
  for (const char* name : {"calib.yaml", "camera_info.json", "intrinsics.xml"}) {
    const TempDir dir;
    for (int i = 0; i < 3; ++i) {
      WriteText(dir.path() / fmt::format("color/{}.jpg", i),
                foreign::Encoded(".jpg", cv::Mat(480, 640, CV_8UC3, cv::Scalar(9, 9, 9))));
      WriteText(dir.path() / fmt::format("depth/{}.png", i),
                foreign::Encoded(".png", cv::Mat(480, 640, CV_16UC1, cv::Scalar(900))));
    }
    WriteText(dir.path() / "trajectory.log", "");
    WriteText(dir.path() / name, "fx: 577.87");
    EXPECT_THAT(Refusal(dir.path()), HasSubstr(name));
    fs::remove(dir.path() / name);
    EXPECT_THAT(Open(dir.path()).warnings, Contains(HasSubstr("PrimeSense")));
  }
}

TEST(Misread, FoldersWithoutACameraAskForIt) {
  const TempDir dir;
  for (int i = 0; i < 3; ++i) {
    WriteText(dir.path() / fmt::format("rgb/{}.jpg", i), foreign::ColourFile(i, ".jpg"));
    WriteText(dir.path() / fmt::format("depth/{}.png", i), foreign::DepthFile(i));
  }
  EXPECT_THAT(
      Refusal(dir.path()),
      AllOf(HasSubstr("capture.yaml"), HasSubstr("camera"), HasSubstr("--write-capture-yaml")));
  WriteText(dir.path() / "capture.yaml", "camera: " + kCamera + "\n");
  const dataset::Capture capture = Open(dir.path());
  EXPECT_THAT(capture.warnings, Contains(AllOf(HasSubstr("1000"), HasSubstr("depth_units_per_m"))));
  WriteText(dir.path() / "capture.yaml",
            "camera: " + kCamera + "\ndepth_units_per_m: 1000\nassumed: [camera]\n");
  EXPECT_THAT(Open(dir.path()).doubts,
              Contains(AllOf(HasSubstr("'camera'"), HasSubstr("assumed"))));
}

TEST(Misread, DepthAsNumbersIsReadInEveryFormat) {
  const std::vector<std::pair<std::string, std::string (*)(int)>> kinds = {
      {"npy", foreign::NpyDepth},
      {"exr", foreign::ExrDepth},
      {"tiff", foreign::TiffDepth},
      {"pgm", foreign::PgmDepth}};
  for (const auto& [end, write] : kinds) {
    const TempDir dir;
    for (int i = 0; i < 3; ++i) {
      WriteText(dir.path() / fmt::format("color/{:06d}.jpg", i), foreign::ColourFile(i, ".jpg"));
      WriteText(dir.path() / fmt::format("depth/{:06d}.{}", i, end), write(i));
    }
    WriteText(dir.path() / "capture.yaml", "camera: " + kCamera + "\n");
    const dataset::Capture capture = Open(dir.path());
    ASSERT_NE(capture.frames, nullptr) << end;
    EXPECT_NEAR(capture.frames->ReadDepth(FrameIdx{2})->depth_m(9, 9),
                0.001F * foreign::DepthMm(2, 9, 9),
                0.0002F)
        << end;
  }
}

TEST(Misread, FilesThatAreNoImagesAreNamed) {
  const TempDir dir;
  for (int i = 0; i < 2; ++i) {
    WriteText(dir.path() / fmt::format("color/{}.jpg", i), foreign::ColourFile(i, ".jpg"));
    WriteText(dir.path() / fmt::format("depth/{}.npz", i), "PK");
  }
  WriteText(dir.path() / "capture.yaml", "camera: " + kCamera + "\ndepth_units_per_m: 1000\n");
  EXPECT_THAT(Refusal(dir.path()), AllOf(HasSubstr("2 files .npz"), HasSubstr("PNG")));
}

TEST(Misread, ArchivesInAFolderAreNamed) {
  const TempDir dir;
  WriteText(dir.path() / "download/sequence", "\x1f\x8b\x08 and so on");
  EXPECT_THAT(Refusal(dir.path() / "download"),
              AllOf(HasSubstr("sequence"), HasSubstr("gzip"), HasSubstr("unpack")));
  EXPECT_THAT(Refusal(dir.path() / "download/sequence"), HasSubstr("unpack"));
}

TEST(Misread, ACaptureOneFolderDeeperIsNamed) {
  for (const auto& layout : foreign::WrittenLayouts()) {
    const TempDir dir;
    layout.write(dir.path() / "download/my capture");
    fs::create_directories(dir.path() / "download/__MACOSX/my capture");
    const std::string refusal = Refusal(dir.path() / "download");
    EXPECT_THAT(refusal,
                AllOf(HasSubstr("download/my capture is one"), HasSubstr("(" + layout.name + ")")));
  }
  const TempDir deep;
  WriteCapture(deep.path() / "home/2026/11/room", 2);
  EXPECT_THAT(Refusal(deep.path()), HasSubstr("home/2026/11/room is one (tum)"));
}

}  // namespace
}  // namespace deepslam::layouts

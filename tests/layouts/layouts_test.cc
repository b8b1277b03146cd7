// Every layout against a capture written by foreign_captures.h, which follows the layout's own
// description, and the traps each of them has.
#include <gmock/gmock.h>
#include <opencv2/videoio.hpp>

#include <fmt/format.h>

#include "deepslam/layouts/open_capture.h"
#include "foreign_captures.h"
#include "opened_capture.h"
#include "support/pose_matchers.h"

namespace deepslam::layouts {
namespace {

namespace fs = std::filesystem;
using testing::AllOf;
using testing::Contains;
using testing::HasSubstr;
using testing::Not;
using testing_support::PoseNear;
using testing_support::TempDir;
using testing_support::WriteText;

constexpr int kNumFrames = 4;
const std::string kCamera = "{width: 32, height: 24, fx: 30.3, fy: 30.3, cx: 15.5, cy: 11.25}";

std::string Refusal(const fs::path& path) {
  const Result<dataset::Capture> capture = OpenCapture(path);
  if (capture.ok()) return "";
  EXPECT_EQ(capture.error().code, ErrorCode::kInvalidInput);
  return capture.error().message;
}

Pose3 TruePose(int i) {
  const auto m = foreign::Matrix(i);
  Eigen::Matrix4d matrix;
  for (int k = 0; k < 16; ++k) matrix(k / 4, k % 4) = m[static_cast<std::size_t>(k)];
  return Pose3::FromMatrix(matrix);
}

// All pixels and poses of all frames; `lossy` colour is compared within what JPEG and video do.
void ExpectTruth(const dataset::Capture& capture,
                 int num_frames,
                 double time_step_s,
                 bool lossy = false) {
  ASSERT_NE(capture.frames, nullptr);
  const FrameSource& frames = *capture.frames;
  ASSERT_EQ(frames.num_frames(), num_frames);
  EXPECT_EQ(frames.camera(), (PinholeCamera{32, 24, 30.3, 30.3, 15.5, 11.25}));
  for (int i = 0; i < num_frames; ++i) {
    const Result<Frame> frame = frames.Read(FrameIdx{i});
    ASSERT_TRUE(frame.ok()) << frame.error().message;
    EXPECT_NEAR(frame->time_s - frames.time_s(FrameIdx{0}), i * time_step_s, 1e-6);
    for (int v = 0; v < foreign::kHeight; ++v) {
      for (int u = 0; u < foreign::kWidth; ++u) {
        ASSERT_EQ(frame->depth_m(u, v),
                  static_cast<float>(static_cast<double>(foreign::DepthMm(i, u, v)) / 1000.0))
            << "frame " << i << " at " << u << ", " << v;
        const auto rgb = foreign::Rgb(i, u, v);
        const Rgb8 read = frame->colour(u, v);
        const int tolerance = lossy ? 12 : 0;
        ASSERT_NEAR(read.r, rgb[0], tolerance) << "frame " << i << " at " << u << ", " << v;
        ASSERT_NEAR(read.g, rgb[1], tolerance);
        ASSERT_NEAR(read.b, rgb[2], tolerance);
      }
    }
    const std::optional<Pose3> pose = frames.capture_world_from_camera(FrameIdx{i});
    ASSERT_TRUE(pose.has_value()) << "frame " << i;
    EXPECT_THAT(*pose, PoseNear(TruePose(i), 2e-6, 2e-4));
  }
}

// --- ETH3D-SLAM

void WriteEth3d(const fs::path& folder) {
  std::string associated;
  std::string poses = "# timestamp tx ty tz qx qy qz qw\n";
  for (int i = 0; i < kNumFrames; ++i) {
    const std::string time = fmt::format("{:.6f}", 100 + 0.25 * i);
    WriteText(folder / ("rgb/" + time + ".png"), foreign::ColourFile(i));
    WriteText(folder / ("depth/" + time + ".png"), foreign::DepthFile(i, 5));
    associated += fmt::format("{0} rgb/{0}.png {0} depth/{0}.png\n", time);
    poses += time + " " + foreign::Tum(i) + "\n";
  }
  WriteText(folder / "associated.txt", associated);
  WriteText(folder / "groundtruth.txt", poses);
  WriteText(folder / "calibration.txt", "30.3 30.3 15.5 11.25\n");
}

TEST(Eth3d, CalibrationAndUnitsAreItsOwn) {
  const TempDir dir;
  WriteEth3d(dir.path());
  const dataset::Capture capture = Open(dir.path());
  EXPECT_EQ(capture.format, "eth3d");
  ExpectTruth(capture, kNumFrames, 0.25);
}

TEST(Eth3d, BadCalibrationNamesTheValue) {
  const TempDir dir;
  WriteEth3d(dir.path());
  WriteText(dir.path() / "calibration.txt", "30.3 30.3 15.5\n");
  EXPECT_THAT(Refusal(dir.path()), AllOf(HasSubstr("calibration.txt"), HasSubstr("3 numbers")));
  WriteText(dir.path() / "calibration.txt", "30.3 -30.3 15.5 11.25\n");
  EXPECT_THAT(Refusal(dir.path()), AllOf(HasSubstr("fy"), HasSubstr("never negative")));
  WriteText(dir.path() / "calibration.txt", "30.3 thirty 15.5 11.25\n");
  EXPECT_THAT(Refusal(dir.path()), AllOf(HasSubstr("calibration.txt:1"), HasSubstr("thirty")));
}

// --- ICL-NUIM

// The camera of the data set has 640 x 480 px; capture.yaml states the small one of the tests.
void WriteIcl(const fs::path& folder, bool swapped = true) {
  std::string associations;
  std::string poses;
  for (int i = 0; i < kNumFrames; ++i) {
    WriteText(folder / fmt::format("rgb/{}.png", i), foreign::ColourFile(i));
    WriteText(folder / fmt::format("depth/{}.png", i), foreign::DepthFile(i, 5));
    associations += swapped ? fmt::format("{0} depth/{0}.png {0} rgb/{0}.png\n", i)
                            : fmt::format("{0} rgb/{0}.png {0} depth/{0}.png\n", i);
    // The renderer's world: y turned round. Rotation about y by a is rotation by -a there... and
    // the mirror of the camera turns it back, so that only y of the position differs; a turn about
    // x shows both (TurnsAboutXToo).
    poses += fmt::format(
        "{} {} -1.25 -2 0 {} 0 {}\n", i, 0.5 * i, std::sin(0.05 * i), std::cos(0.05 * i));
  }
  WriteText(folder / "associations.txt", associations);
  WriteText(folder / "livingRoom1.gt.freiburg", poses);
  WriteText(folder / "capture.yaml", "format: icl-nuim\ncamera: " + kCamera + "\n");
}

TEST(IclNuim, DepthFirstFrameNumbersAndMirroredPoses) {
  for (const bool swapped : {true, false}) {
    const TempDir dir;
    WriteIcl(dir.path(), swapped);
    const dataset::Capture capture = Open(dir.path());
    EXPECT_EQ(capture.format, "icl-nuim");
    ExpectTruth(capture, kNumFrames, 1.0 / 30);
  }
}

TEST(IclNuim, MirroredTrajectoryMovesPointsAsTheImagesDo) {
  const TempDir dir;
  WriteIcl(dir.path());
  // In the renderer's world, y up: the camera turns by 0.3 about x and moves up.
  const Eigen::Quaterniond q = RotationFromVector({0.3, 0.1, -0.2});
  WriteText(dir.path() / "livingRoom1.gt.freiburg",
            fmt::format("1 0 0 0 0 0 0 1\n2 0.1 0.2 0.3 {:.12f} {:.12f} {:.12f} {:.12f}\n",
                        q.x(),
                        q.y(),
                        q.z(),
                        q.w()));
  const dataset::Capture capture = Open(dir.path());
  ASSERT_NE(capture.frames, nullptr);
  EXPECT_FALSE(capture.frames->capture_world_from_camera(FrameIdx{0})) << "no pose of frame 0";
  const Pose3 a = *capture.frames->capture_world_from_camera(FrameIdx{1});
  const Pose3 b = *capture.frames->capture_world_from_camera(FrameIdx{2});
  // A point of the renderer's world in camera 2 by the renderer's own convention: y up, negative
  // fy. The image's row grows downwards; the point in a camera with positive fy has y the other
  // way.
  const Eigen::Vector3d p_renderer(0.4, -0.3, 2.5);
  const Eigen::Vector3d p_camera_renderer =
      q.conjugate() * (p_renderer - Eigen::Vector3d(0.1, 0.2, 0.3));
  const double row = -480.0 * p_camera_renderer.y() / p_camera_renderer.z() + 239.5;
  const Eigen::Vector3d p_camera_1(p_renderer.x(), -p_renderer.y(), p_renderer.z());
  const Eigen::Vector3d p_camera_2 = b.Inverse() * (a * p_camera_1);
  EXPECT_NEAR(480.0 * p_camera_2.y() / p_camera_2.z() + 239.5, row, 1e-6);
  EXPECT_NEAR(p_camera_2.x(), p_camera_renderer.x(), 1e-9);
  EXPECT_NEAR(p_camera_2.z(), p_camera_renderer.z(), 1e-9);
}

TEST(IclNuim, IsRecognisedByItsListsAloneAndHasItsCamera) {
  const TempDir dir;
  WriteIcl(dir.path());
  fs::remove(dir.path() / "capture.yaml");
  fs::remove(dir.path() / "livingRoom1.gt.freiburg");
  cv::Mat colour(480, 640, CV_8UC3, cv::Scalar(1, 2, 3));
  cv::Mat depth(480, 640, CV_16UC1, cv::Scalar(10000));
  for (int i = 0; i < kNumFrames; ++i) {
    WriteText(dir.path() / fmt::format("rgb/{}.png", i), foreign::Encoded(".png", colour));
    WriteText(dir.path() / fmt::format("depth/{}.png", i), foreign::Encoded(".png", depth));
  }
  const dataset::Capture capture = Open(dir.path());
  EXPECT_EQ(capture.format, "icl-nuim");
  ASSERT_NE(capture.frames, nullptr);
  EXPECT_EQ(capture.frames->camera(), (PinholeCamera{640, 480, 481.2, 480.0, 319.5, 239.5}));
  EXPECT_FLOAT_EQ(capture.frames->ReadDepth(FrameIdx{0})->depth_m(3, 3), 2.0f);
  EXPECT_FALSE(capture.has_poses);
}

// --- 7-Scenes

void WriteSevenScenes(const fs::path& folder, const std::string& yaml) {
  for (int i = 0; i < kNumFrames; ++i) {
    const std::string stem = "frame-" + foreign::Digits(i, 6);
    WriteText(folder / (stem + ".color.png"), foreign::ColourFile(i));
    WriteText(folder / (stem + ".depth.png"), foreign::DepthFile(i, 1, 65535));
    WriteText(folder / (stem + ".pose.txt"), foreign::MatrixText(foreign::Matrix(i)));
  }
  if (!yaml.empty()) WriteText(folder / "capture.yaml", yaml);
}

TEST(SevenScenes, MillimetresWith65535ForNothing) {
  const TempDir dir;
  WriteSevenScenes(dir.path(), "camera: " + kCamera + "\n");
  const dataset::Capture capture = Open(dir.path());
  EXPECT_EQ(capture.format, "7-scenes");
  EXPECT_FALSE(capture.has_times);
  ExpectTruth(capture, kNumFrames, 1.0 / 30);
}

TEST(SevenScenes, WithoutCalibrationDepthIsRegisteredByAKinectsUsualValues) {
  const TempDir dir;
  cv::Mat colour(480, 640, CV_8UC3, cv::Scalar(1, 2, 3));
  cv::Mat depth(480, 640, CV_16UC1, cv::Scalar(2000));
  WriteText(dir.path() / "frame-000000.color.png", foreign::Encoded(".png", colour));
  WriteText(dir.path() / "frame-000000.depth.png", foreign::Encoded(".png", depth));
  WriteText(dir.path() / "frame-000000.pose.txt", foreign::MatrixText(foreign::kIdentity));
  const dataset::Capture capture = Open(dir.path());
  ASSERT_NE(capture.frames, nullptr);
  EXPECT_THAT(capture.warnings, Contains(AllOf(HasSubstr("585"), HasSubstr("525"))));
  EXPECT_EQ(capture.frames->camera().fx, 525);
  const Frame frame = *capture.frames->ReadDepth(FrameIdx{0});
  EXPECT_FLOAT_EQ(frame.depth_m(320, 240), 2.0f);
  EXPECT_EQ(frame.depth_m(2, 240), 0) << "colour sees more than depth";
  // Poses are those of the depth camera: colour's is 25 mm to the right.
  EXPECT_NEAR(
      capture.frames->capture_world_from_camera(FrameIdx{0})->translation_m.x(), 0.025, 1e-9);
}

TEST(SevenScenes, LostPosesAreNone) {
  const TempDir dir;
  WriteSevenScenes(dir.path(), "camera: " + kCamera + "\n");
  WriteText(dir.path() / "frame-000001.pose.txt",
            "-inf -inf -inf -inf\n-inf -inf -inf -inf\n-inf -inf -inf -inf\n-inf -inf -inf -inf\n");
  fs::remove(dir.path() / "frame-000002.pose.txt");
  const dataset::Capture capture = Open(dir.path());
  ASSERT_NE(capture.frames, nullptr);
  EXPECT_TRUE(capture.frames->capture_world_from_camera(FrameIdx{0}));
  EXPECT_FALSE(capture.frames->capture_world_from_camera(FrameIdx{1}));
  EXPECT_FALSE(capture.frames->capture_world_from_camera(FrameIdx{2}));
  EXPECT_THAT(capture.warnings, Contains(HasSubstr("frame-000001.pose.txt")));
  WriteText(dir.path() / "frame-000003.pose.txt", "1 0 0 0\n0 1 zero 0\n");
  EXPECT_THAT(Refusal(dir.path()), AllOf(HasSubstr("frame-000003.pose.txt:2"), HasSubstr("zero")));
}

TEST(SevenScenes, SceneFolderSaysWhichSequenceToName) {
  const TempDir dir;
  WriteSevenScenes(dir.path() / "chess/seq-01", "");
  EXPECT_THAT(Refusal(dir.path() / "chess"), HasSubstr("chess/seq-01 is one (7-scenes): name it"));
}

TEST(SevenScenes, ChangedPoseChangesTheHash) {
  const TempDir dir;
  WriteSevenScenes(dir.path(), "camera: " + kCamera + "\n");
  const std::string hash = Open(dir.path()).content_hash;
  WriteText(dir.path() / "frame-000001.pose.txt", foreign::MatrixText(foreign::kIdentity));
  EXPECT_NE(Open(dir.path()).content_hash, hash);
}

// --- Open3D, Redwood

void WriteOpen3d(const fs::path& folder, const std::string& colour = "color") {
  std::string log;
  for (int i = 0; i < kNumFrames; ++i) {
    WriteText(folder / colour / (foreign::Digits(i, 5) + ".png"), foreign::ColourFile(i));
    WriteText(folder / "depth" / (foreign::Digits(i, 5) + ".png"), foreign::DepthFile(i));
    log += fmt::format("{} {} {}\n", i, i, i + 1) + foreign::MatrixText(foreign::Matrix(i));
  }
  // As Open3D writes it: tabs, and the matrix column by column.
  WriteText(folder / "camera_intrinsic.json",
            "{\n\t\"height\" : 24,\n\t\"intrinsic_matrix\" : "
            "\n\t[\n\t\t30.3,\n\t\t0,\n\t\t0,\n\t\t0,\n\t\t"
            "30.3,\n\t\t0,\n\t\t15.5,\n\t\t11.25,\n\t\t1\n\t],\n\t\"width\" : 32\n}");
  WriteText(folder / "trajectory.log", log);
}

TEST(Open3d, ColumnMajorIntrinsicsAndLog) {
  for (const char* colour : {"color", "image", "rgb"}) {
    const TempDir dir;
    WriteOpen3d(dir.path(), colour);
    const dataset::Capture capture = Open(dir.path());
    EXPECT_EQ(capture.format, "open3d");
    ExpectTruth(capture, kNumFrames, 1.0 / 30);
  }
}

TEST(Open3d, RowMajorIntrinsicsAreReadAsMeantAndSaid) {
  const TempDir dir;
  WriteOpen3d(dir.path());
  WriteText(dir.path() / "camera_intrinsic.json",
            R"({"width":32,"height":24,"intrinsic_matrix":[30.3,0,15.5,0,30.3,11.25,0,0,1]})");
  const dataset::Capture capture = Open(dir.path());
  ExpectTruth(capture, kNumFrames, 1.0 / 30);
  EXPECT_THAT(capture.warnings, Contains(HasSubstr("row by row")));
}

TEST(Open3d, DepthScaleOfConfigIsTheUnit) {
  const TempDir dir;
  WriteOpen3d(dir.path());
  for (int i = 0; i < kNumFrames; ++i) {
    WriteText(dir.path() / "depth" / (foreign::Digits(i, 5) + ".png"), foreign::DepthFile(i, 5));
  }
  WriteText(dir.path() / "config.json", R"({"name": "mine", "depth_scale": 5000})");
  ExpectTruth(Open(dir.path()), kNumFrames, 1.0 / 30);
  WriteText(dir.path() / "config.json", R"({"depth_scale": 0})");
  EXPECT_THAT(Refusal(dir.path()), AllOf(HasSubstr("config.json"), HasSubstr("depth_scale")));
}

TEST(Open3d, RedwoodNamesCarryTimesThatPairImages) {
  const TempDir dir;
  WriteOpen3d(dir.path());
  fs::remove_all(dir.path() / "color");
  fs::remove_all(dir.path() / "depth");
  // Streams of their own: colour 2 is late (its depth is number 3), depth 2 has no colour.
  const std::vector<std::pair<int, int>> colour_us = {{1, 0}, {2, 66000}, {3, 100000}};
  const std::vector<std::pair<int, int>> depth_us = {{1, 1000}, {2, 33000}, {3, 65000}, {4, 99000}};
  for (const auto& [number, us] : colour_us) {
    WriteText(dir.path() / "image" / fmt::format("{:07d}-{:012d}.jpg", number, us),
              foreign::ColourFile(number, ".jpg"));
  }
  for (const auto& [number, us] : depth_us) {
    WriteText(dir.path() / "depth" / fmt::format("{:07d}-{:012d}.png", number, us),
              foreign::DepthFile(number));
  }
  fs::remove(dir.path() / "trajectory.log");
  const dataset::Capture capture = Open(dir.path());
  ASSERT_NE(capture.frames, nullptr);
  EXPECT_TRUE(capture.has_times);
  ASSERT_EQ(capture.frames->num_frames(), 3);
  EXPECT_NEAR(capture.frames->time_s(FrameIdx{1}), 0.065, 1e-9);
  EXPECT_FLOAT_EQ(capture.frames->ReadDepth(FrameIdx{1})->depth_m(1, 0), 1.033f) << "number 3";
  EXPECT_THAT(capture.warnings, Contains(HasSubstr("3 colour and 4 depth")));
}

TEST(Open3d, BrokenFilesNameTheField) {
  const TempDir dir;
  WriteOpen3d(dir.path());
  WriteText(dir.path() / "camera_intrinsic.json", R"({"width": 32, "height": 24)");
  EXPECT_THAT(Refusal(dir.path()), AllOf(HasSubstr("camera_intrinsic.json"), HasSubstr("JSON")));
  WriteText(dir.path() / "camera_intrinsic.json", R"({"width": 32, "intrinsic_matrix": [1]})");
  EXPECT_THAT(Refusal(dir.path()), HasSubstr("'height'"));
  WriteOpen3d(dir.path());
  WriteText(dir.path() / "trajectory.log", "0 0 1\n1 0 0 0\n0 1 0 0\n");
  EXPECT_THAT(Refusal(dir.path()), AllOf(HasSubstr("trajectory.log:1"), HasSubstr("truncated")));
  WriteText(dir.path() / "trajectory.log", "77 77 78\n1 0 0 0\n0 1 0 0\n0 0 1 0\n0 0 0 1\n");
  EXPECT_THAT(Refusal(dir.path()), AllOf(HasSubstr("frame 77"), HasSubstr("4 colour images")));
  fs::remove(dir.path() / "trajectory.log");
  fs::remove(dir.path() / "camera_intrinsic.json");
  EXPECT_THAT(Refusal(dir.path()), AllOf(HasSubstr("capture.yaml"), HasSubstr("missing")));
  WriteText(dir.path() / "config.json", "{}");
  EXPECT_THAT(Refusal(dir.path()), AllOf(HasSubstr("camera_intrinsic.json"), HasSubstr("missing")));
}

// --- Stray Scanner

void WriteStray(const fs::path& folder, int scale) {
  const double centre = (15.5 + 0.5) * scale - 0.5;
  const double middle = (11.25 + 0.5) * scale - 0.5;
  std::string odometry = "timestamp, frame, x, y, z, qx, qy, qz, qw, fx, fy, cx, cy, , \n";
  for (int i = 0; i < kNumFrames; ++i) {
    WriteText(folder / "rgb" / (foreign::Digits(i, 6) + ".png"),
              foreign::ColourFile(i, ".png", scale));
    WriteText(folder / "depth" / (foreign::Digits(i, 6) + ".png"), foreign::DepthFile(i));
    cv::Mat sure(foreign::kHeight, foreign::kWidth, CV_8UC1, cv::Scalar(2));
    sure.at<unsigned char>(5, 7) = 0;
    sure.at<unsigned char>(5, 8) = 1;
    WriteText(folder / "confidence" / (foreign::Digits(i, 6) + ".png"),
              foreign::Encoded(".png", sure));
    std::string pose = foreign::Tum(i);
    for (char& c : pose) c = c == ' ' ? ',' : c;
    odometry += fmt::format("{:.6f}, {:06d}, {}, {}, {}, {}, {}, , \n",
                            512.5 + 0.1 * i,
                            i,
                            pose,
                            30.3 * scale,
                            30.3 * scale,
                            centre,
                            middle);
  }
  WriteText(folder / "odometry.csv", odometry);
  WriteText(folder / "camera_matrix.csv",
            fmt::format(
                "{},0.0,{}\n0.0,{},{}\n0.0,0.0,1.0\n", 30.3 * scale, centre, 30.3 * scale, middle));
}

TEST(Stray, DepthWithLowConfidenceIsDropped) {
  const TempDir dir;
  WriteStray(dir.path(), 1);
  const dataset::Capture capture = Open(dir.path());
  EXPECT_EQ(capture.format, "stray");
  ASSERT_NE(capture.frames, nullptr);
  EXPECT_EQ(capture.frames->camera(), (PinholeCamera{32, 24, 30.3, 30.3, 15.5, 11.25}));
  const Frame frame = *capture.frames->Read(FrameIdx{2});
  EXPECT_EQ(frame.depth_m(7, 5), 0) << "confidence 0";
  EXPECT_FLOAT_EQ(frame.depth_m(8, 5), 0.001f * foreign::DepthMm(2, 8, 5)) << "confidence 1";
  EXPECT_DOUBLE_EQ(frame.time_s, 512.7);
  EXPECT_THAT(*capture.frames->capture_world_from_camera(FrameIdx{3}),
              PoseNear(TruePose(3), 2e-6, 2e-4));
  WriteText(dir.path() / "capture.yaml", "min_confidence: 2\n");
  EXPECT_EQ(Open(dir.path()).frames->Read(FrameIdx{2})->depth_m(8, 5), 0);
  WriteText(dir.path() / "capture.yaml", "min_confidence: 0\n");
  EXPECT_GT(Open(dir.path()).frames->Read(FrameIdx{2})->depth_m(7, 5), 0);
}

TEST(Stray, GivesEveryNthFrame) {
  const TempDir dir;
  WriteStray(dir.path(), 1);
  ExpectEveryNthIsItself(Open(dir.path()));
}

TEST(Stray, CoarserDepthIsResampledToColour) {
  const TempDir dir;
  WriteStray(dir.path(), 3);
  const dataset::Capture capture = Open(dir.path());
  ASSERT_NE(capture.frames, nullptr);
  EXPECT_EQ(capture.frames->camera().width, 96);
  const Frame frame = *capture.frames->Read(FrameIdx{1});
  ASSERT_EQ(frame.depth_m.width(), 96);
  ASSERT_EQ(frame.colour.width(), 96);
  // The middle of a 3 x 3 block is the depth pixel's own centre.
  EXPECT_NEAR(frame.depth_m(3 * 20 + 1, 3 * 10 + 1), 0.001f * foreign::DepthMm(1, 20, 10), 1e-6);
  const float left = frame.depth_m(3 * 20 + 1, 31);
  const float right = frame.depth_m(3 * 21 + 1, 31);
  EXPECT_GT(frame.depth_m(3 * 20 + 2, 31), left);
  EXPECT_LT(frame.depth_m(3 * 20 + 3, 31), right);
}

TEST(Stray, SizesAreThoseOfTheFirstFilesThatHaveOne) {
  const TempDir dir;
  WriteStray(dir.path(), 3);
  WriteText(dir.path() / "depth/000000.png", "");
  WriteText(dir.path() / "rgb/000000.png", "no image");
  WriteText(dir.path() / "rgb/000001.png", "no image either");
  const dataset::Capture capture = Open(dir.path());
  ASSERT_NE(capture.frames, nullptr);
  EXPECT_EQ(capture.stored->cameras().depth.width, 32);
  EXPECT_EQ(capture.frames->camera().width, 96);
  EXPECT_FALSE(capture.frames->Read(FrameIdx{0}).ok());
  EXPECT_FALSE(capture.frames->Read(FrameIdx{1}).ok());
  EXPECT_TRUE(capture.frames->Read(FrameIdx{2}).ok());
  for (int i = 1; i < kNumFrames; ++i)
    WriteText(dir.path() / "depth" / (foreign::Digits(i, 6) + ".png"), "damaged");
  EXPECT_THAT(Refusal(dir.path()), HasSubstr("000000.png")) << "the first one's fault";
}

TEST(Stray, VideoIsReadByFrameNumber) {
  const TempDir dir;
  WriteStray(dir.path(), 8);
  fs::remove_all(dir.path() / "rgb");
  cv::VideoWriter video((dir.path() / "rgb.mp4").string(),
                        cv::VideoWriter::fourcc('m', 'p', '4', 'v'),
                        30,
                        cv::Size(256, 192));
  ASSERT_TRUE(video.isOpened()) << "the OpenCV that reads videos also writes this one";
  for (int i = 0; i < kNumFrames; ++i)
    video.write(cv::Mat(192, 256, CV_8UC3, cv::Scalar(40, 40 * i + 20, 120)));
  video.release();
  const dataset::Capture capture = Open(dir.path());
  ASSERT_NE(capture.frames, nullptr);
  EXPECT_EQ(capture.frames->camera().width, 256);
  for (const int i : {0, 2, 3, 1, 3}) {
    const Result<Frame> frame = capture.frames->ReadColour(FrameIdx{i});
    ASSERT_TRUE(frame.ok()) << frame.error().message;
    EXPECT_NEAR(frame->colour(100, 100).g, 40 * i + 20, 8) << "frame " << i;
  }
  WriteText(dir.path() / "rgb.mp4", "no video");
  EXPECT_THAT(Refusal(dir.path()), HasSubstr("rgb.mp4"));
}

TEST(Stray, BadOdometryNamesLineAndColumn) {
  const TempDir dir;
  WriteStray(dir.path(), 1);
  WriteText(dir.path() / "odometry.csv", "timestamp, frame, x, y, z, qx, qy, qz\n");
  EXPECT_THAT(Refusal(dir.path()), AllOf(HasSubstr("odometry.csv:1"), HasSubstr("'qw'")));
  WriteText(dir.path() / "odometry.csv",
            "timestamp, frame, x, y, z, qx, qy, qz, qw\n0.1, 000000, 0, 0, far, 0, 0, 0, 1\n");
  EXPECT_THAT(Refusal(dir.path()), AllOf(HasSubstr("odometry.csv:2"), HasSubstr("'far'")));
  WriteText(dir.path() / "odometry.csv",
            "timestamp, frame, x, y, z, qx, qy, qz, qw\n0.1, 000900, 0, 0, 0, 0, 0, 0, 1\n");
  EXPECT_THAT(Refusal(dir.path()), AllOf(HasSubstr("000900"), HasSubstr("1 of 1")));
  WriteStray(dir.path(), 1);
  fs::remove_all(dir.path() / "depth");
  WriteText(dir.path() / "depth/000000.npz", "PK");
  EXPECT_THAT(Refusal(dir.path()), AllOf(HasSubstr("depth/000000.png"), HasSubstr("missing")));
}

// --- recognition

TEST(Layouts, UnknownFolderIsToldWhatIsNearest) {
  const TempDir dir;
  WriteText(dir.path() / "notes.txt", "x");
  EXPECT_THAT(Refusal(dir.path()),
              AllOf(HasSubstr("Known layouts"),
                    HasSubstr("scannet"),
                    HasSubstr("7-scenes"),
                    HasSubstr("stray"),
                    HasSubstr("icl-nuim"),
                    HasSubstr("eth3d"),
                    HasSubstr("open3d"),
                    Not(HasSubstr("nearest"))));
  WriteText(dir.path() / "camera_matrix.csv", "1,0,1\n0,1,1\n0,0,1\n");
  fs::create_directories(dir.path() / "depth");
  EXPECT_THAT(
      Refusal(dir.path()),
      AllOf(HasSubstr("nearest is stray"), HasSubstr("odometry.csv"), HasSubstr("rgb.mp4")));
}

TEST(Layouts, ForeignFilesInACaptureDoNotChangeWhatItIs) {
  const TempDir dir;
  WriteEth3d(dir.path());
  WriteText(dir.path() / "out.sens", foreign::Sens({}));
  WriteText(dir.path() / "odometry.csv", "made by another program\n");
  EXPECT_EQ(Open(dir.path()).format, "eth3d");
}

TEST(Layouts, StatedFormatWins) {
  const TempDir dir;
  WriteOpen3d(dir.path());
  WriteText(dir.path() / "capture.yaml",
            "format: tum\ncamera: " + kCamera + "\ndepth_units_per_m: 1000\n");
  EXPECT_THAT(Refusal(dir.path()), HasSubstr("rgb.txt"));
  WriteText(dir.path() / "capture.yaml", "format: open3d\n");
  EXPECT_EQ(Open(dir.path()).format, "open3d");
}

TEST(Layouts, StatedCamerasRegisterDepth) {
  const TempDir dir;
  WriteOpen3d(dir.path());
  WriteText(
      dir.path() / "capture.yaml",
      "camera: " + kCamera + "\ndepth_camera: " + kCamera +
          "\ncolour_from_depth: {translation_m: [-0.1, 0, 0], rotation_xyzw: [0, 0, 0, 1]}\n");
  const dataset::Capture capture = Open(dir.path());
  ASSERT_NE(capture.frames, nullptr);
  // 0.1 m at about 1.1 m: 30.3 * 0.1 / 1.1 = 2.8 px to the left.
  const Frame frame = *capture.frames->ReadDepth(FrameIdx{0});
  EXPECT_NEAR(frame.depth_m(10, 10), 0.001f * foreign::DepthMm(0, 13, 10), 0.003f);
  EXPECT_EQ(frame.depth_m(31, 10), 0);
}

}  // namespace
}  // namespace deepslam::layouts

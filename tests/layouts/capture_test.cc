#include "deepslam/layouts/open_capture.h"

#include <gmock/gmock.h>

#include "capture_files.h"
#include "deepslam/core/parallel.h"
#include "opened_capture.h"

namespace deepslam::layouts {
namespace {

using testing::AllOf;
using testing::ElementsAre;
using testing::HasSubstr;
using testing::IsEmpty;
using testing_support::TempDir;
using testing_support::WriteText;

// The message with which a capture is refused; empty when it is not.
std::string Refusal(const std::filesystem::path& folder) {
  const Result<dataset::Capture> capture = OpenCapture(folder);
  if (capture.ok()) return "";
  EXPECT_EQ(capture.error().code, ErrorCode::kInvalidInput);
  return capture.error().message;
}

std::vector<std::string> ColourFiles(const dataset::Capture& capture) {
  std::vector<std::string> names;
  for (const dataset::StoredFrame& frame : capture.stored->frames())
    names.push_back(frame.colour_name);
  return names;
}

TEST(OpenCapture, TakesEveryNthOfMoreFramesThanAreStated) {
  const TempDir dir;
  WriteCapture(dir.path(), 7);
  const Result<dataset::Capture> all = OpenCapture(dir.path());
  ASSERT_TRUE(all.ok());
  const auto with_most = [&](int most) {
    WriteText(dir.path() / "capture.yaml", kTestSettings + fmt::format("max_frames: {}\n", most));
    return OpenCapture(dir.path());
  };
  const Result<dataset::Capture> third = with_most(3);
  ASSERT_TRUE(third.ok()) << third.error().message;
  EXPECT_THAT(ColourFiles(*third), ElementsAre("rgb/0.png", "rgb/3.png", "rgb/6.png"));
  ASSERT_EQ(third->frames->num_frames(), 3);
  for (int k = 0; k < 3; ++k) {
    const Result<Frame> frame = third->frames->Read(FrameIdx{k});
    const Result<Frame> same = all->frames->Read(FrameIdx{3 * k});
    ASSERT_TRUE(frame.ok() && same.ok());
    EXPECT_EQ(frame->colour, same->colour);
    EXPECT_EQ(frame->depth_m, same->depth_m);
    EXPECT_EQ(frame->time_s, same->time_s);
  }
  EXPECT_THAT(third->warnings,
              ElementsAre(AllOf(HasSubstr("one frame in 3 is taken, 3 of 7"),
                                HasSubstr("'max_frames' in capture.yaml"))));
  EXPECT_NE(third->content_hash, all->content_hash);
  const Result<dataset::Capture> as_many = with_most(7);
  ASSERT_TRUE(as_many.ok());
  EXPECT_EQ(as_many->frames->num_frames(), 7);
  EXPECT_THAT(as_many->warnings, IsEmpty());
  EXPECT_EQ(with_most(1)->frames->num_frames(), 1);
  EXPECT_EQ(OpenCapture(dir.path(), FramesTaken::kAll)->frames->num_frames(), 7);
}

TEST(OpenCapture, RefusesToTakeNoFrames) {
  const TempDir dir;
  WriteCapture(dir.path(), 2);
  for (const char* const most : {"0", "-3", "many", "1.5", "[2]", "99999999999999999999"}) {
    WriteText(dir.path() / "capture.yaml", kTestSettings + fmt::format("max_frames: {}\n", most));
    EXPECT_THAT(Refusal(dir.path()), HasSubstr("capture.yaml:4: field 'max_frames' is")) << most;
  }
}

TEST(OpenCapture, ReadsColourDepthTimeAndCamera) {
  const TempDir dir;
  WriteCapture(dir.path() / "kitchen", 3);
  const Result<dataset::Capture> capture = OpenCapture(dir.path() / "kitchen");
  ASSERT_TRUE(capture.ok()) << capture.error().message;
  EXPECT_EQ(capture->name, "kitchen");
  EXPECT_FALSE(capture->has_poses);
  EXPECT_THAT(capture->warnings, IsEmpty());
  EXPECT_THAT(ColourFiles(*capture), ElementsAre("rgb/0.png", "rgb/1.png", "rgb/2.png"));
  const FrameSource& frames = *capture->frames;
  ASSERT_EQ(frames.num_frames(), 3);
  EXPECT_EQ(frames.camera(), (PinholeCamera{32, 24, 30, 30, 15.5, 11.5}));
  const Result<Frame> frame = frames.Read(FrameIdx{2});
  ASSERT_TRUE(frame.ok());
  EXPECT_DOUBLE_EQ(frame->time_s, 0.2);
  EXPECT_EQ(frame->colour(31, 23), (Rgb8{20, 20, 20}));
  EXPECT_FLOAT_EQ(frame->depth_m(31, 23), 1.002f);
  EXPECT_EQ((*frames.ReadStoredDepth(FrameIdx{2})).TakeMetres(), frame->depth_m);
  EXPECT_FALSE(frames.capture_world_from_camera(FrameIdx{2}).has_value());
  EXPECT_TRUE(frames.ReadDepth(FrameIdx{1})->colour.empty());
  EXPECT_TRUE(frames.ReadColour(FrameIdx{1})->depth_m.empty());
}

TEST(OpenCapture, TrailingSlashAndDotKeepTheName) {
  const TempDir dir;
  WriteCapture(dir.path() / "kitchen", 1);
  EXPECT_EQ(OpenCapture(dir.path() / "kitchen" / "")->name, "kitchen");
  EXPECT_EQ(OpenCapture(dir.path() / "kitchen" / ".")->name, "kitchen");
}

TEST(OpenCapture, AssociatesColourAndDepthByNearestTime) {
  const TempDir dir;
  WriteCapture(dir.path(), 4);
  // Frame 1's colour is 15 ms late (kept), frame 2's 30 ms (left out), frame 3's depth has a nearer
  // rival.
  WriteText(dir.path() / "rgb.txt",
            "0.0 rgb/0.png\n0.115 rgb/1.png\n0.23 rgb/2.png\n0.301 rgb/3.png\n");
  WriteText(
      dir.path() / "depth.txt",
      "0.0 depth/0.png\n0.1 depth/1.png\n0.2 depth/2.png\n0.29 depth/2.png\n0.3 depth/3.png\n");
  const Result<dataset::Capture> capture = OpenCapture(dir.path());
  ASSERT_TRUE(capture.ok()) << capture.error().message;
  ASSERT_EQ(capture->frames->num_frames(), 3);
  EXPECT_FLOAT_EQ(capture->frames->ReadDepth(FrameIdx{2})->depth_m(0, 0), 1.003f);
  EXPECT_THAT(capture->warnings, ElementsAre(AllOf(HasSubstr("depth.txt"), HasSubstr("2 of 5"))));
}

TEST(OpenCapture, AssociationsFileWinsAndMayPutDepthFirst) {
  const TempDir dir;
  WriteCapture(dir.path(), 2);
  WriteText(dir.path() / "associated.txt", "0.1 depth/1.png 0.5 rgb/0.png\n");
  const Result<dataset::Capture> capture = OpenCapture(dir.path());
  ASSERT_TRUE(capture.ok()) << capture.error().message;
  ASSERT_EQ(capture->frames->num_frames(), 1);
  const Result<Frame> frame = capture->frames->Read(FrameIdx{0});
  EXPECT_DOUBLE_EQ(frame->time_s, 0.1);
  EXPECT_FLOAT_EQ(frame->depth_m(0, 0), 1.001f);
  EXPECT_EQ(frame->colour(0, 0).r, 0);
}

TEST(OpenCapture, PosesAreInterpolatedInTime) {
  const TempDir dir;
  WriteCapture(dir.path(), 3);
  // Around 0.1 s a turn of 90 degrees about z within 50 ms; the third frame has no pose near it.
  WriteText(dir.path() / "groundtruth.txt",
            "0.0 1 2 3 0 0 0 1\n0.075 0 0 0 0 0 0 1\n0.125 2 0 0 0 0 0.70710678 0.70710678\n");
  const Result<dataset::Capture> capture = OpenCapture(dir.path());
  ASSERT_TRUE(capture.ok()) << capture.error().message;
  EXPECT_TRUE(capture->has_poses);
  EXPECT_EQ(capture->frames->capture_world_from_camera(FrameIdx{0})->translation_m,
            Eigen::Vector3d(1, 2, 3));
  const std::optional<Pose3> between = capture->frames->capture_world_from_camera(FrameIdx{1});
  ASSERT_TRUE(between.has_value());
  EXPECT_NEAR(between->translation_m.x(), 1.0, 1e-9);
  EXPECT_NEAR(RotationAngle(between->rotation), 0.25 * 3.14159265, 1e-6);
  EXPECT_FALSE(capture->frames->capture_world_from_camera(FrameIdx{2}).has_value());
}

// Frames 0 to 5 at 0.0 to 0.5 s, frames 6 to 11 at 0.22 to 0.72 s; poses at x = a centimetre a
// frame.
void WriteSetBackCapture(const std::filesystem::path& folder) {
  WriteCapture(folder, 12);
  std::string rgb, depth, poses;
  for (int i = 0; i < 12; ++i) {
    const double time_s = i < 6 ? 0.1 * i : 0.22 + 0.1 * (i - 6);
    rgb += fmt::format("{:.6f} rgb/{}.png\n", time_s, i);
    depth += fmt::format("{:.6f} depth/{}.png\n", time_s + 0.005, i);
    poses += fmt::format("{:.6f} {} 0 0 0 0 0 1\n", time_s + 0.005, 0.01 * i);
  }
  WriteText(folder / "rgb.txt", rgb);
  WriteText(folder / "depth.txt", depth);
  WriteText(folder / "groundtruth.txt", poses);
}

TEST(OpenCapture, KeepsRecordingsApartWhoseClockWasSetBack) {
  const TempDir dir;
  WriteSetBackCapture(dir.path());
  const Result<dataset::Capture> capture = OpenCapture(dir.path());
  ASSERT_TRUE(capture.ok()) << capture.error().message;
  ASSERT_EQ(capture->frames->num_frames(), 12);
  for (int i = 0; i < 12; ++i) {
    const Result<Frame> frame = capture->frames->Read(FrameIdx{i});
    EXPECT_EQ(frame->colour(0, 0).r, 10 * i);
    EXPECT_FLOAT_EQ(frame->depth_m(0, 0), 1.0f + 0.001f * static_cast<float>(i));
    const auto pose = capture->frames->capture_world_from_camera(FrameIdx{i});
    ASSERT_TRUE(pose.has_value()) << i;
    EXPECT_NEAR(pose->translation_m.x(), 0.01 * i, 1e-12);
  }
  EXPECT_THAT(capture->warnings,
              ElementsAre(HasSubstr("rgb.txt:7: the time falls back"),
                          HasSubstr("depth.txt:7: the time falls back"),
                          HasSubstr("groundtruth.txt:7: the time falls back")));
}

TEST(OpenCapture, DoesNotGuessWhereTimesFallBackInOneListAlone) {
  const TempDir dir;
  WriteSetBackCapture(dir.path());
  // Poses of another clock: those of times that stand for two moments belong to neither.
  std::string poses;
  for (int i = 0; i < 16; ++i) poses += fmt::format("{:.6f} {} 0 0 0 0 0 1\n", 0.005 + 0.05 * i, i);
  WriteText(dir.path() / "groundtruth.txt", poses);
  const Result<dataset::Capture> capture = OpenCapture(dir.path());
  ASSERT_TRUE(capture.ok()) << capture.error().message;
  EXPECT_THAT(capture->warnings,
              testing::Contains(AllOf(HasSubstr("groundtruth.txt"), HasSubstr("no pose"))));
  for (int i = 0; i < 12; ++i) {
    // 0.225 to 0.505 s stand for two moments: frames 3 to 5, and 6 to 8.
    EXPECT_EQ(capture->frames->capture_world_from_camera(FrameIdx{i}).has_value(), i < 3 || i > 8)
        << i;
  }
  std::string depth;
  for (int i = 0; i < 12; ++i) depth += fmt::format("{:.6f} depth/{}.png\n", 0.1 * i, i);
  WriteText(dir.path() / "depth.txt", depth);
  EXPECT_THAT(Refusal(dir.path()),
              AllOf(HasSubstr("rgb.txt fall back 1 times, those of depth.txt 0 times"),
                    HasSubstr("write associations.txt")));
}

TEST(OpenCapture, HashFollowsContentAndNotPlaceOrThreads) {
  const TempDir dir;
  WriteCapture(dir.path() / "a", 3);
  WriteCapture(dir.path() / "b", 3);
  const std::string hash = OpenCapture(dir.path() / "a")->content_hash;
  EXPECT_EQ(hash.size(), 64u);
  EXPECT_EQ(OpenCapture(dir.path() / "b")->content_hash, hash);
  {
    const ThreadLimit one(1);
    EXPECT_EQ(OpenCapture(dir.path() / "b")->content_hash, hash);
  }
  WriteText(dir.path() / "a/notes.txt", "not part of the capture");
  EXPECT_EQ(OpenCapture(dir.path() / "a")->content_hash, hash);

  ASSERT_TRUE(dataset::WriteDepthFile(dir.path() / "b/depth/1.png",
                                      RawDepthImage(kTestWidth, kTestHeight, 7))
                  .ok());
  EXPECT_NE(OpenCapture(dir.path() / "b")->content_hash, hash);
  WriteText(dir.path() / "a/groundtruth.txt", "0.0 1 2 3 0 0 0 1\n");
  EXPECT_NE(OpenCapture(dir.path() / "a")->content_hash, hash);
}

TEST(OpenCapture, BadFramesAreErrorsOfTheirOwn) {
  const TempDir dir;
  WriteCapture(dir.path(), 6);
  const std::string whole = testing_support::ReadText(dir.path() / "depth/1.png");
  WriteText(dir.path() / "depth/1.png", whole.substr(0, whole.size() - 20));
  WriteText(dir.path() / "depth/2.png", "");
  WriteText(dir.path() / "rgb/3.png", "no image at all");
  ASSERT_TRUE(dataset::WriteColourFile(dir.path() / "rgb/4.png", ColourImage(16, 24)).ok());
  std::filesystem::remove(dir.path() / "rgb/5.png");
  const Result<dataset::Capture> capture = OpenCapture(dir.path());
  ASSERT_TRUE(capture.ok()) << capture.error().message;
  EXPECT_TRUE(capture->frames->Read(FrameIdx{0}).ok());
  const std::vector<std::pair<std::string, std::string>> expected = {
      {"depth/1.png", "truncated"},
      {"depth/2.png", "empty"},
      {"rgb/3.png", "not a readable image"},
      {"rgb/4.png", "16 x 24 px"},
      {"rgb/5.png", "missing"},
  };
  for (int i = 1; i < 6; ++i) {
    const Result<Frame> frame = capture->frames->Read(FrameIdx{i});
    ASSERT_FALSE(frame.ok()) << i;
    const auto& [file, fault] = expected[static_cast<std::size_t>(i) - 1];
    EXPECT_THAT(frame.error().message, AllOf(HasSubstr(file), HasSubstr(fault)));
  }
  EXPECT_TRUE(capture->frames->ReadDepth(FrameIdx{4}).ok()) << "its depth is fine";
  EXPECT_TRUE(capture->frames->ReadStoredDepth(FrameIdx{4}).ok());
  EXPECT_THAT(capture->warnings, ElementsAre(AllOf(HasSubstr("rgb/5.png"), HasSubstr("1 of 6"))));
}

TEST(OpenCapture, FilesThatGoAwayAreNoBadFrames) {
  const TempDir dir;
  WriteCapture(dir.path(), 3);
  const Result<dataset::Capture> capture = OpenCapture(dir.path());
  ASSERT_TRUE(capture.ok()) << capture.error().message;
  ASSERT_TRUE(capture->frames->Read(FrameIdx{1}).ok());
  EXPECT_FALSE(capture->faults->first().has_value());
  std::filesystem::remove(dir.path() / "depth/1.png");
  const Result<Frame> frame = capture->frames->ReadDepth(FrameIdx{1});
  ASSERT_FALSE(frame.ok());
  EXPECT_EQ(frame.error().code, ErrorCode::kFailed);
  ASSERT_TRUE(capture->faults->first().has_value());
  EXPECT_THAT(capture->faults->first()->message,
              AllOf(HasSubstr("depth/1.png"), HasSubstr("read before")));
}

TEST(OpenCapture, SaysThatPicturesAreOfOneTone) {
  const TempDir dir;
  WriteCapture(dir.path(), 3);
  for (int i = 0; i < 3; ++i) {
    ASSERT_TRUE(dataset::WriteColourFile(dir.path() / fmt::format("rgb/{}.png", i),
                                         ColourImage(kTestWidth, kTestHeight, Rgb8{}))
                    .ok());
  }
  EXPECT_THAT(Open(dir.path()).doubts, ElementsAre(HasSubstr("3 of 3 pictures")));
}

TEST(OpenCapture, RefusesMissingFoldersAndFiles) {
  const TempDir dir;
  EXPECT_THAT(Refusal(dir.path() / "nowhere"), AllOf(HasSubstr("nowhere"), HasSubstr("missing")));
  WriteText(dir.path() / "file", "x");
  EXPECT_THAT(Refusal(dir.path() / "file"), HasSubstr("not a folder"));
  EXPECT_THAT(Refusal(dir.path()), AllOf(HasSubstr("rgb.txt"), HasSubstr("associations.txt")));
  WriteCapture(dir.path() / "a", 2);
  std::filesystem::remove(dir.path() / "a/depth.txt");
  EXPECT_THAT(Refusal(dir.path() / "a"), HasSubstr("depth.txt"));
  WriteCapture(dir.path() / "b", 2);
  std::filesystem::remove_all(dir.path() / "b/rgb");
  EXPECT_THAT(Refusal(dir.path() / "b"),
              AllOf(HasSubstr("rgb/0.png"), HasSubstr("2 of 2"), HasSubstr("line 2")));
}

TEST(OpenCapture, RefusesUnknownCamerasAndSaysHowToTellThem) {
  const TempDir dir;
  WriteCapture(dir.path() / "kitchen", 1);
  std::filesystem::remove(dir.path() / "kitchen/capture.yaml");
  EXPECT_THAT(
      Refusal(dir.path() / "kitchen"),
      AllOf(
          HasSubstr("capture.yaml"), HasSubstr("camera: {width"), HasSubstr("depth_units_per_m")));
}

TEST(OpenCapture, KnowsTheCamerasOfTumByName) {
  const TempDir dir;
  const std::filesystem::path folder = dir.path() / "rgbd_dataset_freiburg2_desk";
  std::filesystem::create_directories(folder / "rgb");
  std::filesystem::create_directories(folder / "depth");
  ColourImage colour(640, 480);
  colour(320, 240) = {255, 255, 255};
  ASSERT_TRUE(dataset::WriteColourFile(folder / "rgb/0.png", colour).ok());
  ASSERT_TRUE(dataset::WriteDepthFile(folder / "depth/0.png", RawDepthImage(640, 480, 5000)).ok());
  WriteText(folder / "rgb.txt", "0 rgb/0.png\n");
  WriteText(folder / "depth.txt", "0 depth/0.png\n");
  const Result<dataset::Capture> capture = OpenCapture(folder / "");
  ASSERT_TRUE(capture.ok()) << capture.error().message;
  EXPECT_DOUBLE_EQ(capture->frames->camera().fx, 520.9);
  const DepthImage depth_m = capture->frames->ReadDepth(FrameIdx{0})->depth_m;
  EXPECT_FLOAT_EQ(depth_m(320, 240), 1.0f);
  EXPECT_EQ(depth_m(0, 0), 0) << "the lens of freiburg2 does not show a pinhole's corner";
  EXPECT_THAT(capture->warnings, ElementsAre(HasSubstr("folder's name")));
}

TEST(OpenCapture, RefusesCapturesOfWhichNothingCanBeUsed) {
  const TempDir dir;
  WriteCapture(dir.path(), 3);
  WriteText(
      dir.path() / "capture.yaml",
      "camera: {width: 64, height: 48, fx: 30, fy: 30, cx: 15, cy: 11}\ndepth_units_per_m: 1000\n");
  EXPECT_THAT(Refusal(dir.path()),
              AllOf(HasSubstr("none of 3 frames"), HasSubstr("32 x 24 px, the camera 64 x 48")));

  WriteText(dir.path() / "capture.yaml", kTestSettings);
  for (int i = 0; i < 3; ++i) {
    ASSERT_TRUE(dataset::WriteDepthFile(dir.path() / fmt::format("depth/{}.png", i),
                                        RawDepthImage(kTestWidth, kTestHeight, 0))
                    .ok());
  }
  EXPECT_THAT(Refusal(dir.path()),
              AllOf(HasSubstr("no valid depth"), HasSubstr("depth_units_per_m")));
}

TEST(OpenCapture, RefusesColourAndDepthOfDifferentClocks) {
  const TempDir dir;
  WriteCapture(dir.path(), 2);
  WriteText(dir.path() / "depth.txt", "1000.0 depth/0.png\n1000.1 depth/1.png\n");
  EXPECT_THAT(Refusal(dir.path()), AllOf(HasSubstr("rgb.txt"), HasSubstr("clock")));
}

struct BadSettings {
  std::string name;
  std::string text;
  std::string place;  // part of the message
  std::string fault;
};

void PrintTo(const BadSettings& settings, std::ostream* out) { *out << settings.name; }

class BadSettingsTest : public testing::TestWithParam<BadSettings> {};

TEST_P(BadSettingsTest, IsRefusedWithFileLineAndField) {
  const TempDir dir;
  WriteCapture(dir.path(), 1);
  WriteText(dir.path() / "capture.yaml", GetParam().text);
  EXPECT_THAT(
      Refusal(dir.path()),
      AllOf(HasSubstr("capture.yaml"), HasSubstr(GetParam().place), HasSubstr(GetParam().fault)));
}

INSTANTIATE_TEST_SUITE_P(
    Settings,
    BadSettingsTest,
    testing::Values(
        BadSettings{"Empty", "", "camera", "missing"},
        BadSettings{"NotYaml", "camera: {width: [", "capture.yaml:", "not valid YAML"},
        BadSettings{"List", "- 1\n- 2\n", "camera", "missing"},
        BadSettings{
            "ForeignFormat", "format: rosbag\n", "capture.yaml:1: field 'format'", "rosbag"},
        BadSettings{"NoCamera", "format: tum\ndepth_units_per_m: 1000\n", "'camera'", "missing"},
        BadSettings{"NoUnits",
                    "camera: {width: 32, height: 24, fx: 30, fy: 30, cx: 15, cy: 11}\n",
                    "'depth_units_per_m'",
                    "missing"},
        BadSettings{"ZeroUnits",
                    "camera: {width: 32, height: 24, fx: 30, fy: 30, cx: 15, cy: "
                    "11}\ndepth_units_per_m: 0\n",
                    "capture.yaml:2: field 'depth_units_per_m'",
                    "is 0"},
        BadSettings{"NoFx",
                    "\ncamera: {width: 32, height: 24, fy: 30, cx: 15, cy: 11}\n",
                    "capture.yaml:2: field 'camera.fx'",
                    "missing"},
        BadSettings{"WordAsFx",
                    "camera: {width: 32, height: 24, fx: wide, fy: 30, cx: 15, cy: 11}\n",
                    "'camera.fx'",
                    "'wide', not a number"},
        BadSettings{"NanFx",
                    "camera: {width: 32, height: 24, fx: .nan, fy: 30, cx: 15, cy: 11}\n",
                    "'camera.fx'",
                    "finite"},
        BadSettings{"NegativeFy",
                    "camera: {width: 32, height: 24, fx: 30, fy: -30, cx: 15, cy: 11}\n",
                    "'camera.fy'",
                    "is -30"},
        BadSettings{"HugeFx",
                    "camera: {width: 32, height: 24, fx: 1e9, fy: 30, cx: 15, cy: 11}\n",
                    "'camera.fx'",
                    "is 1000000000"},
        BadSettings{"CentreOutside",
                    "camera: {width: 32, height: 24, fx: 30, fy: 30, cx: 40, cy: 11}\n",
                    "'camera.cx'",
                    "is 40"},
        BadSettings{"NoWidth",
                    "camera: {width: 0, height: 24, fx: 30, fy: 30, cx: 15, cy: 11}\n",
                    "'camera.width'",
                    "is 0"},
        BadSettings{"HugeHeight",
                    "camera: {width: 32, height: 20000, fx: 30, fy: 30, cx: 15, cy: 11}\n",
                    "'camera.height'",
                    "16384"},
        BadSettings{"HalfWidth",
                    "camera: {width: 3.5, height: 24, fx: 30, fy: 30, cx: 15, cy: 11}\n",
                    "'camera.width'",
                    "not a whole number"}),
    [](const auto& test) { return test.param.name; });

TEST(OpenCapture, WarnsOfUnknownSettings) {
  const TempDir dir;
  WriteCapture(dir.path(), 1);
  WriteText(dir.path() / "capture.yaml", std::string(kTestSettings) + "depth_unit: 5\n");
  EXPECT_THAT(
      OpenCapture(dir.path())->warnings,
      ElementsAre(AllOf(
          HasSubstr("capture.yaml:4"), HasSubstr("'depth_unit'"), HasSubstr("depth_units_per_m"))));
}

}  // namespace
}  // namespace deepslam::layouts

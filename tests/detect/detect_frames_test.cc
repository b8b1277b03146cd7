#include "deepslam/detect/detect_frames.h"

#include <algorithm>
#include <cstdint>
#include <initializer_list>
#include <optional>
#include <set>
#include <utility>
#include <vector>

#include <gmock/gmock.h>

#include "deepslam/core/parallel.h"
#include "deepslam/detect/sharpness.h"
#include "support/box_world.h"
#include "support/recording_progress.h"

namespace deepslam::detect {
namespace {

using testing::Each;
using testing::ElementsAre;
using testing::Field;
using testing::HasSubstr;
using testing::IsEmpty;
using testing::SizeIs;
using testing_support::BoxWorldSource;
using testing_support::Cuboid;
using testing_support::DetectTruth;
using testing_support::Orbit;
using testing_support::RecordingProgress;

constexpr int kCabinet = 0;
constexpr int kChair = 1;
constexpr int kPerson = 2;

// As RenderBoxes paints an object.
constexpr std::uint8_t Shade(int object) {
  return static_cast<std::uint8_t>(60 + 50 * (object + 1));
}

// Sees chairs and persons by their shade, and no cabinets.
class ShadeDetector final : public Detector {
 public:
  explicit ShadeDetector(double person_score = 0.9) : person_score_(person_score) {}

  [[nodiscard]] std::vector<std::string> labels() const override { return {"chair", "person"}; }
  [[nodiscard]] Result<std::vector<RawDetection>> Detect(const ColourImage& image) const override {
    std::vector<RawDetection> found;
    for (const auto& [object, label] : {std::pair(kChair, "chair"), std::pair(kPerson, "person")}) {
      Box2 box{1e9, 1e9, -1, -1};
      for (int v = 0; v < image.height(); ++v) {
        for (int u = 0; u < image.width(); ++u) {
          if (image(u, v).r != Shade(object)) continue;
          box = {std::min<double>(box.u_min, u),
                 std::min<double>(box.v_min, v),
                 std::max<double>(box.u_max, u),
                 std::max<double>(box.v_max, v)};
        }
      }
      if (box.empty()) continue;
      found.push_back({label, object == kPerson ? person_score_ : 0.9, box, {}});
    }
    return found;
  }

 private:
  double person_score_;
};

class BrokenDetector final : public Detector {
 public:
  [[nodiscard]] std::vector<std::string> labels() const override { return {}; }
  [[nodiscard]] Result<std::vector<RawDetection>> Detect(const ColourImage&) const override {
    return Failed("out of memory");
  }
};

template <typename Loaded>
DetectorLoader Loads(Loaded detector) {
  return [detector](Sides) -> Result<std::shared_ptr<const Detector>> {
    return std::shared_ptr<const Detector>(std::make_shared<Loaded>(detector));
  };
}

ClassTable Classes() {
  ClassTable table;
  table.classes.resize(2);
  table.classes[0].name = "chair";
  table.classes[0].detector_labels = {"chair"};
  table.classes[1].name = "cabinet";
  table.classes[1].min_size_m = 0.5;
  table.classes[1].max_size_m = 1.8;
  table.classes[1].min_height_m = 0.4;
  table.classes[1].max_height_m = 1.8;
  return table;
}

const Cuboid kCabinetBox{kCabinet, {-0.4, -0.25, 0}, {0.4, 0.25, 0.6}};
const Cuboid kChairBox{kChair, {-0.2, 0.6, 0}, {0.2, 1.0, 0.5}};
const Cuboid kPersonBox{kPerson, {0.9, 0.9, 0}, {1.2, 1.2, 1.7}};

// A cabinet and a chair, seen from all round; every frame a keyframe.
struct Scene {
  explicit Scene(const std::vector<Cuboid>& world = {kCabinetBox, kChairBox})
      : source(world, Orbit({0, 0.3, 0.3}, 2.2, 1.4, -90, 20, 5)) {
    ground.plane_world = Plane{};
  }

  [[nodiscard]] std::vector<FrameIdx> all() const { return path.keyframes; }

  Result<std::vector<FrameDetections>> Detect(const DetectorLoader& load,
                                              Progress& progress,
                                              const std::vector<Detection>& given = {}) const {
    return DetectFrames({source, path, ground, classes, given}, all(), load, {}, progress);
  }

  BoxWorldSource source;
  Odometry path = source.TrueOdometry();
  Ground ground;
  ClassTable classes = Classes();
};

std::vector<std::string> ClassesOf(const FrameDetections& of_frame) {
  std::vector<std::string> names;
  for (const Detection& detection : of_frame.detections) names.push_back(detection.class_name);
  return names;
}

TEST(DetectFrames, ClustersComeBehindWhatTheDetectorSawAndWhatWasGiven) {
  const Scene scene;
  const FrameIdx second{1};
  Detection given = *DetectTruth(scene.source.View(second), kCabinet, "cabinet");
  given.source = DetectionSource::kFile;
  RecordingProgress progress;
  const auto found = scene.Detect(Loads(ShadeDetector()), progress, {given});
  ASSERT_TRUE(found.ok());
  ASSERT_THAT(*found, SizeIs(5));
  for (const FrameDetections& of_frame : *found) {
    EXPECT_THAT(ClassesOf(of_frame), ElementsAre("chair", "cabinet")) << of_frame.frame.value;
    EXPECT_EQ(of_frame.detections[0].source, DetectionSource::kNetwork);
    EXPECT_EQ(of_frame.detections[1].source,
              of_frame.frame == second ? DetectionSource::kFile : DetectionSource::kCluster);
    EXPECT_THAT(of_frame.detections, Each(Field(&Detection::frame, of_frame.frame)));
    EXPECT_EQ(of_frame.contains_person, false);
  }
  EXPECT_THAT(progress.warnings, IsEmpty());
  EXPECT_EQ(progress.last_done, 5u);
}

TEST(DetectFrames, WithoutADetectorThereAreClustersAndNobodyLookedForPersons) {
  const Scene scene;
  RecordingProgress progress;
  const auto found = scene.Detect({}, progress);
  ASSERT_TRUE(found.ok());
  for (const FrameDetections& of_frame : *found) {
    EXPECT_THAT(of_frame.detections, Each(Field(&Detection::source, DetectionSource::kCluster)));
    EXPECT_THAT(of_frame.detections, testing::Not(IsEmpty()));
    EXPECT_EQ(of_frame.contains_person, std::nullopt);
  }
}

TEST(DetectFrames, APersonIsToldButNotDetected) {
  const Scene scene({kChairBox, kPersonBox});
  RecordingProgress progress;
  for (const double score : {0.9, 0.26, 0.1}) {
    const auto found = scene.Detect(Loads(ShadeDetector(score)), progress);
    ASSERT_TRUE(found.ok());
    const bool shown = std::ranges::any_of(
        *found, [](const FrameDetections& of_frame) { return *of_frame.contains_person; });
    EXPECT_EQ(shown, score > 0.25) << score;
    for (const FrameDetections& of_frame : *found) {
      for (const std::string& name : ClassesOf(of_frame)) EXPECT_NE(name, "person");
    }
  }
}

TEST(DetectFrames, AFrameThatCannotBeReadIsToldAndEmpty) {
  Scene scene;
  scene.source.broken = {3};
  RecordingProgress progress;
  const auto found = scene.Detect(Loads(ShadeDetector()), progress);
  ASSERT_TRUE(found.ok());
  for (const FrameDetections& of_frame : *found)
    EXPECT_EQ(of_frame.detections.empty(), of_frame.frame == FrameIdx{3});
  EXPECT_THAT(progress.warnings, ElementsAre(HasSubstr("frame 3 skipped: frame is broken")));
}

TEST(DetectFrames, ADetectorThatFailsIsToldForEachFrameAndClustersStay) {
  const Scene scene;
  RecordingProgress progress;
  const auto found = scene.Detect(Loads(BrokenDetector()), progress);
  ASSERT_TRUE(found.ok());
  for (const FrameDetections& of_frame : *found)
    EXPECT_THAT(of_frame.detections, testing::Not(IsEmpty()));
  EXPECT_THAT(progress.warnings, SizeIs(5));
  EXPECT_THAT(progress.warnings, Each(HasSubstr("out of memory")));
}

TEST(DetectFrames, ADetectorThatCannotBeLoadedIsAnError) {
  const Scene scene;
  RecordingProgress progress;
  const auto found = scene.Detect(
      [](Sides) -> Result<std::shared_ptr<const Detector>> { return InvalidInput("no ONNX file"); },
      progress);
  ASSERT_FALSE(found.ok());
  EXPECT_EQ(found.error().message, "no ONNX file");
}

TEST(DetectFrames, EndsWhenAskedTo) {
  const Scene scene;
  RecordingProgress progress(3);
  const auto found = scene.Detect(Loads(ShadeDetector()), progress);
  ASSERT_FALSE(found.ok());
  EXPECT_EQ(found.error().code, ErrorCode::kInterrupted);
}

// Phones record pictures that lie on their side; the detector is loaded for what it is shown.
TEST(DetectFrames, TheDetectorIsLoadedForPicturesAsTheyAreShown) {
  Scene scene;
  const PinholeCamera& camera = scene.source.camera();
  RecordingProgress progress;
  Sides shown;
  const DetectorLoader load = [&](Sides pictures) -> Result<std::shared_ptr<const Detector>> {
    shown = pictures;
    return std::shared_ptr<const Detector>(std::make_shared<ShadeDetector>());
  };
  ASSERT_TRUE(scene.Detect(load, progress).ok());
  EXPECT_EQ(shown, (Sides{camera.width, camera.height}));
  scene.ground = Ground();
  scene.ground.upright = QuarterTurn::kClockwise;
  ASSERT_TRUE(scene.Detect(load, progress).ok());
  EXPECT_EQ(shown, (Sides{camera.height, camera.width}));
}

TEST(DetectFrames, TheNumberOfThreadsChangesNothing) {
  const Scene scene;
  const auto detect = [&](int threads) {
    const ThreadLimit limit(threads);
    RecordingProgress progress;
    return *scene.Detect(Loads(ShadeDetector()), progress);
  };
  const std::vector<FrameDetections> one = detect(1);
  const std::vector<FrameDetections> four = detect(4);
  ASSERT_EQ(one.size(), four.size());
  for (std::size_t k = 0; k < one.size(); ++k) {
    ASSERT_EQ(ClassesOf(one[k]), ClassesOf(four[k]));
    for (std::size_t n = 0; n < one[k].detections.size(); ++n) {
      EXPECT_EQ(one[k].detections[n].box_px, four[k].detections[n].box_px);
      EXPECT_EQ(one[k].detections[n].mask, four[k].detections[n].mask);
    }
  }
}

TEST(DetectFrames, OfNoFramesIsNothing) {
  const Scene scene;
  RecordingProgress progress;
  const auto found = DetectFrames(
      {scene.source, scene.path, scene.ground, scene.classes, {}}, {}, {}, {}, progress);
  ASSERT_TRUE(found.ok());
  EXPECT_THAT(*found, IsEmpty());
}

TEST(FramesToSearch, AreKeyframesThoseGivenOrAllThatHaveAPose) {
  Trajectory path;
  for (int k = 0; k < 6; ++k) {
    TrackedFrame frame;
    frame.frame = FrameIdx{k};
    path.frames.push_back(frame);
  }
  path.frames[3].status = TrackingStatus::kLost;
  path.frames[4].status = TrackingStatus::kUnreadable;
  path.frames[5].status = TrackingStatus::kDegenerate;
  path.keyframes = {FrameIdx{0}, FrameIdx{3}};
  Detection given;
  given.frame = FrameIdx{1};
  Detection of_lost;
  of_lost.frame = FrameIdx{4};
  EXPECT_THAT(FramesToSearch(path, {}, false), ElementsAre(FrameIdx{0}));
  EXPECT_THAT(FramesToSearch(path, std::vector{given, of_lost}, false),
              ElementsAre(FrameIdx{0}, FrameIdx{1}));
  EXPECT_THAT(FramesToSearch(path, {}, true),
              ElementsAre(FrameIdx{0}, FrameIdx{1}, FrameIdx{2}, FrameIdx{5}));
}

// Of the keyframes.
std::vector<FrameIdx> NewFramesOf(const FrameSource& source,
                                  const Odometry& path,
                                  const Ground& ground,
                                  const std::vector<Detection>& given) {
  RecordingProgress progress;
  const ClassTable classes = Classes();
  const auto frames =
      FramesOfNewSurface({source, path, ground, classes, given}, path.keyframes, progress);
  EXPECT_TRUE(frames.ok());
  return frames.ok() ? *frames : std::vector<FrameIdx>();
}

// A camera that stands still for twenty frames.
struct StandingCamera {
  StandingCamera() { ground.plane_world = Plane{}; }
  [[nodiscard]] std::vector<FrameIdx> NewOf(const std::vector<Detection>& given) const {
    return NewFramesOf(source, path, ground, given);
  }

  BoxWorldSource source{{kCabinetBox, kChairBox}, Orbit({0, 0.3, 0.3}, 2.2, 1.4, -90, 0, 20)};
  Odometry path = source.TrueOdometry();
  Ground ground;
};

TEST(FramesOfNewSurface, LeavesOutWhatShowsTheSameButNotWhatIsGiven) {
  const StandingCamera scene;
  const std::vector<FrameIdx> frames = scene.NewOf({});
  EXPECT_EQ(frames.front(), FrameIdx{0});
  EXPECT_LT(frames.size(), 6);
  Detection given;
  given.frame = FrameIdx{17};
  std::vector<FrameIdx> with_given = frames;
  with_given.push_back(given.frame);
  EXPECT_EQ(scene.NewOf({given}), with_given);
}

// Stripes of a pixel; of six where the camera moved.
IntensityImage Stripes(int width_px) {
  IntensityImage image(60, 40);
  for (int v = 0; v < image.height(); ++v) {
    for (int u = 0; u < image.width(); ++u) image(u, v) = (u / width_px) % 2 == 0 ? 0.0F : 200.0F;
  }
  return image;
}

TEST(Sharpness, IsGreaterOfNarrowStripesAndNothingOfNoPicture) {
  EXPECT_GT(Sharpness(Stripes(1)), 2 * Sharpness(Stripes(6)));
  EXPECT_GT(Sharpness(Stripes(6)), 0);
  EXPECT_EQ(Sharpness(IntensityImage(60, 40, 90.0F)), 0);
  EXPECT_EQ(Sharpness(IntensityImage(2, 40, 90.0F)), 0);
  EXPECT_EQ(Sharpness(IntensityImage()), 0);
}

// The same pictures; some are blurred by motion, so that nothing is left of edges.
class ShakenSource final : public FrameSource {
 public:
  [[nodiscard]] int num_frames() const override { return still.num_frames(); }
  [[nodiscard]] const PinholeCamera& camera() const override { return still.camera(); }
  [[nodiscard]] double time_s(FrameIdx frame) const override { return frame.value / frames_per_s; }
  [[nodiscard]] Result<Frame> Read(FrameIdx frame) const override { return still.Read(frame); }
  [[nodiscard]] Result<Frame> ReadDepth(FrameIdx frame) const override {
    return still.ReadDepth(frame);
  }
  [[nodiscard]] Result<Frame> ReadColour(FrameIdx frame) const override {
    return still.ReadColour(frame);
  }
  [[nodiscard]] std::optional<Pose3> capture_world_from_camera(FrameIdx frame) const override {
    return still.capture_world_from_camera(frame);
  }
  [[nodiscard]] Result<IntensityImage> ReadIntensity(FrameIdx frame, int) const override {
    if (std::ranges::find(unreadable, frame.value) != unreadable.end())
      return InvalidInput("no picture");
    return Stripes(std::ranges::find(sharp, frame.value) != sharp.end() ? 1 : 6);
  }

  BoxWorldSource still{{kCabinetBox, kChairBox}, Orbit({0, 0.3, 0.3}, 2.2, 1.4, -90, 180, 20)};
  double frames_per_s = 30;
  std::vector<int> sharp;
  std::vector<int> unreadable;
};

// A camera that goes half round within twenty frames, of which every tenth is a keyframe.
struct ShakenCamera {
  ShakenCamera() {
    ground.plane_world = Plane{};
    path.keyframes = {FrameIdx{0}, FrameIdx{10}, FrameIdx{19}};
  }
  [[nodiscard]] std::vector<FrameIdx> NewOf(const std::vector<Detection>& given) const {
    return NewFramesOf(source, path, ground, given);
  }

  ShakenSource source;
  Odometry path = source.still.TrueOdometry();
  Ground ground;
};

std::vector<FrameIdx> Frames(std::initializer_list<int> values) {
  std::vector<FrameIdx> frames;
  for (const int value : values) frames.push_back(FrameIdx{value});
  return frames;
}

TEST(FramesOfNewSurface, HaveASharperOneBesideThemWhereTheyAreBlurred) {
  ShakenCamera scene;
  EXPECT_EQ(scene.NewOf({}), scene.path.keyframes);
  scene.source.sharp = {3, 12, 13};
  EXPECT_EQ(scene.NewOf({}), Frames({0, 3, 10, 12, 19}));
  scene.source.sharp = {5, 9, 10};  // too far from the first; the keyframe is sharp itself
  EXPECT_EQ(scene.NewOf({}), Frames({0, 10, 19}));
  scene.source.sharp = {1, 11};
  EXPECT_EQ(scene.NewOf({}), Frames({0, 1, 10, 11, 19}));
  scene.source.frames_per_s = 5;  // a fifth of a second between two
  EXPECT_EQ(scene.NewOf({}), scene.path.keyframes);
}

TEST(FramesOfNewSurface, ASharpFrameIsBesideOneOfThemAlone) {
  ShakenCamera scene;
  scene.path.keyframes = Frames({0, 4, 19});
  scene.source.sharp = {2};
  EXPECT_EQ(scene.NewOf({}), Frames({0, 4, 19}));
  scene.source.sharp = {3};
  EXPECT_EQ(scene.NewOf({}), Frames({0, 3, 4, 19}));
}

TEST(FramesOfNewSurface, HaveNoneBesideThemThatIsOfNoUse) {
  ShakenCamera scene;
  scene.source.sharp = {3, 12};
  Detection given;
  given.frame = FrameIdx{0};
  scene.path.frames[12].status = TrackingStatus::kLost;
  EXPECT_EQ(scene.NewOf({given}), scene.path.keyframes);
  scene.source.sharp = {3};
  scene.source.unreadable = {3, 19};
  EXPECT_EQ(scene.NewOf({}), scene.path.keyframes);
}

TEST(FramesOfNewSurface, AreAllWithoutAGround) {
  StandingCamera scene;
  scene.ground.plane_world.reset();
  EXPECT_EQ(scene.NewOf({}), scene.path.keyframes);
}

TEST(FramesOfNewSurface, KeepsFramesOfAnotherWorld) {
  StandingCamera scene;
  scene.ground.apart.push_back({FrameIdx{15}, FrameIdx{20}, {}});
  const std::vector<FrameIdx> frames = scene.NewOf({});
  EXPECT_THAT(std::vector(frames.end() - 5, frames.end()),
              ElementsAre(FrameIdx{15}, FrameIdx{16}, FrameIdx{17}, FrameIdx{18}, FrameIdx{19}));
}

TEST(FramesOfNewSurface, KeepsWhatItCannotRead) {
  StandingCamera scene;
  scene.source.broken = {12};
  EXPECT_EQ(scene.NewOf({}).back(), FrameIdx{12});
}

}  // namespace
}  // namespace deepslam::detect

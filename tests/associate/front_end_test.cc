// Detection, segmentation and matching together on the real captures, with the poses that came with
// them.
#include <algorithm>
#include <cstdlib>
#include <filesystem>
#include <map>
#include <optional>
#include <string>

#include <gmock/gmock.h>

#include "deepslam/associate/associate.h"
#include "deepslam/detect/cluster_detector.h"
#include "deepslam/detect/detect_frame.h"
#include "deepslam/detect/fitted_network.h"
#include "deepslam/ground/ground_plane.h"
#include "deepslam/layouts/open_capture.h"
#include "deepslam/observe/object_views.h"
#include "deepslam/scene/measured_parts.h"
#include "deepslam/segment/segment_objects.h"
#include "support/temp_dir.h"
#include "support/test_data.h"

namespace deepslam {
namespace {

using testing::Ge;
using testing::SizeIs;

std::optional<std::string> WeightBytes(const std::string& file) {
  std::filesystem::path folder;
  if (const char* weights = std::getenv("DEEPSLAM_WEIGHTS")) {
    folder = weights;
  } else if (const char* home = std::getenv("HOME")) {
    folder = std::filesystem::path(home) / ".local/share/deepslam/weights";
  }
  if (!std::filesystem::is_regular_file(folder / file)) return std::nullopt;
  return testing_support::ReadText(folder / file);
}

ClassTable Classes() {
  ClassTable table;
  const auto add = [&](const std::string& name, const std::string& label) {
    ObjectClass c;
    c.name = name;
    if (!label.empty()) c.detector_labels = {label};
    table.classes.push_back(c);
  };
  add("chair", "chair");
  add("table", "dining table");
  table.classes.back().traits.support_plane = true;
  add("sofa", "couch");
  add("cabinet", "");
  table.classes.back().min_size_m = 0.4;
  add("furniture", "");
  table.classes.back().traits.fallback = true;
  return table;
}

// Every `step`-th frame is a keyframe; the capture's poses, its first frame being the world.
Odometry GivenPoses(const FrameSource& frames, int step) {
  Odometry odometry;
  const Pose3 first_from_capture = frames.capture_world_from_camera({0})->Inverse();
  for (int i = 0; i < frames.num_frames(); ++i) {
    TrackedFrame tracked;
    tracked.frame = {i};
    tracked.keyframe = {i / step * step};
    tracked.world_from_camera = first_from_capture * *frames.capture_world_from_camera({i});
    odometry.frames.push_back(tracked);
    if (i % step == 0) odometry.keyframes.push_back({i});
  }
  return odometry;
}

struct Outcome {
  Odometry odometry;
  Ground ground;
  std::vector<Segment> segments;
  Association association;
};

Outcome RunFrontEnd(const FrameSource& frames, int step, const std::string& weights) {
  Outcome outcome;
  SilentProgress progress;
  outcome.odometry = GivenPoses(frames, step);
  outcome.ground = *ground::EstimateGround(frames, outcome.odometry, {}, progress);
  const auto detector = detect::LoadNetworkDetector(weights, {});
  EXPECT_TRUE(detector.ok()) << detector.error().message;
  int id = 0;
  for (const FrameIdx keyframe : outcome.odometry.keyframes) {
    const Frame frame = *frames.Read(keyframe);
    const Plane ground_camera =
        Transformed(outcome.odometry.at(keyframe).world_from_camera.Inverse(),
                    outcome.ground.plane_world.value());
    auto detections = *detect::DetectFrame(**detector, frame, Classes(), {});
    for (Detection& cluster :
         detect::DetectClusters(frame, frames.camera(), ground_camera, detections, Classes(), {})) {
      detections.push_back(std::move(cluster));
    }
    for (Detection& detection : detections) detection.id = {id++};
    for (Segment& segment : segment::SegmentFrame(
             {frame, frames.camera(), ground_camera, detections}, Classes(), {})) {
      outcome.segments.push_back(std::move(segment));
    }
  }
  const std::vector<int> parts = PartsOfFrames(outcome.odometry, JoinsOf(outcome.odometry));
  outcome.association =
      *associate::Associate(frames, outcome.odometry, parts, outcome.segments, {}, progress);
  return outcome;
}

std::map<std::string, int> CountClasses(const Association& association) {
  std::map<std::string, int> counts;
  for (const ObjectTrack& track : association.tracks) ++counts[track.class_name];
  return counts;
}

TEST(FrontEnd, FindsOneTableAndItsChairsInARealKitchen) {
  DEEPSLAM_REQUIRE_TEST_DATA(data);
  const auto weights = WeightBytes("yolov8s.onnx");
  ASSERT_TRUE(weights) << "scripts/setup.sh installs yolov8s.onnx";
  const auto capture = layouts::OpenCapture(data / "data/redkitchen");
  ASSERT_TRUE(capture.ok()) << capture.error().message;
  const Outcome outcome = RunFrontEnd(*capture->frames, 20, *weights);
  const auto counts = CountClasses(outcome.association);
  ASSERT_EQ(counts.count("table"), 1U);
  EXPECT_EQ(counts.at("table"), 1);
  EXPECT_GE(counts.at("chair"), 3);
  EXPECT_LE(counts.at("chair"), 5) << "no more stand round the table";
  EXPECT_EQ(counts.count("cabinet") + counts.count("furniture"), 0U) << "fitted kitchen";
  SilentProgress progress;
  const auto views = observe::CollectObjectViews(*capture->frames,
                                                 outcome.odometry,
                                                 outcome.ground,
                                                 outcome.segments,
                                                 outcome.association.tracks,
                                                 {},
                                                 progress);
  ASSERT_TRUE(views.ok());
  EXPECT_THAT(*views, SizeIs(outcome.association.tracks.size()));
}

TEST(FrontEnd, FindsACabinetThatNoDetectorKnows) {
  DEEPSLAM_REQUIRE_TEST_DATA(data);
  const auto weights = WeightBytes("yolov8s.onnx");
  ASSERT_TRUE(weights) << "scripts/setup.sh installs yolov8s.onnx";
  const auto capture = layouts::OpenCapture(data / "data/fr3_cabinet");
  ASSERT_TRUE(capture.ok()) << capture.error().message;
  const Outcome outcome = RunFrontEnd(*capture->frames, 3, *weights);
  ASSERT_THAT(outcome.association.tracks, SizeIs(1));
  const ObjectTrack& track = outcome.association.tracks[0];
  EXPECT_TRUE(track.class_name == "cabinet" || track.class_name == "furniture");
  EXPECT_THAT(track.members.size(), Ge(outcome.odometry.keyframes.size() * 3 / 4));
}

TEST(FrontEnd, DetectsTheSameWithAnyNumberOfThreads) {
  DEEPSLAM_REQUIRE_TEST_DATA(data);
  const auto capture = layouts::OpenCapture(data / "data/redkitchen");
  ASSERT_TRUE(capture.ok()) << capture.error().message;
  const Frame frame = *capture->frames->Read({250});
  for (const char* file : {"yolov8s.onnx", "yolo11n.onnx", "yolo11n-seg.onnx"}) {
    const auto weights = WeightBytes(file);
    ASSERT_TRUE(weights) << "scripts/setup.sh installs " << file;
    std::vector<detect::RawDetection> first;
    for (const int num_threads : {1, 2, 3}) {
      detect::DetectorOptions options;
      options.num_threads = num_threads;
      const auto detector = detect::LoadNetworkDetector(*weights, options);
      ASSERT_TRUE(detector.ok()) << file << ": " << detector.error().message;
      const auto found = (*detector)->Detect(frame.colour);
      ASSERT_TRUE(found.ok());
      ASSERT_THAT(found->size(), Ge(2U)) << file;
      if (num_threads == 1) first = *found;
      ASSERT_EQ(found->size(), first.size());
      for (std::size_t i = 0; i < first.size(); ++i) {
        EXPECT_EQ((*found)[i].label, first[i].label);
        EXPECT_EQ((*found)[i].score, first[i].score);
        EXPECT_EQ((*found)[i].box_px, first[i].box_px);
        EXPECT_EQ((*found)[i].mask, first[i].mask);
      }
    }
    EXPECT_EQ(first[0].mask.empty(), std::string(file) != "yolo11n-seg.onnx");
  }
}

// Every detection of some certainty is among the others, with nearly the same box.
void ExpectAmong(const std::vector<detect::RawDetection>& some,
                 const std::vector<detect::RawDetection>& others) {
  for (const detect::RawDetection& one : some) {
    if (one.score < 0.5) continue;
    EXPECT_TRUE(std::any_of(others.begin(),
                            others.end(),
                            [&](const auto& other) {
                              return other.label == one.label &&
                                     IntersectionOverUnion(other.box_px, one.box_px) > 0.85;
                            }))
        << one.label << " " << one.score;
  }
}

TEST(FrontEnd, DetectsTheSameWithoutPadding) {
  DEEPSLAM_REQUIRE_TEST_DATA(data);
  const auto capture = layouts::OpenCapture(data / "data/redkitchen");
  ASSERT_TRUE(capture.ok()) << capture.error().message;
  for (const char* file : {"yolov8n.onnx", "yolov8s.onnx", "yolo11n.onnx", "yolo11n-seg.onnx"}) {
    const auto weights = WeightBytes(file);
    ASSERT_TRUE(weights) << "scripts/setup.sh installs " << file;
    const detect::Sides picture = {640, 480};
    detect::DetectorOptions images;
    images.images = picture;
    const auto fitted = detect::FittedNetwork(*weights, picture);
    EXPECT_EQ(fitted.has_value(), std::string(file) != "yolo11n.onnx") << "its sides are open";
    const auto padded = detect::LoadNetworkDetector(*weights, {});
    const auto bare = detect::LoadNetworkDetector(*weights, images);
    ASSERT_TRUE(padded.ok() && bare.ok());
    if (fitted.has_value()) {
      EXPECT_TRUE(detect::LoadNetworkDetector(*fitted, {}).ok()) << file;
    }
    for (const int frame : {100, 250, 400}) {
      SCOPED_TRACE(std::string(file) + ", frame " + std::to_string(frame));
      const ColourImage colour = capture->frames->Read({frame})->colour;
      const auto with = (*padded)->Detect(colour);
      const auto without = (*bare)->Detect(colour);
      ASSERT_TRUE(with.ok() && without.ok());
      ASSERT_THAT(*with, SizeIs(Ge(2U)));
      ExpectAmong(*with, *without);
      ExpectAmong(*without, *with);
      for (const detect::RawDetection& detection : *without)
        EXPECT_EQ(detection.mask.empty(), std::string(file) != "yolo11n-seg.onnx");
    }
  }
}

}  // namespace
}  // namespace deepslam

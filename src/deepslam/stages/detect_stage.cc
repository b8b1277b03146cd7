// detect: boxes from a network, a user's file, and depth clusters that stand on the floor.
#include <algorithm>
#include <memory>
#include <optional>
#include <set>

#include <fmt/format.h>

#include "deepslam/artifact/coco_file.h"
#include "deepslam/artifact/store.h"
#include "deepslam/core/parallel_ahead.h"
#include "deepslam/detect/detect_frame.h"
#include "deepslam/detect/detector.h"
#include "deepslam/detect/turned_detections.h"
#include "deepslam/scene/upright_turns.h"
#include "deepslam/stages/data_folder.h"
#include "deepslam/stages/plan.h"
#include "deepslam/stages/stage_inputs.h"

namespace deepslam::stages {
namespace {

using pipeline::StageContext;
using pipeline::StageSummary;

// Frames whose detections may wait for those of an earlier one.
constexpr std::size_t kAhead = 32;
// The score from which YOLO's own tools show a box. Lower than what enters the map: a picture left
// out costs little, a person shown cannot be taken back.
constexpr double kPersonScore = 0.25;

Result<std::shared_ptr<const detect::Detector>> LoadDetector(const RunInputs& inputs) {
  const Result<std::filesystem::path> file =
      FindWeights(inputs.data_folder, inputs.config.detect_stage.weights);
  if (!file.ok()) return file.error();
  if (inputs.models) return inputs.models->Detector(*file, inputs.config.network);
  Result<std::unique_ptr<detect::Detector>> detector =
      LoadDetectorFile(*file, inputs.config.network);
  if (!detector.ok()) return detector.error();
  return std::shared_ptr<const detect::Detector>(std::move(detector).value());
}

// Keyframes or all frames, and those the user's file speaks of.
std::vector<FrameIdx> FramesToLookAt(const Odometry& odometry,
                                     const DetectStageOptions& options,
                                     std::span<const Detection> given) {
  std::set<FrameIdx> wanted(odometry.keyframes.begin(), odometry.keyframes.end());
  for (const Detection& detection : given) wanted.insert(detection.frame);
  if (options.frames == "all") {
    for (const TrackedFrame& frame : odometry.frames) wanted.insert(frame.frame);
  }
  // Where a frame stands is unknown when tracking lost it: its detections could match anything.
  std::erase_if(wanted, [&](FrameIdx idx) {
    const TrackingStatus status = odometry.at(idx).status;
    return status == TrackingStatus::kLost || status == TrackingStatus::kUnreadable;
  });
  return {wanted.begin(), wanted.end()};
}

// Every frame with the name of its colour file.
std::vector<artifact::DetectedImage> AllImages(const dataset::Capture& capture) {
  const PinholeCamera& camera = capture.frames->camera();
  std::vector<artifact::DetectedImage> images;
  for (int i = 0; i < capture.frames->num_frames(); ++i) {
    const auto at = static_cast<std::size_t>(i);
    const bool named = at < capture.colour_files.size();
    images.push_back({FrameIdx{i},
                      named ? capture.colour_files[at] : fmt::format("{:06d}", i),
                      camera.width,
                      camera.height});
  }
  return images;
}

// Of the images as they lie in the capture, where frames may be smaller.
artifact::PictureSize ColourSize(const dataset::Capture& capture) {
  if (capture.stored == nullptr) return {};
  const PinholeCamera& camera = capture.stored->cameras().colour;
  return {camera.width, camera.height};
}

// The user's boxes by frame; nothing when the source is another.
Result<artifact::CocoDetections> ReadFileDetections(
    const RunInputs& inputs,
    const StageContext& context,
    std::span<const artifact::DetectedImage> images) {
  const DetectStageOptions& options = inputs.config.detect_stage;
  if (options.source != "file") return artifact::CocoDetections();
  const Result<std::string> text = artifact::ReadFile(options.file);
  if (!text.ok()) return text.error();
  Result<artifact::CocoDetections> coco = artifact::ReadCocoFile(
      *text, options.file, images, inputs.classes, ColourSize(*inputs.capture));
  if (!coco.ok()) return coco.error();
  for (const std::string& warning : coco->warnings) {
    context.progress().Warn(fmt::format("{}: {}", options.file, warning));
  }
  if (coco->detections.empty()) {
    return InvalidInput(fmt::format(
        "{}: no entry fits the capture ({} of unknown images, {} of unknown classes, {} "
        "unusable); image_id must be a frame index or name a colour file",
        options.file,
        coco->num_unknown_image,
        coco->num_unknown_class,
        coco->num_unusable));
  }
  return coco;
}

// Detections of one frame and what went wrong with it.
struct FrameDetections {
  std::vector<Detection> detections;
  std::string warning;
  std::optional<bool> contains_person = {};  // nothing when no network looked
};

bool SeesPerson(std::span<const detect::RawDetection> raw) {
  return std::any_of(raw.begin(), raw.end(), [](const detect::RawDetection& r) {
    return r.label == "person" && r.score >= kPersonScore;
  });
}

FrameDetections DetectOne(const RunInputs& inputs,
                          const detect::Detector* detector,
                          const Ground& ground,
                          const TrackedFrame& tracked,
                          QuarterTurn upright,
                          std::vector<Detection> given) {
  FrameDetections found{std::move(given), {}, {}};
  const Result<Frame> frame = inputs.capture->frames->Read(tracked.frame);
  if (!frame.ok())
    return {{}, fmt::format("frame {} skipped: {}", tracked.frame.value, frame.error().message)};
  if (detector != nullptr) {
    const Result<std::vector<detect::RawDetection>> raw =
        detect::DetectTurned(*detector, frame->colour, upright);
    if (raw.ok()) {
      found.detections = detect::MapDetections(*raw, *frame, inputs.classes, inputs.config.detect);
      found.contains_person = SeesPerson(*raw);
    } else {
      found.warning = fmt::format("frame {}: {}", tracked.frame.value, raw.error().message);
    }
  }
  const std::optional<Plane> plane =
      GroundInCamera(ground, tracked.frame, tracked.world_from_camera);
  if (inputs.config.clusters.enabled && plane) {
    std::vector<Detection> clusters = detect::DetectClustersTurned(*frame,
                                                                   inputs.capture->frames->camera(),
                                                                   *plane,
                                                                   found.detections,
                                                                   inputs.classes,
                                                                   inputs.config.clusters,
                                                                   upright);
    std::move(clusters.begin(), clusters.end(), std::back_inserter(found.detections));
  }
  return found;
}

Result<artifact::DetectionTable> DetectAll(const StageContext& context, const RunInputs& inputs) {
  const Result<Odometry> odometry = ReadOdometry(context);
  if (!odometry.ok()) return odometry.error();
  const Result<Ground> ground = ReadGround(context, "ground");
  if (!ground.ok()) return ground.error();
  Result<std::shared_ptr<const detect::Detector>> detector =
      std::shared_ptr<const detect::Detector>();
  if (inputs.config.detect_stage.source == "network") detector = LoadDetector(inputs);
  if (!detector.ok()) return detector.error();
  const std::vector<artifact::DetectedImage> images = AllImages(*inputs.capture);
  const Result<artifact::CocoDetections> from_file = ReadFileDetections(inputs, context, images);
  if (!from_file.ok()) return from_file.error();

  const std::vector<FrameIdx> wanted =
      FramesToLookAt(*odometry, inputs.config.detect_stage, from_file->detections);
  const std::vector<QuarterTurn> upright = UprightTurns(odometry->frames, *ground);
  artifact::DetectionTable table;
  std::vector<FrameDetections> found(std::min(kAhead, wanted.size()));
  const auto detect = [&](std::size_t i) {
    if (context.progress().StopRequested()) return;
    std::vector<Detection> given;
    std::copy_if(from_file->detections.begin(),
                 from_file->detections.end(),
                 std::back_inserter(given),
                 [&](const Detection& d) { return d.frame == wanted[i]; });
    found[i % kAhead] = DetectOne(inputs,
                                  detector->get(),
                                  *ground,
                                  odometry->at(wanted[i]),
                                  upright[static_cast<std::size_t>(wanted[i].value)],
                                  std::move(given));
  };
  const auto take = [&](std::size_t i) {
    if (context.progress().StopRequested()) return false;
    FrameDetections& of_frame = found[i % kAhead];
    table.images.push_back(images[static_cast<std::size_t>(wanted[i].value)]);
    table.images.back().contains_person = of_frame.contains_person;
    if (!of_frame.warning.empty()) context.progress().Warn(of_frame.warning);
    for (Detection& detection : of_frame.detections) {
      detection.id = DetectionId{static_cast<int>(table.detections.size())};
      table.detections.push_back(std::move(detection));
    }
    context.progress().Report(i + 1, wanted.size());
    return true;
  };
  ParallelAhead(wanted.size(), kAhead, detect, take);
  if (context.progress().StopRequested()) return Interrupted();
  return table;
}

}  // namespace

Result<StageSummary> RunDetect(StageContext& context, const RunInputs& inputs) {
  const Result<artifact::DetectionTable> table = DetectAll(context, inputs);
  if (!table.ok()) return table.error();
  if (Status status = WriteEncoded(
          context, "detections.json", artifact::EncodeDetections(*table, "detections.json"));
      !status.ok()) {
    return status.error();
  }
  std::map<std::string, int> per_class;
  for (const Detection& detection : table->detections) ++per_class[detection.class_name];
  StageSummary summary{
      fmt::format("{} detections in {} frames", table->detections.size(), table->images.size()),
      {{"num_detections", static_cast<double>(table->detections.size())},
       {"num_frames", static_cast<double>(table->images.size())}}};
  for (const auto& [class_name, count] : per_class)
    summary.line += fmt::format(", {} {}", count, class_name);
  return summary;
}

}  // namespace deepslam::stages

// detect: boxes from a network, a user's file, and depth clusters that stand on the floor.
#include <algorithm>
#include <iterator>
#include <map>
#include <memory>
#include <string>
#include <utility>
#include <vector>

#include <fmt/format.h>
#include <fmt/ranges.h>

#include "deepslam/artifact/coco_file.h"
#include "deepslam/class_table/class_table_yaml.h"
#include "deepslam/detect/detect_frame.h"
#include "deepslam/detect/detect_frames.h"
#include "deepslam/stages/data_folder.h"
#include "deepslam/stages/plan.h"
#include "deepslam/stages/stage_inputs.h"
#include "deepslam/storage/store.h"

namespace deepslam::stages {
namespace {

using pipeline::StageContext;
using pipeline::StageSummary;

// A file of which more than this cannot be used was hardly made for the capture.
constexpr double kDoubtfulLossShare = 0.5;

Result<std::shared_ptr<const detect::Detector>> LoadDetector(const RunInputs& inputs,
                                                             detect::Sides pictures) {
  const Result<std::filesystem::path> file =
      FindWeights(inputs.data_folder, inputs.config.detect_stage.weights);
  if (!file.ok()) return file.error();
  detect::DetectorOptions options = inputs.config.network;
  options.images = pictures;
  if (inputs.models) return inputs.models->Detector(*file, options);
  Result<std::unique_ptr<detect::Detector>> detector = LoadDetectorFile(*file, options);
  if (!detector.ok()) return detector.error();
  return std::shared_ptr<const detect::Detector>(std::move(detector).value());
}

// Every frame with the name of its colour file.
std::vector<artifact::DetectedImage> AllImages(const dataset::Capture& capture) {
  const PinholeCamera& camera = capture.frames->camera();
  std::vector<artifact::DetectedImage> images;
  for (const dataset::StoredFrame& frame : capture.stored->frames()) {
    const FrameIdx idx{static_cast<int>(images.size())};
    images.push_back({idx, frame.colour_name, camera.width, camera.height});
  }
  return images;
}

// Of the images as they lie in the capture, where frames may be smaller.
artifact::PictureSize ColourSize(const dataset::Capture& capture) {
  if (capture.stored == nullptr) return {};
  const PinholeCamera& camera = capture.stored->cameras().colour;
  return {camera.width, camera.height};
}

struct GivenDetections {
  std::vector<Detection> detections;
  std::vector<std::string> doubts;  // sentences without the file's name, which is no result
};

// A file may be of all frames of a capture of which a run takes some.
artifact::CocoLosses OfTaken(artifact::CocoLosses losses) {
  artifact::CocoLosses::Kind& elsewhere = losses.Of(artifact::CocoFault::kUnknownImage);
  losses.num_entries -= elsewhere.num_entries;
  elsewhere = {};
  return losses;
}

// The user's boxes; nothing when the source is another.
Result<GivenDetections> ReadFileDetections(const RunInputs& inputs,
                                           std::span<const artifact::DetectedImage> images,
                                           Progress& progress) {
  const DetectStageOptions& options = inputs.config.detect_stage;
  GivenDetections given;
  if (options.source != "file") return given;
  Result<artifact::CocoDetections> coco =
      artifact::ReadCocoFile([&] { return storage::OpenText(options.file); },
                             options.file,
                             images,
                             inputs.classes,
                             ColourSize(*inputs.capture));
  if (!coco.ok()) return coco.error();
  const artifact::CocoLosses& losses = coco->losses;
  std::vector<std::string> warnings = artifact::LossesAbove(0, losses);
  std::ranges::move(coco->warnings, std::back_inserter(warnings));
  for (const std::string& warning : warnings)
    progress.Warn(fmt::format("{}: {}", options.file, warning));
  if (coco->detections.empty() && losses.num_entries > 0) {
    return InvalidInput(fmt::format(
        "{}: no entry fits the capture: {}", options.file, artifact::WhyNoneFits(losses)));
  }
  for (const std::string& loss : artifact::LossesAbove(kDoubtfulLossShare, OfTaken(losses)))
    given.doubts.push_back(fmt::format("of the detections given, {}", loss));
  given.detections = std::move(coco->detections);
  return given;
}

// `labels`: of the detector; none where none looked.
void WarnOfNeverDetected(const RunInputs& inputs,
                         const std::vector<std::string>& labels,
                         Progress& progress) {
  if (labels.empty()) return;
  const ClassTable delivered = class_table::DefaultClassTable();
  for (const ObjectClass* c : detect::NeverDetected(inputs.classes, delivered, labels)) {
    progress.Warn(fmt::format(
        "{}: class \"{}\" has the labels [{}], of which the detector knows none, so that "
        "no detection is ever of that class; give it a label of the detector, or "
        "`labels: []`, which finds it by its depth alone",
        inputs.config.classes_file,
        c->name,
        fmt::join(c->detector_labels, ", ")));
  }
}

// `which`: as the option detect.frames.
Result<std::vector<FrameIdx>> FramesWanted(const detect::DetectionInputs& inputs,
                                           const std::string& which,
                                           Progress& progress) {
  std::vector<FrameIdx> wanted =
      detect::FramesToSearch(inputs.trajectory, inputs.given, which == "all");
  if (which != "new") return wanted;
  return detect::FramesOfNewSurface(inputs, wanted, progress);
}

// Numbered in the order of frames.
artifact::DetectionTable TableOf(std::vector<detect::FrameDetections> found,
                                 std::span<const artifact::DetectedImage> images) {
  artifact::DetectionTable table;
  for (detect::FrameDetections& of_frame : found) {
    table.images.push_back(images[static_cast<std::size_t>(of_frame.frame.value)]);
    table.images.back().contains_person = of_frame.contains_person;
    for (Detection& detection : of_frame.detections) {
      detection.id = DetectionId{static_cast<int>(table.detections.size())};
      table.detections.push_back(std::move(detection));
    }
  }
  return table;
}

StageSummary Summarise(const artifact::DetectionTable& table) {
  std::map<std::string, int> per_class;
  for (const Detection& detection : table.detections) ++per_class[detection.class_name];
  StageSummary summary{
      fmt::format("{} detections in {} frames", table.detections.size(), table.images.size()),
      {{"num_detections", static_cast<double>(table.detections.size())},
       {"num_frames", static_cast<double>(table.images.size())}}};
  for (const auto& [class_name, count] : per_class)
    summary.line += fmt::format(", {} {}", count, class_name);
  return summary;
}

}  // namespace

Result<StageSummary> RunDetect(StageContext& context, const RunInputs& inputs) {
  const Result<Trajectory> trajectory = ReadTrajectory(context);
  if (!trajectory.ok()) return trajectory.error();
  const Result<Ground> ground = ReadGround(context, "ground");
  if (!ground.ok()) return ground.error();
  const std::vector<artifact::DetectedImage> images = AllImages(*inputs.capture);
  const auto given = ReadFileDetections(inputs, images, context.progress());
  if (!given.ok()) return given.error();
  const Config& config = inputs.config;
  const detect::DetectionInputs looked{
      *inputs.capture->frames, *trajectory, *ground, inputs.classes, given->detections};
  const Result<std::vector<FrameIdx>> wanted =
      FramesWanted(looked, config.detect_stage.frames, context.progress());
  if (!wanted.ok()) return wanted.error();
  detect::DetectorLoader load;
  std::vector<std::string> labels;
  if (config.detect_stage.source == "network") {
    load = [&](detect::Sides pictures) {
      auto detector = LoadDetector(inputs, pictures);
      if (detector.ok()) labels = (*detector)->labels();
      return detector;
    };
  }
  Result<std::vector<detect::FrameDetections>> found = detect::DetectFrames(
      looked, *wanted, load, {config.detect, config.clusters}, context.progress());
  if (!found.ok()) return found.error();
  WarnOfNeverDetected(inputs, labels, context.progress());
  const artifact::DetectionTable table = TableOf(std::move(found).value(), images);
  const Status written = WriteFiles(
      context,
      {{"detections.json", [&] { return artifact::EncodeDetections(table, "detections.json"); }},
       {"doubts.json", [&] { return artifact::EncodeDoubts(given->doubts, "doubts.json"); }}});
  if (!written.ok()) return written.error();
  return Summarise(table);
}

}  // namespace deepslam::stages

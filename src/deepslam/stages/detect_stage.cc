// detect: boxes from a network, a user's file, and depth clusters that stand on the floor.
#include <algorithm>
#include <latch>
#include <memory>
#include <mutex>
#include <optional>
#include <set>
#include <utility>

#include <fmt/format.h>

#include "deepslam/artifact/coco_file.h"
#include "deepslam/core/parallel.h"
#include "deepslam/detect/detect_frame.h"
#include "deepslam/detect/detector.h"
#include "deepslam/detect/turned_detections.h"
#include "deepslam/scene/upright_turns.h"
#include "deepslam/stages/data_folder.h"
#include "deepslam/stages/plan.h"
#include "deepslam/stages/stage_inputs.h"
#include "deepslam/storage/store.h"

namespace deepslam::stages {
namespace {

using pipeline::StageContext;
using pipeline::StageSummary;

// Frames shown to the detector and not yet searched for clusters. The search of so many takes about
// as long as one forward pass.
constexpr std::size_t kMostBehind = 32;
// The score from which YOLO's own tools show a box. Lower than what enters the map: a picture left
// out costs little, a person shown cannot be taken back.
constexpr double kPersonScore = 0.25;

Result<std::shared_ptr<const detect::Detector>> LoadDetector(const RunInputs& inputs,
                                                             detect::Sides images) {
  const Result<std::filesystem::path> file =
      FindWeights(inputs.data_folder, inputs.config.detect_stage.weights);
  if (!file.ok()) return file.error();
  detect::DetectorOptions options = inputs.config.network;
  options.images = images;
  if (inputs.models) return inputs.models->Detector(*file, options);
  Result<std::unique_ptr<detect::Detector>> detector = LoadDetectorFile(*file, options);
  if (!detector.ok()) return detector.error();
  return std::shared_ptr<const detect::Detector>(std::move(detector).value());
}

// Keyframes or all frames, and those the user's file speaks of.
std::vector<FrameIdx> FramesToLookAt(const Trajectory& trajectory,
                                     const DetectStageOptions& options,
                                     std::span<const Detection> given) {
  std::set<FrameIdx> wanted(trajectory.keyframes.begin(), trajectory.keyframes.end());
  for (const Detection& detection : given) wanted.insert(detection.frame);
  if (options.frames == "all") {
    for (const TrackedFrame& frame : trajectory.frames) wanted.insert(frame.frame);
  }
  // Where a frame stands is unknown when tracking lost it: its detections could match anything.
  std::erase_if(wanted, [&](FrameIdx idx) {
    const TrackingStatus status = trajectory.at(idx).status;
    return status == TrackingStatus::kLost || status == TrackingStatus::kUnreadable;
  });
  return {wanted.begin(), wanted.end()};
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

// The user's boxes by frame; nothing when the source is another.
Result<artifact::CocoDetections> ReadFileDetections(
    const RunInputs& inputs,
    const StageContext& context,
    std::span<const artifact::DetectedImage> images) {
  const DetectStageOptions& options = inputs.config.detect_stage;
  if (options.source != "file") return artifact::CocoDetections();
  Result<artifact::CocoDetections> coco =
      artifact::ReadCocoFile([&] { return storage::OpenText(options.file); },
                             options.file,
                             images,
                             inputs.classes,
                             ColourSize(*inputs.capture));
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

bool SeesPerson(std::span<const detect::RawDetection> raw) {
  return std::any_of(raw.begin(), raw.end(), [](const detect::RawDetection& r) {
    return r.label == "person" && r.score >= kPersonScore;
  });
}

// What one frame's colour and depth give, and what went wrong with it.
struct FrameFinds {
  std::vector<Detection> detections;         // of the network or the user's file
  std::optional<bool> contains_person = {};  // nothing when no network looked
  std::string warning;                       // of the network
  std::optional<Error> unread_colour;
  std::optional<Error> unread_depth;
  std::optional<detect::UprightClusters> clusters;
};

// What there is to do next. A forward pass takes as long as the search for clusters in dozens of
// frames: searches fill the time in which the network is loaded, and that of threads for which no
// pass is left.
class Agenda {
 public:
  enum class Work { kLoadDetector, kLookAtColour, kLookAtDepth };

  explicit Agenda(std::size_t num_frames) : num_frames_(num_frames) {}

  [[nodiscard]] std::size_t size() const { return 1 + 2 * num_frames_; }
  // To be asked size() times, by any thread; gives the place of the frame too.
  std::pair<Work, std::size_t> Next(bool detector_loaded) {
    const std::lock_guard<std::mutex> lock(mutex_);
    if (!std::exchange(load_given_, true)) return {Work::kLoadDetector, 0};
    const bool behind = next_colour_ >= next_depth_ + kMostBehind;
    const bool colour = next_colour_ < num_frames_ && detector_loaded && !behind;
    if (colour || next_depth_ == num_frames_) return {Work::kLookAtColour, next_colour_++};
    return {Work::kLookAtDepth, next_depth_++};
  }

 private:
  std::size_t num_frames_;
  std::mutex mutex_;
  bool load_given_ = false;
  std::size_t next_colour_ = 0;
  std::size_t next_depth_ = 0;
};

// Looks at all frames, several at once.
class Lookout {
 public:
  Lookout(const StageContext& context,
          const RunInputs& inputs,
          const Trajectory& trajectory,
          const Ground& ground,
          std::span<const FrameIdx> wanted)
      : context_(context),
        inputs_(inputs),
        trajectory_(trajectory),
        ground_(ground),
        wanted_(wanted),
        upright_(UprightTurns(trajectory.frames, ground)),
        finds_(wanted.size()) {}

  // By place in `wanted`. An error is the detector's, which could not be loaded, or that the user
  // asked to stop.
  Result<std::vector<FrameFinds>> Run() {
    Agenda agenda(wanted_.size());
    ParallelFor(agenda.size(), [&](std::size_t) {
      const auto [work, place] = agenda.Next(loaded_.try_wait());
      if (work == Agenda::Work::kLoadDetector) {
        Load();
      } else if (context_.progress().StopRequested()) {
        return;
      } else if (work == Agenda::Work::kLookAtColour) {
        LookAtColour(place);
      } else {
        LookAtDepth(place);
      }
    });
    if (!detector_.ok()) return detector_.error();
    if (context_.progress().StopRequested()) return Interrupted();
    return std::move(finds_);
  }

 private:
  void Load() {
    if (inputs_.config.detect_stage.source == "network")
      detector_ = LoadDetector(inputs_, SidesShown());
    loaded_.count_down();
  }

  [[nodiscard]] QuarterTurn Upright(FrameIdx frame) const {
    return upright_[static_cast<std::size_t>(frame.value)];
  }

  // Of the pictures that the detector is shown; none where some lie on their side and some do not.
  [[nodiscard]] detect::Sides SidesShown() const {
    const PinholeCamera& camera = inputs_.capture->frames->camera();
    const auto on_its_side = [&](FrameIdx frame) { return OnItsSide(Upright(frame)); };
    const auto num_on_side = std::ranges::count_if(wanted_, on_its_side);
    if (num_on_side == 0) return {camera.width, camera.height};
    if (static_cast<std::size_t>(num_on_side) == wanted_.size())
      return {camera.height, camera.width};
    return {};
  }

  void LookAtColour(std::size_t place) {
    loaded_.wait();
    if (!detector_.ok()) return;
    FrameFinds& finds = finds_[place];
    const FrameIdx idx = wanted_[place];
    Result<Frame> frame = inputs_.capture->frames->ReadColour(idx);
    if (!frame.ok()) {
      finds.unread_colour = frame.error();
    } else if (*detector_ != nullptr) {
      const Result<std::vector<detect::RawDetection>> raw =
          detect::DetectTurned(**detector_, frame->colour, Upright(idx));
      if (raw.ok()) {
        finds.detections =
            detect::MapDetections(*raw, *frame, inputs_.classes, inputs_.config.detect);
        finds.contains_person = SeesPerson(*raw);
      } else {
        finds.warning = fmt::format("frame {}: {}", idx.value, raw.error().message);
      }
      inputs_.capture->frames->GiveBack(std::move(frame).value());
    }
    const std::lock_guard<std::mutex> lock(mutex_);
    context_.progress().Report(++num_looked_at_, wanted_.size());
    // Taking a network down takes its time, which others use.
    if (num_looked_at_ == wanted_.size()) detector_ = std::shared_ptr<const detect::Detector>();
  }

  void LookAtDepth(std::size_t place) {
    const TrackedFrame& tracked = trajectory_.at(wanted_[place]);
    const Result<Frame> frame = inputs_.capture->frames->ReadDepth(tracked.frame);
    if (!frame.ok()) {
      finds_[place].unread_depth = frame.error();
      return;
    }
    const std::optional<Plane> plane =
        GroundInCamera(ground_, tracked.frame, tracked.world_from_camera);
    if (!inputs_.config.clusters.enabled || !plane) return;
    finds_[place].clusters = detect::FindClustersTurned(*frame,
                                                        inputs_.capture->frames->camera(),
                                                        *plane,
                                                        inputs_.classes,
                                                        inputs_.config.clusters,
                                                        Upright(tracked.frame));
  }

  const StageContext& context_;
  const RunInputs& inputs_;
  const Trajectory& trajectory_;
  const Ground& ground_;
  std::span<const FrameIdx> wanted_;
  std::vector<QuarterTurn> upright_;
  std::latch loaded_{1};
  Result<std::shared_ptr<const detect::Detector>> detector_ =
      std::shared_ptr<const detect::Detector>();
  std::vector<FrameFinds> finds_;
  std::mutex mutex_;
  std::size_t num_looked_at_ = 0;
};

// Detections of one frame, those of clusters last; none where it could not be read.
std::vector<Detection> Joined(FrameFinds finds, const detect::ClusterOptions& options) {
  if (finds.unread_depth || finds.unread_colour) return {};
  std::vector<Detection> detections = std::move(finds.detections);
  if (!finds.clusters) return detections;
  std::vector<Detection> clusters =
      detect::UncoveredTurned(*std::move(finds.clusters), detections, options);
  std::move(clusters.begin(), clusters.end(), std::back_inserter(detections));
  return detections;
}

void WarnOf(const FrameFinds& finds, FrameIdx frame, Progress& progress) {
  for (const std::optional<Error>& error : {finds.unread_depth, finds.unread_colour}) {
    if (!error) continue;
    return progress.Warn(fmt::format("frame {} skipped: {}", frame.value, error->message));
  }
  if (!finds.warning.empty()) progress.Warn(finds.warning);
}

Result<artifact::DetectionTable> DetectAll(const StageContext& context, const RunInputs& inputs) {
  const Result<Trajectory> trajectory = ReadTrajectory(context);
  if (!trajectory.ok()) return trajectory.error();
  const Result<Ground> ground = ReadGround(context, "ground");
  if (!ground.ok()) return ground.error();
  const std::vector<artifact::DetectedImage> images = AllImages(*inputs.capture);
  const Result<artifact::CocoDetections> from_file = ReadFileDetections(inputs, context, images);
  if (!from_file.ok()) return from_file.error();
  const std::vector<FrameIdx> wanted =
      FramesToLookAt(*trajectory, inputs.config.detect_stage, from_file->detections);
  Result<std::vector<FrameFinds>> found =
      Lookout(context, inputs, *trajectory, *ground, wanted).Run();
  if (!found.ok()) return found.error();
  artifact::DetectionTable table;
  for (std::size_t i = 0; i < wanted.size(); ++i) {
    FrameFinds& finds = (*found)[i];
    const std::vector<Detection>& given = from_file->detections;
    finds.detections.insert(finds.detections.end(),
                            std::ranges::lower_bound(given, wanted[i], {}, &Detection::frame),
                            std::ranges::upper_bound(given, wanted[i], {}, &Detection::frame));
    table.images.push_back(images[static_cast<std::size_t>(wanted[i].value)]);
    table.images.back().contains_person = finds.contains_person;
    WarnOf(finds, wanted[i], context.progress());
    for (Detection& detection : Joined(std::move(finds), inputs.config.clusters)) {
      detection.id = DetectionId{static_cast<int>(table.detections.size())};
      table.detections.push_back(std::move(detection));
    }
  }
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

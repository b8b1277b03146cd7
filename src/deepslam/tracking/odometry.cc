#include "deepslam/tracking/odometry.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <functional>
#include <memory>
#include <optional>
#include <string_view>
#include <utility>
#include <vector>

#include "deepslam/alignment/image_pyramid.h"
#include "deepslam/core/parallel_ahead.h"
#include "deepslam/tracking/tracker.h"

namespace deepslam::tracking {

using alignment::FramePyramid;
using alignment::ReadFrame;
using alignment::ReadPyramid;

namespace {

// Frames decoded ahead of the alignment; bounds the memory.
constexpr std::size_t kFramesAhead = 8;
constexpr int kMaxWarnings = 10;

struct PreparedFrame {
  std::shared_ptr<const FramePyramid> pyramid;  // null: unreadable
  StoredDepth depth;
  std::string fault;
};

PreparedFrame Prepare(const FrameSource& frames, FrameIdx idx, const OdometryOptions& options) {
  Result<ReadFrame> read = ReadPyramid(frames, idx, options.alignment.pyramid);
  if (!read.ok()) return {nullptr, {}, read.error().message};
  return {
      std::make_shared<const FramePyramid>(std::move(read->pyramid)), std::move(read->depth), {}};
}

class FaultCount {
 public:
  void Add(FrameIdx frame, const std::string& fault, Progress& progress) {
    if (count_ == 0) first_ = fault;
    ++count_;
    if (count_ <= kMaxWarnings) {
      progress.Warn("frame " + std::to_string(frame.value) + " skipped: " + fault);
    } else if (count_ == kMaxWarnings + 1) {
      progress.Warn("more unreadable frames; no further warnings about them");
    }
  }
  [[nodiscard]] int count() const { return count_; }
  [[nodiscard]] const std::string& first() const { return first_; }

 private:
  int count_ = 0;
  std::string first_;
};

// Aligns frames in their order while the next ones are decoded.
class Pipeline {
 public:
  Pipeline(const FrameSource& frames,
           const OdometryOptions& options,
           Progress& progress,
           const std::function<void(ReadKeyframe)>& take)
      : frames_(frames), options_(options), progress_(progress), take_(take), tracker_(options) {}

  Result<Odometry> Run() {
    const std::size_t num_frames = static_cast<std::size_t>(frames_.num_frames());
    std::array<PreparedFrame, kFramesAhead> prepared;
    bool interrupted = false;
    ParallelAhead(
        num_frames,
        kFramesAhead,
        [&](std::size_t k) { prepared[k % kFramesAhead] = Prepare(frames_, IdxOf(k), options_); },
        [&](std::size_t k) {
          Align(IdxOf(k), std::exchange(prepared[k % kFramesAhead], {}));
          if (k % kFramesAhead == 0) progress_.Report(k, num_frames);
          interrupted = progress_.StopRequested();
          return !interrupted;
        });
    if (interrupted) return Interrupted();
    progress_.Report(num_frames, num_frames);
    return Conclude(num_frames);
  }

 private:
  static FrameIdx IdxOf(std::size_t k) { return FrameIdx{static_cast<std::int32_t>(k)}; }

  void Align(FrameIdx frame, PreparedFrame prepared) {
    if (prepared.pyramid == nullptr) faults_.Add(frame, prepared.fault, progress_);
    tracker_.Add(frame, frames_.time_s(frame), prepared.pyramid);
    if (take_) HandOver(frame, std::move(prepared));
  }

  // Whether a frame is a keyframe is known with the next one at the latest, but for a few.
  void HandOver(FrameIdx frame, PreparedFrame prepared) {
    GiveIfKeyframe();
    last_ = frame;
    last_prepared_ = std::move(prepared);
    GiveIfKeyframe();
  }
  void GiveIfKeyframe() {
    if (!last_prepared_.pyramid || tracker_.newest_keyframe() != last_) return;
    PreparedFrame keyframe = std::exchange(last_prepared_, {});
    take_({last_, std::move(keyframe.pyramid), std::move(keyframe.depth).TakeMetres()});
  }

  Result<Odometry> Conclude(std::size_t num_frames) {
    const std::size_t num_bad = static_cast<std::size_t>(faults_.count());
    if (2 * num_bad > num_frames) {
      return InvalidInput(std::to_string(num_bad) + " of " + std::to_string(num_frames) +
                          " frames could not be read; the first: " + faults_.first());
    }
    Odometry odometry = std::move(tracker_).Finish();
    if (odometry.keyframes.empty()) {
      return InvalidInput("no frame has usable depth (" +
                          std::to_string(options_.alignment.pyramid.min_depth_m) + " to " +
                          std::to_string(options_.alignment.pyramid.max_depth_m) +
                          " m); check the depth images and depth_units_per_m in capture.yaml");
    }
    return odometry;
  }

  const FrameSource& frames_;
  const OdometryOptions& options_;
  Progress& progress_;
  const std::function<void(ReadKeyframe)>& take_;
  Tracker tracker_;
  FrameIdx last_;                // aligned last, and what it was made of while it may still become
  PreparedFrame last_prepared_;  // a keyframe
  FaultCount faults_;
};

}  // namespace

Result<Odometry> EstimateOdometry(const FrameSource& frames,
                                  const OdometryOptions& options,
                                  Progress& progress,
                                  const std::function<void(ReadKeyframe)>& take) {
  if (frames.num_frames() <= 0) return InvalidInput("the capture has no frames");
  return Pipeline(frames, options, progress, take).Run();
}

void Describe(OptionsVisitor& visitor, OdometryOptions& options) {
  static constexpr std::array<std::string_view, 2> kReferences = {"keyframe", "previous"};
  Describe(visitor, options.alignment);
  visitor.Choice("reference", options.reference, kReferences, "what a frame is aligned to");
  visitor.Field("motion_prediction", options.motion_prediction, "start from constant velocity too");
  visitor.Field(
      "rotation_search", options.rotation_search, "start from an image-based rotation too");
  visitor.Field(
      "wide_search", options.wide_search, "more starts, turns about the scene, where doubtful");
  visitor.Field(
      "skip_edges", options.skip_edges, "join each keyframe to the one before the last as well");
  visitor.Field("keyframe_distance_m",
                options.keyframe_distance_m,
                {0.005, 10},
                "m",
                "a new keyframe beyond this distance");
  visitor.Field("keyframe_angle_deg",
                options.keyframe_angle_deg,
                {0.5, 180},
                "deg",
                "a new keyframe beyond this angle");
  visitor.Field("keyframe_min_overlap",
                options.keyframe_min_overlap,
                {0, 1},
                "1",
                "a new keyframe below this overlap");
  visitor.Field("num_relocalisation_keyframes",
                options.num_relocalisation_keyframes,
                {2, 200},
                "1",
                "last keyframes kept to find the way back after a loss");
  visitor.Field("min_valid_share",
                options.min_valid_share,
                {0.001, 1},
                "1",
                "a frame with less usable depth is not aligned");
  visitor.Field("lost_translation_m",
                options.lost_translation_m,
                {0.001, 100},
                "m",
                "standard deviation of an edge across a loss");
  visitor.Field("lost_rotation_deg",
                options.lost_rotation_deg,
                {0.01, 180},
                "deg",
                "standard deviation of an edge across a loss");
  visitor.Field("capture_translation_m",
                options.capture_translation_m,
                {1e-6, 10},
                "m",
                "standard deviation of relative poses that came with the capture");
  visitor.Field("capture_rotation_deg",
                options.capture_rotation_deg,
                {1e-4, 180},
                "deg",
                "standard deviation of relative poses that came with the capture");
}

}  // namespace deepslam::tracking

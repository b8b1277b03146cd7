#include "deepslam/tracking/odometry.h"

#include <array>
#include <cstddef>
#include <cstdint>
#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <utility>

#include "deepslam/alignment/image_pyramid.h"
#include "deepslam/core/parallel_ahead.h"
#include "deepslam/tracking/tracker.h"

namespace deepslam::tracking {

using alignment::ReadFrame;
using alignment::ReadPyramid;

namespace {

// Frames decoded ahead of the alignment; bounds the memory.
constexpr std::size_t kFramesAhead = 8;
constexpr int kMaxWarnings = 10;  // one a frame: more tell nothing new

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
           const std::function<void(ReadKeyframe)>& take,
           const OtherPlaces& others)
      : frames_(frames),
        options_(options),
        progress_(progress),
        take_(take),
        recorded_(others.recorded),
        tracker_(options, others.features) {}

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
    tracker_.Add(frame,
                 frames_.time_s(frame),
                 prepared.pyramid,
                 recorded_ ? recorded_(frame) : std::nullopt);
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
  const RecordedPoses& recorded_;
  Tracker tracker_;
  FrameIdx last_;                // aligned last, and what it was made of while it may still become
  PreparedFrame last_prepared_;  // a keyframe
  FaultCount faults_;
};

}  // namespace

Result<Odometry> EstimateOdometry(const FrameSource& frames,
                                  const OdometryOptions& options,
                                  Progress& progress,
                                  const std::function<void(ReadKeyframe)>& take,
                                  const OtherPlaces& others) {
  if (frames.num_frames() <= 0) return InvalidInput("the capture has no frames");
  return Pipeline(frames, options, progress, take, others).Run();
}

}  // namespace deepslam::tracking

#include "deepslam/detect/detect_frames.h"

#include <algorithm>
#include <cmath>
#include <iterator>
#include <latch>
#include <mutex>
#include <optional>
#include <set>
#include <string>
#include <utility>

#include <fmt/format.h>

#include "deepslam/core/parallel.h"
#include "deepslam/detect/new_surface.h"
#include "deepslam/detect/sharpness.h"
#include "deepslam/detect/turned_detections.h"
#include "deepslam/scene/upright_turns.h"

namespace deepslam::detect {
namespace {

// Frames shown to the detector and not yet searched for clusters. The search of so many takes about
// as long as one forward pass.
constexpr std::size_t kMostBehind = 32;
// The score from which YOLO's own tools show a box. Lower than what enters the map: a picture left
// out costs little, a person shown cannot be taken back.
constexpr double kPersonScore = 0.25;

bool SeesPerson(std::span<const RawDetection> raw) {
  return std::ranges::any_of(
      raw, [](const RawDetection& r) { return r.label == "person" && r.score >= kPersonScore; });
}

// What one frame's colour and depth give, and what went wrong with it.
struct FrameFinds {
  std::vector<Detection> detections;  // the detector's
  std::optional<bool> contains_person = {};
  std::string warning;  // of the detector
  std::optional<Error> unread_colour;
  std::optional<Error> unread_depth;
  std::optional<UprightClusters> clusters;
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
class FrameSearch {
 public:
  FrameSearch(const DetectionInputs& inputs,
              std::span<const FrameIdx> wanted,
              const DetectorLoader& load,
              const DetectFramesOptions& options,
              Progress& progress)
      : inputs_(inputs),
        wanted_(wanted),
        load_(load),
        options_(options),
        progress_(progress),
        upright_(UprightTurns(inputs.trajectory.frames, inputs.ground)),
        finds_(wanted.size()) {}

  // By place in `wanted`.
  Result<std::vector<FrameFinds>> Run() {
    Agenda agenda(wanted_.size());
    ParallelFor(agenda.size(), [&](std::size_t) {
      const auto [work, place] = agenda.Next(loaded_.try_wait());
      if (work == Agenda::Work::kLoadDetector) {
        Load();
      } else if (progress_.StopRequested()) {
        return;
      } else if (work == Agenda::Work::kLookAtColour) {
        LookAtColour(place);
      } else {
        LookAtDepth(place);
      }
    });
    if (!detector_.ok()) return detector_.error();
    if (progress_.StopRequested()) return Interrupted();
    return std::move(finds_);
  }

 private:
  void Load() {
    if (load_) detector_ = load_(SidesShown());
    loaded_.count_down();
  }

  [[nodiscard]] QuarterTurn Upright(FrameIdx frame) const {
    return upright_[static_cast<std::size_t>(frame.value)];
  }

  // Of the pictures that the detector is shown; none where some lie on their side and some do not.
  [[nodiscard]] Sides SidesShown() const {
    const PinholeCamera& camera = inputs_.frames.camera();
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
    Result<Frame> frame = inputs_.frames.ReadColour(wanted_[place]);
    if (!frame.ok()) {
      finds_[place].unread_colour = frame.error();
    } else if (*detector_ != nullptr) {
      Detect(**detector_, *frame, wanted_[place], finds_[place]);
      inputs_.frames.GiveBack(std::move(frame).value());
    }
    const std::lock_guard<std::mutex> lock(mutex_);
    progress_.Report(++num_looked_at_, wanted_.size());
    // Taking a network down takes its time, which others use.
    if (num_looked_at_ == wanted_.size()) detector_ = std::shared_ptr<const Detector>();
  }

  void Detect(const Detector& detector, const Frame& frame, FrameIdx idx, FrameFinds& finds) const {
    const Result<std::vector<RawDetection>> raw =
        DetectTurned(detector, frame.colour, Upright(idx));
    if (raw.ok()) {
      finds.detections = MapDetections(*raw, frame, inputs_.classes, options_.detect);
      finds.contains_person = SeesPerson(*raw);
    } else {
      finds.warning = fmt::format("frame {}: {}", idx.value, raw.error().message);
    }
  }

  void LookAtDepth(std::size_t place) {
    const TrackedFrame& tracked = inputs_.trajectory.at(wanted_[place]);
    const Result<Frame> frame = inputs_.frames.ReadDepth(tracked.frame);
    if (!frame.ok()) {
      finds_[place].unread_depth = frame.error();
      return;
    }
    const std::optional<Plane> plane =
        GroundInCamera(inputs_.ground, tracked.frame, tracked.world_from_camera);
    if (!options_.clusters.enabled || !plane) return;
    finds_[place].clusters = FindClustersTurned(*frame,
                                                inputs_.frames.camera(),
                                                *plane,
                                                inputs_.classes,
                                                options_.clusters,
                                                Upright(tracked.frame));
  }

  const DetectionInputs& inputs_;
  std::span<const FrameIdx> wanted_;
  const DetectorLoader& load_;
  const DetectFramesOptions& options_;
  Progress& progress_;
  std::vector<QuarterTurn> upright_;
  std::latch loaded_{1};
  Result<std::shared_ptr<const Detector>> detector_ = std::shared_ptr<const Detector>();
  std::vector<FrameFinds> finds_;
  std::mutex mutex_;
  std::size_t num_looked_at_ = 0;
};

void WarnOf(const FrameFinds& finds, FrameIdx frame, Progress& progress) {
  for (const std::optional<Error>& error : {finds.unread_depth, finds.unread_colour}) {
    if (!error) continue;
    return progress.Warn(fmt::format("frame {} skipped: {}", frame.value, error->message));
  }
  if (!finds.warning.empty()) progress.Warn(finds.warning);
}

// To either side of a frame that is to be looked at: a hand that shakes comes to rest within it
// while the view stays.
constexpr double kSharpestReachS = 0.15;
// A picture is blurred where one beside it is sharper by this factor.
constexpr double kBlurred = 1.5;
// Of the pictures' sides: noise of single pixels counts for little, motion blur of two and more is
// seen.
constexpr int kSharpnessReduction = 2;

// The frames at most kSharpestReachS away from frames[k] that are nearer to it than to its
// neighbours.
std::vector<FrameIdx> Beside(std::span<const FrameIdx> frames,
                             std::size_t k,
                             const DetectionInputs& inputs) {
  const int middle = frames[k].value;
  const double time_s = inputs.frames.time_s(frames[k]);
  const int first = k > 0 ? (frames[k - 1].value + middle) / 2 + 1 : 0;
  const int last = k + 1 < frames.size() ? (middle + frames[k + 1].value - 1) / 2
                                         : inputs.frames.num_frames() - 1;
  std::vector<FrameIdx> beside;
  const auto take = [&](FrameIdx frame) {
    if (std::abs(inputs.frames.time_s(frame) - time_s) > kSharpestReachS) return false;
    if (IsAligned(inputs.trajectory.at(frame)) && ApartAt(inputs.ground, frame) == nullptr)
      beside.push_back(frame);
    return true;
  };
  for (int value = middle - 1; value >= first && take(FrameIdx{value}); --value) {
  }
  for (int value = middle + 1; value <= last && take(FrameIdx{value}); ++value) {
  }
  return beside;
}

// The sharpest of them, the nearest of equal ones; none where frames[k] is not blurred beside it,
// or its picture cannot be read.
std::optional<FrameIdx> SharperBeside(std::span<const FrameIdx> frames,
                                      std::size_t k,
                                      const DetectionInputs& inputs) {
  const auto sharpness_of = [&](FrameIdx frame) {
    const Result<IntensityImage> intensity =
        inputs.frames.ReadIntensity(frame, kSharpnessReduction);
    return intensity.ok() ? Sharpness(*intensity) : 0;
  };
  double most = kBlurred * sharpness_of(frames[k]);
  if (most == 0) return std::nullopt;
  std::optional<FrameIdx> sharpest;
  for (const FrameIdx frame : Beside(frames, k, inputs)) {
    const double sharpness = sharpness_of(frame);
    if (sharpness <= most) continue;
    most = sharpness;
    sharpest = frame;
  }
  return sharpest;
}

bool IsGiven(const DetectionInputs& inputs, FrameIdx frame) {
  return std::ranges::binary_search(inputs.given, frame, {}, &Detection::frame);
}

// `frames` with those that are sharper beside them; ascending.
std::vector<FrameIdx> WithSharper(std::vector<FrameIdx> frames,
                                  const DetectionInputs& inputs,
                                  const Progress& progress) {
  std::vector<std::optional<FrameIdx>> sharper(frames.size());
  ParallelFor(frames.size(), [&](std::size_t k) {
    if (progress.StopRequested() || IsGiven(inputs, frames[k]) ||
        ApartAt(inputs.ground, frames[k]) != nullptr)
      return;
    sharper[k] = SharperBeside(frames, k, inputs);
  });
  for (const std::optional<FrameIdx>& frame : sharper) {
    if (frame) frames.push_back(*frame);
  }
  std::ranges::sort(frames);
  return frames;
}

// Detections of one frame, with those given for it.
std::vector<Detection> Joined(FrameFinds finds, FrameIdx frame, std::span<const Detection> given) {
  if (finds.unread_depth || finds.unread_colour) return {};
  std::vector<Detection> detections = std::move(finds.detections);
  detections.insert(detections.end(),
                    std::ranges::lower_bound(given, frame, {}, &Detection::frame),
                    std::ranges::upper_bound(given, frame, {}, &Detection::frame));
  if (!finds.clusters) return detections;
  std::vector<Detection> clusters = UncoveredTurned(*std::move(finds.clusters), detections);
  std::ranges::move(clusters, std::back_inserter(detections));
  return detections;
}

}  // namespace

std::vector<FrameIdx> FramesToSearch(const Trajectory& trajectory,
                                     std::span<const Detection> given,
                                     bool all) {
  std::set<FrameIdx> wanted(trajectory.keyframes.begin(), trajectory.keyframes.end());
  for (const Detection& detection : given) wanted.insert(detection.frame);
  if (all) {
    for (const TrackedFrame& frame : trajectory.frames) wanted.insert(frame.frame);
  }
  std::erase_if(wanted, [&](FrameIdx frame) { return !IsAligned(trajectory.at(frame)); });
  return {wanted.begin(), wanted.end()};
}

Result<std::vector<FrameIdx>> FramesOfNewSurface(const DetectionInputs& inputs,
                                                 std::span<const FrameIdx> wanted,
                                                 Progress& progress) {
  if (!inputs.ground.plane_world) return std::vector(wanted.begin(), wanted.end());
  std::vector<std::vector<SeenCell>> cells(wanted.size());
  ParallelFor(wanted.size(), [&](std::size_t k) {
    if (progress.StopRequested() || ApartAt(inputs.ground, wanted[k]) != nullptr) return;
    Result<Frame> frame = inputs.frames.ReadDepth(wanted[k]);
    if (!frame.ok()) return;
    const Pose3& world_from_camera = inputs.trajectory.at(wanted[k]).world_from_camera;
    cells[k] = SeenCells(frame->depth_m, inputs.frames.camera(), world_from_camera);
    inputs.frames.GiveBack(std::move(frame).value());
  });
  if (progress.StopRequested()) return Interrupted();
  const std::vector<bool> show_new = ShowNewSurface(cells);
  std::vector<FrameIdx> frames;
  for (std::size_t k = 0; k < wanted.size(); ++k) {
    if (show_new[k] || IsGiven(inputs, wanted[k])) frames.push_back(wanted[k]);
  }
  frames = WithSharper(std::move(frames), inputs, progress);
  if (progress.StopRequested()) return Interrupted();
  return frames;
}

Result<std::vector<FrameDetections>> DetectFrames(const DetectionInputs& inputs,
                                                  std::span<const FrameIdx> wanted,
                                                  const DetectorLoader& load,
                                                  const DetectFramesOptions& options,
                                                  Progress& progress) {
  Result<std::vector<FrameFinds>> found =
      FrameSearch(inputs, wanted, load, options, progress).Run();
  if (!found.ok()) return found.error();
  std::vector<FrameDetections> detections;
  for (std::size_t k = 0; k < wanted.size(); ++k) {
    FrameFinds& finds = (*found)[k];
    WarnOf(finds, wanted[k], progress);
    const std::optional<bool> contains_person = finds.contains_person;
    detections.push_back(
        {wanted[k], Joined(std::move(finds), wanted[k], inputs.given), contains_person});
  }
  return detections;
}

}  // namespace deepslam::detect

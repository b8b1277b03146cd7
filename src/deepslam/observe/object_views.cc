#include "deepslam/observe/object_views.h"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <optional>
#include <string>
#include <utility>

#include "deepslam/core/angles.h"
#include "deepslam/core/parallel.h"

namespace deepslam::observe {
namespace {

// What a view that repeats the direction of a chosen one is still worth: more measurement, no new
// side.
constexpr double kRepeatWorth = 0.2;
constexpr std::size_t kBatchFrames = 8;  // frames held at once

struct Candidate {
  const Segment* segment = nullptr;
  Eigen::Vector3d place_world = Eigen::Vector3d::Zero();  // middle of the segment's extent
  Eigen::Vector3d camera_world = Eigen::Vector3d::Zero();
  double worth = 0;  // by score and size alone
  bool chosen = false;
};

std::vector<Candidate> CandidatesOf(const ObjectTrack& track,
                                    const std::map<DetectionId, const Segment*>& segments,
                                    const Trajectory& trajectory) {
  std::vector<Candidate> candidates;
  int largest = 1;
  for (const TrackMember& member : track.members) {
    const auto found = segments.find(member.detection);
    if (found == segments.end()) continue;
    const Segment& segment = *found->second;
    if (segment.frame.value < 0 || segment.extent_camera.empty() ||
        segment.frame.value >= static_cast<int>(trajectory.frames.size())) {
      continue;
    }
    const Pose3& world_from_camera = trajectory.at(segment.frame).world_from_camera;
    candidates.push_back({&segment,
                          world_from_camera * segment.extent_camera.Center(),
                          world_from_camera.translation_m,
                          0,
                          false});
    largest = std::max(largest, segment.num_points);
  }
  for (Candidate& candidate : candidates) {
    const Segment& segment = *candidate.segment;
    candidate.worth = segment.score * std::sqrt(static_cast<double>(segment.num_points) / largest) *
                      (segment.touches_border ? ViewOptions::kBorderPenalty : 1.0);
  }
  return candidates;
}

double AngleBetween(const Eigen::Vector3d& a, const Eigen::Vector3d& b) {
  return std::atan2(a.cross(b).norm(), a.dot(b));
}

// Greedy: the next view is the one worth most after a discount for directions that are chosen
// already.
void ChooseViews(std::vector<Candidate>& candidates, const ViewOptions& options) {
  Eigen::Vector3d middle = Eigen::Vector3d::Zero();
  for (const Candidate& c : candidates) {
    middle += c.place_world / static_cast<double>(candidates.size());
  }
  const double spread_rad = options.spread_deg * kRadPerDeg;
  std::vector<double> nearest_rad(candidates.size(), std::numbers::pi);
  for (int k = 0; k < options.max_views; ++k) {
    std::size_t best = candidates.size();
    double best_worth = -1;
    for (std::size_t i = 0; i < candidates.size(); ++i) {
      if (candidates[i].chosen) continue;
      const double novelty = std::min(1.0, nearest_rad[i] / spread_rad);
      const double worth = candidates[i].worth * (kRepeatWorth + (1 - kRepeatWorth) * novelty);
      if (worth > best_worth) {
        best = i;
        best_worth = worth;
      }
    }
    if (best == candidates.size()) return;
    candidates[best].chosen = true;
    const Eigen::Vector3d direction = candidates[best].camera_world - middle;
    for (std::size_t i = 0; i < candidates.size(); ++i) {
      nearest_rad[i] =
          std::min(nearest_rad[i], AngleBetween(candidates[i].camera_world - middle, direction));
    }
  }
}

template <typename T>
Image<T> Crop(const Image<T>& image, int u0, int v0, int width, int height) {
  Image<T> crop(width, height);
  for (int v = 0; v < height; ++v)
    std::copy_n(image.row(v0 + v) + u0, static_cast<std::size_t>(width), crop.row(v));
  return crop;
}

// The pixels of the mask that have depth, in the window of the depth crop.
Mask Measured(const PixelMask& pixels, int u0, int v0, const DepthImage& depth_crop_m) {
  const Mask mask = pixels.Unpacked();
  Mask measured(depth_crop_m.width(), depth_crop_m.height());
  for (int v = 0; v < measured.height(); ++v) {
    for (int u = 0; u < measured.width(); ++u)
      measured(u, v) = depth_crop_m(u, v) > 0 ? mask(u0 + u, v0 + v) : std::uint8_t{0};
  }
  return measured;
}

// A window of the image's pixels; no size when the segment's box lies outside.
struct Window {
  int u0 = 0;
  int v0 = 0;
  int width = 0;
  int height = 0;
};

Window WindowOf(const Segment& segment, int width, int height) {
  const Box2& box = segment.box_px;
  const double margin = ViewOptions::kCropMargin * std::max(box.width_px(), box.height_px());
  const Box2 wide =
      Intersection({box.u_min - margin, box.v_min - margin, box.u_max + margin, box.v_max + margin},
                   {0, 0, width - 1.0, height - 1.0});
  if (box.empty() || wide.empty()) return {};
  Window window;
  window.u0 = static_cast<int>(std::floor(wide.u_min));
  window.v0 = static_cast<int>(std::floor(wide.v_min));
  window.width = static_cast<int>(std::ceil(wide.u_max)) - window.u0 + 1;
  window.height = static_cast<int>(std::ceil(wide.v_max)) - window.v0 + 1;
  return window;
}

// Nothing when the images do not fit each other or the box lies outside. Colour is cut where the
// frame has it.
std::optional<ObjectView> CutView(const Frame& frame,
                                  const PinholeCamera& camera,
                                  const Segment& segment,
                                  ViewContent content) {
  const int width = frame.depth_m.width();
  const int height = frame.depth_m.height();
  const bool with_colour = content == ViewContent::kColourAndDepth;
  if ((with_colour && (frame.colour.width() != width || frame.colour.height() != height)) ||
      segment.mask.width() != width || segment.mask.height() != height) {
    return std::nullopt;
  }
  const Window window = WindowOf(segment, width, height);
  if (window.width <= 0 || window.height <= 0) return std::nullopt;
  ObjectView view;
  view.detection = segment.detection;
  view.frame = segment.frame;
  view.detection_score = segment.score;
  view.touches_border = segment.touches_border;
  view.u0 = window.u0;
  view.v0 = window.v0;
  if (with_colour) {
    view.colour_crop = Crop(frame.colour, window.u0, window.v0, window.width, window.height);
  }
  view.depth_crop_m = Crop(frame.depth_m, window.u0, window.v0, window.width, window.height);
  view.mask_crop = Measured(segment.mask, window.u0, window.v0, view.depth_crop_m);
  view.camera = camera;
  view.camera.width = window.width;
  view.camera.height = window.height;
  view.camera.cx -= window.u0;
  view.camera.cy -= window.v0;
  return view;
}

struct Job {
  ObjectId object;
  const Segment* segment = nullptr;
};

// The views of one frame, in the order of its jobs.
struct FrameViews {
  std::vector<std::optional<ObjectView>> views;
  std::string fault;
};

}  // namespace

void Describe(OptionsVisitor& visitor, ViewOptions& options) {
  visitor.Field("max_views", options.max_views, {1, 1000}, "1", "views per object");
}

ViewPlan PlanObjectViews(const Trajectory& trajectory,
                         std::span<const Segment> segments,
                         std::span<const ObjectTrack> tracks,
                         const ViewOptions& options) {
  std::map<DetectionId, const Segment*> by_detection;
  for (const Segment& segment : segments) by_detection.emplace(segment.detection, &segment);
  ViewPlan plan;
  for (const ObjectTrack& track : tracks) {
    std::vector<const Segment*>& chosen = plan[track.id];
    std::vector<Candidate> candidates = CandidatesOf(track, by_detection, trajectory);
    ChooseViews(candidates, options);
    for (const Candidate& candidate : candidates) {
      if (candidate.chosen) chosen.push_back(candidate.segment);
    }
    std::stable_sort(chosen.begin(), chosen.end(), [](const Segment* a, const Segment* b) {
      return a->frame < b->frame;
    });
  }
  return plan;
}

std::size_t NumBytes(std::span<const Segment* const> planned, const PinholeCamera& camera) {
  // Colour, depth, mask.
  constexpr std::size_t kPixelBytes = sizeof(Rgb8) + sizeof(float) + sizeof(std::uint8_t);
  std::size_t num_bytes = 0;
  for (const Segment* segment : planned) {
    const Window window = WindowOf(*segment, camera.width, camera.height);
    num_bytes += kPixelBytes * static_cast<std::size_t>(window.width) *
                 static_cast<std::size_t>(window.height);
  }
  return num_bytes;
}

Result<std::map<ObjectId, std::vector<ObjectView>>> CutObjectViews(const FrameSource& frames,
                                                                   const Trajectory& trajectory,
                                                                   const Ground& ground,
                                                                   const ViewPlan& plan,
                                                                   ViewContent content,
                                                                   Progress& progress) {
  std::map<ObjectId, std::vector<ObjectView>> views;
  std::map<FrameIdx, std::vector<Job>> jobs;  // so that every frame is read once
  for (const auto& [object, planned] : plan) {
    views[object];
    for (const Segment* segment : planned) jobs[segment->frame].push_back({object, segment});
  }
  const std::vector<std::pair<FrameIdx, std::vector<Job>>> by_frame(jobs.begin(), jobs.end());
  for (std::size_t begin = 0; begin < by_frame.size(); begin += kBatchFrames) {
    if (progress.StopRequested()) return Interrupted();
    std::vector<FrameViews> cut(std::min(kBatchFrames, by_frame.size() - begin));
    ParallelFor(cut.size(), [&](std::size_t n) {
      const auto& [frame_idx, of_frame] = by_frame[begin + n];
      const Result<Frame> frame = content == ViewContent::kColourAndDepth
                                      ? frames.Read(frame_idx)
                                      : frames.ReadDepth(frame_idx);
      if (!frame.ok()) {
        cut[n].fault = frame.error().message;
        return;
      }
      for (const Job& job : of_frame)
        cut[n].views.push_back(CutView(*frame, frames.camera(), *job.segment, content));
    });
    for (std::size_t n = 0; n < cut.size(); ++n) {
      const auto& [frame_idx, of_frame] = by_frame[begin + n];
      if (cut[n].views.empty()) {
        progress.Warn("views of frame " + std::to_string(frame_idx.value) +
                      " left out: " + cut[n].fault);
        continue;
      }
      const Pose3& world_from_camera = trajectory.at(frame_idx).world_from_camera;
      for (std::size_t k = 0; k < of_frame.size(); ++k) {
        std::optional<ObjectView>& view = cut[n].views[k];
        if (!view) continue;
        view->world_from_camera = world_from_camera;
        view->ground_camera = GroundInCamera(ground, frame_idx, world_from_camera);
        view->upright = ground.upright.value_or(QuarterTurn::kNone);
        views[of_frame[k].object].push_back(*std::move(view));
      }
    }
  }
  return views;
}

Result<std::map<ObjectId, std::vector<ObjectView>>> CollectObjectViews(
    const FrameSource& frames,
    const Trajectory& trajectory,
    const Ground& ground,
    std::span<const Segment> segments,
    std::span<const ObjectTrack> tracks,
    const ViewOptions& options,
    Progress& progress) {
  return CutObjectViews(frames,
                        trajectory,
                        ground,
                        PlanObjectViews(trajectory, segments, tracks, options),
                        ViewContent::kColourAndDepth,
                        progress);
}

}  // namespace deepslam::observe

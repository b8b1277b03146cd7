#include "deepslam/observe/object_views.h"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <optional>
#include <utility>

namespace deepslam::observe {
namespace {

// What a view that repeats the direction of a chosen one is still worth: more measurement, no new
// side.
constexpr double kRepeatWorth = 0.2;

struct Candidate {
  const Segment* segment = nullptr;
  Eigen::Vector3d place_world = Eigen::Vector3d::Zero();  // middle of the segment's extent
  Eigen::Vector3d camera_world = Eigen::Vector3d::Zero();
  double worth = 0;  // by score and size alone
  bool chosen = false;
};

std::vector<Candidate> CandidatesOf(const ObjectTrack& track,
                                    const std::map<DetectionId, const Segment*>& segments,
                                    const Odometry& odometry,
                                    const ViewOptions& options) {
  std::vector<Candidate> candidates;
  int largest = 1;
  for (const TrackMember& member : track.members) {
    const auto found = segments.find(member.detection);
    if (found == segments.end()) continue;
    const Segment& segment = *found->second;
    if (segment.frame.value < 0 || segment.extent_camera.empty() ||
        segment.frame.value >= static_cast<int>(odometry.frames.size())) {
      continue;
    }
    const Pose3& world_from_camera = odometry.at(segment.frame).world_from_camera;
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
                      (segment.touches_border ? options.border_penalty : 1.0);
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
  const double spread_rad = options.spread_deg * std::numbers::pi / 180.0;
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
  for (int v = 0; v < height; ++v) {
    for (int u = 0; u < width; ++u) crop(u, v) = image(u0 + u, v0 + v);
  }
  return crop;
}

std::optional<Plane> GroundAt(const Ground& ground,
                              FrameIdx frame,
                              const Pose3& world_from_camera) {
  const auto found = std::lower_bound(
      ground.observations.begin(),
      ground.observations.end(),
      frame,
      [](const GroundObservation& o, FrameIdx wanted) { return o.keyframe < wanted; });
  if (found != ground.observations.end() && found->keyframe == frame) return found->plane_camera;
  if (!ground.plane_world) return std::nullopt;
  return Transformed(world_from_camera.Inverse(), *ground.plane_world);
}

// The pixels of the mask that have depth.
Mask Measured(Mask mask, const DepthImage& depth_m) {
  for (int v = 0; v < mask.height(); ++v) {
    for (int u = 0; u < mask.width(); ++u) {
      if (!(depth_m(u, v) > 0)) mask(u, v) = 0;
    }
  }
  return mask;
}

// Nothing when the images do not fit each other or the box lies outside.
std::optional<ObjectView> CutView(const Frame& frame,
                                  const PinholeCamera& camera,
                                  const Segment& segment,
                                  const ViewOptions& options) {
  const int width = frame.depth_m.width();
  const int height = frame.depth_m.height();
  if (frame.colour.width() != width || frame.colour.height() != height ||
      segment.mask.width() != width || segment.mask.height() != height) {
    return std::nullopt;
  }
  const Box2& box = segment.box_px;
  const double margin = options.crop_margin * std::max(box.width_px(), box.height_px());
  const Box2 wide =
      Intersection({box.u_min - margin, box.v_min - margin, box.u_max + margin, box.v_max + margin},
                   {0, 0, width - 1.0, height - 1.0});
  if (box.empty() || wide.empty()) return std::nullopt;
  ObjectView view;
  view.detection = segment.detection;
  view.frame = segment.frame;
  view.detection_score = segment.score;
  view.touches_border = segment.touches_border;
  view.u0 = static_cast<int>(std::floor(wide.u_min));
  view.v0 = static_cast<int>(std::floor(wide.v_min));
  const int crop_width = static_cast<int>(std::ceil(wide.u_max)) - view.u0 + 1;
  const int crop_height = static_cast<int>(std::ceil(wide.v_max)) - view.v0 + 1;
  view.colour_crop = Crop(frame.colour, view.u0, view.v0, crop_width, crop_height);
  view.depth_crop_m = Crop(frame.depth_m, view.u0, view.v0, crop_width, crop_height);
  view.mask_crop =
      Measured(Crop(segment.mask, view.u0, view.v0, crop_width, crop_height), view.depth_crop_m);
  view.camera = camera;
  view.camera.width = crop_width;
  view.camera.height = crop_height;
  view.camera.cx -= view.u0;
  view.camera.cy -= view.v0;
  return view;
}

struct Job {
  ObjectId object;
  const Segment* segment = nullptr;
};

}  // namespace

void Describe(OptionsVisitor& visitor, ViewOptions& options) {
  visitor.Field("max_views", options.max_views, {1, 1000}, "1", "views per object");
  visitor.Field("crop_margin",
                options.crop_margin,
                {0, 2},
                "1",
                "widening of the box, share of its longer side");
  visitor.Field("spread_deg",
                options.spread_deg,
                {0.1, 180},
                "deg",
                "views closer than this in direction rank lower");
  visitor.Field("border_penalty",
                options.border_penalty,
                {0, 1},
                "1",
                "factor on the rank of views that touch the image border");
}

Result<std::map<ObjectId, std::vector<ObjectView>>> CollectObjectViews(
    const FrameSource& frames,
    const Odometry& odometry,
    const Ground& ground,
    std::span<const Segment> segments,
    std::span<const ObjectTrack> tracks,
    const ViewOptions& options,
    Progress& progress) {
  std::map<DetectionId, const Segment*> by_detection;
  for (const Segment& segment : segments) by_detection.emplace(segment.detection, &segment);
  std::map<ObjectId, std::vector<ObjectView>> views;
  std::map<FrameIdx, std::vector<Job>> jobs;  // so that every frame is read once
  for (const ObjectTrack& track : tracks) {
    views[track.id];
    std::vector<Candidate> candidates = CandidatesOf(track, by_detection, odometry, options);
    ChooseViews(candidates, options);
    for (const Candidate& candidate : candidates) {
      if (candidate.chosen) jobs[candidate.segment->frame].push_back({track.id, candidate.segment});
    }
  }
  std::size_t done = 0;
  for (const auto& [frame_idx, of_frame] : jobs) {
    if (progress.StopRequested()) return Interrupted();
    const Result<Frame> frame = frames.Read(frame_idx);
    progress.Report(++done, jobs.size());
    if (!frame.ok()) {
      progress.Warn("views of frame " + std::to_string(frame_idx.value) +
                    " left out: " + frame.error().message);
      continue;
    }
    const Pose3& world_from_camera = odometry.at(frame_idx).world_from_camera;
    for (const Job& job : of_frame) {
      std::optional<ObjectView> view = CutView(*frame, frames.camera(), *job.segment, options);
      if (!view) continue;
      view->world_from_camera = world_from_camera;
      view->ground_camera = GroundAt(ground, frame_idx, world_from_camera);
      views[job.object].push_back(std::move(*view));
    }
  }
  return views;
}

}  // namespace deepslam::observe

// A room with furniture whose shapes are voxel models, seen by a camera that comes twice: frames,
// segments, tracks and a path that drifts between the traversals, all in memory. World: z up, floor
// z = 0; the first traversal is tracked without error, so that the tracking world is the room's.
#pragma once

#include <algorithm>
#include <cmath>
#include <map>
#include <memory>
#include <numbers>
#include <set>
#include <string>
#include <utility>
#include <vector>

#include <fmt/format.h>

#include "deepslam/core/parallel.h"
#include "deepslam/core/random.h"
#include "deepslam/frames/frame_source.h"
#include "deepslam/modelling/frame_views.h"
#include "deepslam/modelling/object_options.h"
#include "deepslam/modelling/register_objects.h"
#include "deepslam/modelling/select_objects.h"
#include "deepslam/shape/render_voxels.h"
#include "support/box_world.h"
#include "support/furniture_world.h"

namespace deepslam::modelling::testing_support {

using deepslam::testing_support::Cuboid;
using deepslam::testing_support::HitCuboid;

inline constexpr int kFramesPerTraversal = 8;
inline constexpr int kSecondTraversal = 60;  // its first frame; the camera is elsewhere in between
inline constexpr int kNumFrames = kSecondTraversal + kFramesPerTraversal;

inline Pose3 Yawed(double x_m, double y_m, double yaw_rad) {
  return {Eigen::Quaterniond(Eigen::AngleAxisd(yaw_rad, Eigen::Vector3d::UnitZ())), {x_m, y_m, 0}};
}

struct Furniture {
  std::string class_name;
  VoxelGrid grid;
  double size_m = 0.9;  // longest side
  double x_m = 0;
  double y_m = 0;
  double yaw_rad = 0;
};

// Shelves and boxes along two walls: what stands around tells one place from another.
inline std::vector<Cuboid> Surroundings() {
  return {{-1, {-2.6, -3.0, 0}, {-2.4, 3.0, 2.4}},
          {-1, {-3.0, 2.4, 0}, {3.0, 2.6, 2.4}},
          {-1, {-2.4, -0.6, 0}, {-2.0, 0.4, 1.1}},
          {-1, {-2.4, 1.2, 0.9}, {-2.1, 1.9, 1.2}},
          {-1, {-1.3, 2.1, 0}, {-0.7, 2.4, 0.8}},
          {-1, {0.4, 2.0, 0.6}, {1.1, 2.4, 1.5}},
          {-1, {1.5, 2.1, 0}, {1.8, 2.4, 1.8}},
          {-1, {-2.4, -1.9, 0}, {-2.05, -1.3, 1.6}}};
}

class FurnishedRoom final : public FrameSource {
 public:
  // `drift`: second_tracked_from_true, what tracking is off by in the second traversal.
  explicit FurnishedRoom(std::vector<Furniture> furniture, const Pose3& drift = {})
      : furniture_(std::move(furniture)) {
    for (const Furniture& item : furniture_) {
      models_.emplace_back(item.grid);
      const double scale = item.size_m / kModelExtent;
      Similarity3 placed = Similarity3::From(Yawed(item.x_m, item.y_m, item.yaw_rad), scale);
      placed.translation_m.z() = -scale * models_.back().bottom();
      world_from_object_.push_back(placed);
    }
    for (int k = 0; k < kNumFrames; ++k) true_poses_.push_back(TruePose(k));
    MakePath(drift);
    seen_.resize(kNumFrames);
    ParallelFor(2 * kFramesPerTraversal, [&](std::size_t n) {
      const int k = static_cast<int>(n) % kFramesPerTraversal;
      const FrameIdx frame{static_cast<int>(n) < kFramesPerTraversal ? k : kSecondTraversal + k};
      seen_[static_cast<std::size_t>(frame.value)] = Render(frame);
    });
    ground.plane_world = Plane{Eigen::Vector3d::UnitZ(), 0};
  }

  Odometry odometry;
  Ground ground;
  std::set<int> broken;  // frames that cannot be read

  [[nodiscard]] const std::vector<Furniture>& furniture() const { return furniture_; }
  [[nodiscard]] const Similarity3& truth(std::size_t item) const {
    return world_from_object_[item];
  }
  [[nodiscard]] const Pose3& true_pose(FrameIdx frame) const {
    return true_poses_[static_cast<std::size_t>(frame.value)];
  }

  [[nodiscard]] int num_frames() const override { return kNumFrames; }
  [[nodiscard]] const PinholeCamera& camera() const override { return camera_; }
  [[nodiscard]] double time_s(FrameIdx frame) const override { return frame.value; }
  [[nodiscard]] Result<Frame> Read(FrameIdx frame) const override {
    if (broken.contains(frame.value) || Seen(frame).depth_m.empty())
      return InvalidInput("frame is broken");
    Frame read;
    read.idx = frame;
    read.depth_m = Seen(frame).depth_m;
    read.colour = ColourImage(camera_.width, camera_.height, Rgb8{120, 110, 100});
    return read;
  }
  [[nodiscard]] Result<Frame> ReadDepth(FrameIdx frame) const override { return Read(frame); }
  [[nodiscard]] Result<Frame> ReadColour(FrameIdx frame) const override { return Read(frame); }
  [[nodiscard]] std::optional<Pose3> capture_world_from_camera(FrameIdx) const override {
    return std::nullopt;
  }

  // The segment of a piece of furniture in a frame; its detection is 100 * frame + item.
  [[nodiscard]] Segment SegmentOf(std::size_t item, FrameIdx frame) const {
    const SeenRoom& seen = Seen(frame);
    Segment segment;
    segment.detection = DetectionId{100 * frame.value + static_cast<int>(item)};
    segment.frame = frame;
    segment.class_name = furniture_[item].class_name;
    segment.score = 0.8;
    segment.box_px = {1e9, 1e9, -1, -1};
    Mask mask(camera_.width, camera_.height);
    for (int v = 0; v < camera_.height; ++v) {
      for (int u = 0; u < camera_.width; ++u) {
        if (seen.item(u, v) != static_cast<int>(item)) continue;
        mask(u, v) = 1;
        ++segment.num_points;
        Box2& box = segment.box_px;
        box = {std::min<double>(box.u_min, u),
               std::min<double>(box.v_min, v),
               std::max<double>(box.u_max, u),
               std::max<double>(box.v_max, v)};
        segment.extent_camera.Extend(camera_.Unproject(u, v, seen.depth_m(u, v)));
      }
    }
    segment.mask = PixelMask(mask);
    segment.usable = segment.num_points > 100;
    return segment;
  }

 private:
  struct SeenRoom {
    DepthImage depth_m;
    Image<int> item;  // -1: the room
  };

  // Each traversal goes a quarter round the furniture, the second one on another side.
  [[nodiscard]] static Pose3 TruePose(int frame) {
    const bool second = frame >= kSecondTraversal;
    const int n = second ? frame - kSecondTraversal : std::min(frame, kFramesPerTraversal - 1);
    const double angle = (second ? -0.75 : -0.55) + 0.16 * n;
    const Eigen::Vector3d eye(2.3 * std::cos(angle), 2.3 * std::sin(angle), 1.45);
    Pose3 pose = deepslam::testing_support::LookAt(eye, {-0.1, 0.2, 0.45});
    // In between it walks away and back.
    if (!second && frame >= kFramesPerTraversal) {
      const double gone = frame - kFramesPerTraversal + 1;
      const double left = kSecondTraversal - frame;
      pose.translation_m.x() += 0.12 * std::min(gone, left);
    }
    return pose;
  }

  // Drift comes in between the traversals, evenly; odometry says what was tracked.
  void MakePath(const Pose3& drift) {
    const double yaw_rad = 2 * std::atan2(drift.rotation.z(), drift.rotation.w());
    for (int k = 0; k < kNumFrames; ++k) {
      const double share = std::clamp(
          (k - kFramesPerTraversal) / double(kSecondTraversal - kFramesPerTraversal), 0.0, 1.0);
      const Eigen::Vector3d& moved = drift.translation_m;
      const Pose3 tracked_from_true = Yawed(share * moved.x(), share * moved.y(), share * yaw_rad);
      TrackedFrame frame;
      frame.frame = FrameIdx{k};
      frame.keyframe = FrameIdx{k};
      frame.time_s = k;
      frame.world_from_camera = tracked_from_true * true_poses_[static_cast<std::size_t>(k)];
      frame.inlier_share = 0.9;
      odometry.frames.push_back(frame);
      odometry.keyframes.push_back(FrameIdx{k});
      if (k == 0) continue;
      const Pose3& before = odometry.frames[static_cast<std::size_t>(k) - 1].world_from_camera;
      RelativePose edge{
          FrameIdx{k - 1}, FrameIdx{k}, before.Inverse() * frame.world_from_camera, {}, false};
      // A centimetre and a third of a degree a step.
      edge.information = Matrix6d(Vector6d(1e4, 1e4, 1e4, 3e4, 3e4, 3e4).asDiagonal());
      odometry.edges.push_back(edge);
    }
  }

  [[nodiscard]] const SeenRoom& Seen(FrameIdx frame) const {
    return seen_[static_cast<std::size_t>(frame.value)];
  }

  [[nodiscard]] SeenRoom Render(FrameIdx frame) const {
    const Pose3& world_from_camera = true_pose(frame);
    const std::vector<Cuboid> around = Surroundings();
    SeenRoom seen{DepthImage(camera_.width, camera_.height),
                  Image<int>(camera_.width, camera_.height, -1)};
    Random random(7, "noise", static_cast<std::uint64_t>(frame.value));
    std::vector<DepthImage> items;
    for (std::size_t n = 0; n < models_.size(); ++n)
      items.push_back(shape::RenderDepth(
          models_[n], world_from_camera.Inverse() * world_from_object_[n], camera_));
    for (int v = 0; v < camera_.height; ++v) {
      for (int u = 0; u < camera_.width; ++u) {
        const Eigen::Vector3d direction = world_from_camera.rotation * camera_.Ray(u, v);
        const Eigen::Vector3d& eye = world_from_camera.translation_m;
        double depth_m = direction.z() < 0 ? -eye.z() / direction.z() : 8.0;
        for (const Cuboid& box : around) {
          if (const auto hit = HitCuboid(box, eye, direction)) depth_m = std::min(depth_m, *hit);
        }
        for (std::size_t n = 0; n < items.size(); ++n) {
          const double own = items[n](u, v);
          if (own <= 0 || own >= depth_m) continue;
          depth_m = own;
          seen.item(u, v) = static_cast<int>(n);
        }
        // A Kinect's axial noise at its best.
        if (depth_m < 8.0)
          seen.depth_m(u, v) = static_cast<float>(depth_m + 0.0015 * random.Normal());
      }
    }
    return seen;
  }

  std::vector<Furniture> furniture_;
  std::vector<shape::ShapeModel> models_;
  std::vector<Similarity3> world_from_object_;
  std::vector<Pose3> true_poses_;
  PinholeCamera camera_ = {240, 180, 180, 180, 119.5, 89.5};
  std::vector<SeenRoom> seen_;  // of the traversals; empty in between
};

class SegmentsInMemory final : public SegmentStore {
 public:
  std::vector<Segment> segments;

  [[nodiscard]] std::span<const Segment> without_masks() const override { return segments; }
  [[nodiscard]] Result<std::vector<Segment>> Of(
      const std::set<DetectionId>& wanted) const override {
    std::vector<Segment> found;
    std::ranges::copy_if(segments, std::back_inserter(found), [&](const Segment& segment) {
      return wanted.contains(segment.detection);
    });
    return found;
  }
};

class ModelsInMemory final : public ModelSource {
 public:
  std::map<std::string, VoxelGrid> grids;

  [[nodiscard]] Result<VoxelGrid> Read(CandidateSource, const std::string& key) const override {
    const auto found = grids.find(key);
    if (found == grids.end()) return InvalidInput("models/" + key + ".binvox is missing");
    return found->second;
  }
};

class StoppableProgress final : public Progress {
 public:
  void Report(std::size_t, std::size_t) override {}
  void Warn(std::string_view message) override { warnings.emplace_back(message); }
  [[nodiscard]] bool StopRequested() const override { return stop; }

  bool stop = false;
  std::vector<std::string> warnings;
};

// What is known of a room before its objects have shapes, and the sources that modelling asks.
class ModelledRoom {
 public:
  ModelledRoom(std::vector<Furniture> furniture, const Pose3& drift = {})
      : room(std::move(furniture), drift) {}

  // A track of what the camera saw of a piece of furniture in these frames, with one candidate: its
  // true shape, of a size that is nearly known.
  void Track(int id, std::size_t item, const std::vector<int>& frames) {
    const Furniture& thing = room.furniture()[item];
    ObjectTrack track{ObjectId{id}, thing.class_name, {}, "", {{thing.class_name, 1.0}}};
    for (const int frame : frames) {
      Segment segment = room.SegmentOf(item, FrameIdx{frame});
      track.members.push_back({segment.detection, segment.frame, 3, 0.01, "vote"});
      const auto known =
          std::ranges::find(segments->segments, segment.detection, &Segment::detection);
      if (known == segments->segments.end()) segments->segments.push_back(std::move(segment));
    }
    association.tracks.push_back(std::move(track));
    AddCandidate(id, fmt::format("item_{}", item), thing.grid, thing.size_m);
  }

  void AddCandidate(int object, const std::string& model, const VoxelGrid& grid, double size_m) {
    ShapeCandidate candidate = deepslam::testing_support::CandidateFor(
        0.8 * size_m, 1.25 * size_m, 0, static_cast<int>(proposals.candidates.size()));
    candidate.object = ObjectId{object};
    candidate.model = model;
    proposals.candidates.push_back(candidate);
    models.grids.emplace(model, grid);
  }

  [[nodiscard]] TrackedObjects Objects() const {
    return {association.tracks, room.odometry, room.ground};
  }
  [[nodiscard]] FrameViews Views() { return FrameViews({room, segments, classes}, {}, progress); }
  [[nodiscard]] Result<Selection> Select(const ObjectOptions& options = {}) {
    const FrameViews views = Views();
    const ObjectSources sources{views, models, prepared, progress};
    auto placed = RegisterObjects(Objects(), proposals, sources, options);
    if (!placed.ok()) return placed.error();
    registrations = std::move(placed).value();
    return SelectObjects(Objects(), {proposals, registrations}, sources, options);
  }

  FurnishedRoom room;
  ClassTable classes;
  std::shared_ptr<SegmentsInMemory> segments = std::make_shared<SegmentsInMemory>();
  ModelsInMemory models;
  PreparedModels prepared{std::size_t{1} << 28};
  StoppableProgress progress;
  Association association;
  Proposals proposals;
  std::vector<CandidateRegistration> registrations;
};

inline std::vector<int> Frames(int first, int count) {
  std::vector<int> frames;
  for (int n = 0; n < count; ++n) frames.push_back(first + n);
  return frames;
}

inline std::vector<int> Joined(std::vector<int> first, const std::vector<int>& second) {
  first.insert(first.end(), second.begin(), second.end());
  return first;
}

}  // namespace deepslam::modelling::testing_support

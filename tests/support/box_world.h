// A world of cuboids on a floor (z = 0, z up), ray cast exactly: depth and which cuboid each pixel
// shows.
#pragma once

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>
#include <optional>
#include <set>
#include <string>
#include <utility>
#include <vector>

#include <Eigen/Core>
#include <Eigen/Geometry>

#include "deepslam/frames/frame_source.h"
#include "deepslam/scene/detection.h"
#include "deepslam/scene/ground.h"
#include "deepslam/scene/trajectory.h"

namespace deepslam::testing_support {

// Sides parallel to the world's axes. `object` groups cuboids into things; -1 belongs to the room.
struct Cuboid {
  int object = -1;
  Eigen::Vector3d min_m;
  Eigen::Vector3d max_m;
};

inline PinholeCamera SmallCamera() { return {320, 240, 260, 260, 159.5, 119.5}; }

// Camera at `eye` looking at `target`, image upright.
inline Pose3 LookAt(const Eigen::Vector3d& eye, const Eigen::Vector3d& target) {
  const Eigen::Vector3d forward = (target - eye).normalized();
  const Eigen::Vector3d right = forward.cross(Eigen::Vector3d::UnitZ()).normalized();
  Eigen::Matrix3d world_from_camera;
  world_from_camera << right, forward.cross(right), forward;
  return {Eigen::Quaterniond(world_from_camera), eye};
}

inline Plane FloorIn(const Pose3& world_from_camera) {
  return Transformed(world_from_camera.Inverse(), Plane{Eigen::Vector3d::UnitZ(), 0.0});
}

struct BoxView {
  Frame frame;
  Image<int> object;  // per pixel: object, -1 = room
};

inline std::optional<double> HitCuboid(const Cuboid& box,
                                       const Eigen::Vector3d& eye,
                                       const Eigen::Vector3d& direction) {
  double near = 1e-6;
  double far = std::numeric_limits<double>::infinity();
  for (int axis = 0; axis < 3; ++axis) {
    const double inverse = 1.0 / (direction[axis] == 0 ? 1e-300 : direction[axis]);
    double a = (box.min_m[axis] - eye[axis]) * inverse;
    double b = (box.max_m[axis] - eye[axis]) * inverse;
    if (a > b) std::swap(a, b);
    near = std::max(near, a);
    far = std::min(far, b);
  }
  if (near > far) return std::nullopt;
  return near;
}

inline BoxView RenderBoxes(const std::vector<Cuboid>& world,
                           const PinholeCamera& camera,
                           const Pose3& world_from_camera,
                           FrameIdx idx = {0}) {
  BoxView view;
  view.frame.idx = idx;
  view.frame.time_s = idx.value;
  view.frame.colour = ColourImage(camera.width, camera.height, Rgb8{90, 90, 90});
  view.frame.depth_m = DepthImage(camera.width, camera.height);
  view.object = Image<int>(camera.width, camera.height, -1);
  const Eigen::Vector3d& eye = world_from_camera.translation_m;
  for (int v = 0; v < camera.height; ++v) {
    for (int u = 0; u < camera.width; ++u) {
      // Depth along the axis is the ray's parameter, since the ray has z = 1 in the camera.
      const Eigen::Vector3d direction = world_from_camera.rotation * camera.Ray(u, v);
      double nearest = direction.z() < 0 ? -eye.z() / direction.z() : 8.0;
      for (const Cuboid& box : world) {
        const std::optional<double> hit = HitCuboid(box, eye, direction);
        if (!hit || *hit >= nearest) continue;
        nearest = *hit;
        view.object(u, v) = box.object;
      }
      view.frame.depth_m(u, v) = nearest < 8.0 ? static_cast<float>(nearest) : 0.0F;
      const int shade = 60 + 50 * (view.object(u, v) + 1);
      view.frame.colour(u, v).r = static_cast<std::uint8_t>(std::min(255, shade));
    }
  }
  return view;
}

// The box around an object's visible pixels; nothing where it is not seen.
inline std::optional<Detection> DetectTruth(const BoxView& view,
                                            int object,
                                            const std::string& class_name,
                                            double score = 0.8) {
  Detection detection;
  detection.frame = view.frame.idx;
  detection.class_name = class_name;
  detection.score = score;
  Box2 box = {1e9, 1e9, -1, -1};
  for (int v = 0; v < view.object.height(); ++v) {
    for (int u = 0; u < view.object.width(); ++u) {
      if (view.object(u, v) != object) continue;
      box = {std::min<double>(box.u_min, u),
             std::min<double>(box.v_min, v),
             std::max<double>(box.u_max, u),
             std::max<double>(box.v_max, v)};
    }
  }
  if (box.empty()) return std::nullopt;
  detection.box_px = box;
  return detection;
}

inline double MaskIoU(const PixelMask& pixels, const BoxView& view, int object) {
  const Mask mask = pixels.Unpacked();
  double both = 0;
  double either = 0;
  for (int v = 0; v < mask.height(); ++v) {
    for (int u = 0; u < mask.width(); ++u) {
      const bool a = mask(u, v) != 0;
      const bool b = view.object(u, v) == object;
      both += a && b ? 1 : 0;
      either += a || b ? 1 : 0;
    }
  }
  return either > 0 ? both / either : 0.0;
}

// A table of 1.2 x 0.8 m, 0.74 m high, with four legs; centre on the floor at (x, y).
inline std::vector<Cuboid> TableAt(int object, double x, double y) {
  std::vector<Cuboid> parts = {{object, {x - 0.6, y - 0.4, 0.70}, {x + 0.6, y + 0.4, 0.74}}};
  for (const double dx : {-0.55, 0.50}) {
    for (const double dy : {-0.38, 0.33}) {
      parts.push_back({object, {x + dx, y + dy, 0}, {x + dx + 0.05, y + dy + 0.05, 0.70}});
    }
  }
  return parts;
}

// A chair 0.45 m square with a seat at 0.45 m and a back up to 0.9 m on its side towards `back_y`
// (+1 or -1).
inline std::vector<Cuboid> ChairAt(int object, double x, double y, double back_y) {
  const double half = 0.22;
  const double back = y + back_y * half;
  std::vector<Cuboid> parts = {
      {object, {x - half, y - half, 0.42}, {x + half, y + half, 0.46}},
      {object, {x - half, back - 0.02, 0.46}, {x + half, back + 0.02, 0.90}}};
  for (const double dx : {-half, half - 0.04}) {
    for (const double dy : {-half, half - 0.04}) {
      parts.push_back({object, {x + dx, y + dy, 0}, {x + dx + 0.04, y + dy + 0.04, 0.42}});
    }
  }
  return parts;
}

inline void Append(std::vector<Cuboid>& world, const std::vector<Cuboid>& parts) {
  world.insert(world.end(), parts.begin(), parts.end());
}

// Frames of one world from given poses, held in memory. Frames in `broken` cannot be read.
class BoxWorldSource final : public FrameSource {
 public:
  BoxWorldSource(const std::vector<Cuboid>& world, std::vector<Pose3> world_from_camera)
      : poses_(std::move(world_from_camera)) {
    for (std::size_t i = 0; i < poses_.size(); ++i) {
      views_.push_back(RenderBoxes(world, camera_, poses_[i], {static_cast<int>(i)}));
    }
  }

  std::set<int> broken;

  [[nodiscard]] int num_frames() const override { return static_cast<int>(poses_.size()); }
  [[nodiscard]] const PinholeCamera& camera() const override { return camera_; }
  [[nodiscard]] double time_s(FrameIdx frame) const override { return frame.value; }
  [[nodiscard]] const BoxView& View(FrameIdx frame) const {
    return views_[static_cast<std::size_t>(frame.value)];
  }
  [[nodiscard]] Result<Frame> Read(FrameIdx frame) const override {
    if (broken.count(frame.value) != 0) return InvalidInput("frame is broken");
    return View(frame).frame;
  }
  [[nodiscard]] Result<Frame> ReadDepth(FrameIdx frame) const override { return Read(frame); }
  [[nodiscard]] Result<Frame> ReadColour(FrameIdx frame) const override { return Read(frame); }
  [[nodiscard]] std::optional<Pose3> capture_world_from_camera(FrameIdx frame) const override {
    return poses_[static_cast<std::size_t>(frame.value)];
  }
  // The true poses as a tracked trajectory; every frame is a keyframe. The world is the room's, z
  // up.
  [[nodiscard]] Odometry TrueOdometry() const {
    Odometry odometry;
    for (int i = 0; i < num_frames(); ++i) {
      TrackedFrame tracked;
      tracked.frame = {i};
      tracked.keyframe = {i};
      tracked.time_s = i;
      tracked.world_from_camera = poses_[static_cast<std::size_t>(i)];
      odometry.frames.push_back(tracked);
      odometry.keyframes.push_back({i});
    }
    return odometry;
  }

 private:
  PinholeCamera camera_ = SmallCamera();
  std::vector<Pose3> poses_;
  std::vector<BoxView> views_;
};

// Poses on a circle round `target`.
inline std::vector<Pose3> Orbit(const Eigen::Vector3d& target,
                                double radius_m,
                                double height_m,
                                double start_deg,
                                double step_deg,
                                int count) {
  std::vector<Pose3> poses;
  for (int i = 0; i < count; ++i) {
    const double angle = (start_deg + step_deg * i) * std::numbers::pi / 180.0;
    const Eigen::Vector3d eye(
        target.x() + radius_m * std::cos(angle), target.y() + radius_m * std::sin(angle), height_m);
    poses.push_back(LookAt(eye, target));
  }
  return poses;
}

}  // namespace deepslam::testing_support

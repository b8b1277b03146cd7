#include "eval_unseen.h"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstdint>

#include <fmt/format.h>

#include "deepslam/core/parallel.h"
#include "deepslam/dataset/image_files.h"
#include "deepslam/eval/unseen_surface.h"
#include "deepslam/layouts/open_capture.h"
#include "eval_surfaces.h"

namespace deepslam::tools {
namespace {

constexpr double kAreaPerUnseenPointM2 =
    1e-4;                                     // what is unseen is large: as fine as a Kinect at 2 m
constexpr double kMaxTimeDifferenceS = 0.01;  // as trajectories are paired

std::vector<Eigen::Vector3d> OuterPointsWorld(const TrueObject& object) {
  const std::vector<Eigen::Vector3d> sampled = eval::SampleSurface(
      object.mesh, {}, kAreaPerUnseenPointM2, static_cast<std::uint64_t>(object.number));
  std::vector<Eigen::Vector3d> points;
  for (const Eigen::Vector3d& p : eval::OuterPoints(object.mesh, sampled))
    points.push_back(object.box.world_from_object * p);
  DropFloor(points);
  return points;
}

const TimedPose* PoseAt(const Truth& truth, double time_s) {
  const auto nearest = std::ranges::min_element(
      truth.poses, {}, [&](const TimedPose& pose) { return std::abs(pose.time_s - time_s); });
  if (nearest == truth.poses.end() || std::abs(nearest->time_s - time_s) > kMaxTimeDifferenceS)
    return nullptr;
  return &*nearest;
}

}  // namespace

Result<std::vector<std::vector<Eigen::Vector3d>>> UnseenPoints(const Truth& truth) {
  const Result<dataset::Capture> capture = layouts::OpenCapture(truth.capture);
  if (!capture.ok()) return capture.error();
  const FrameSource& frames = *capture->frames;
  std::vector<std::vector<Eigen::Vector3d>> points(truth.objects.size());
  ParallelFor(points.size(),
              [&](std::size_t n) { points[n] = OuterPointsWorld(truth.objects[n]); });
  std::vector<std::vector<bool>> seen;
  for (const auto& those : points) seen.emplace_back(those.size(), false);
  for (int i = 0; i < frames.num_frames(); ++i) {
    const FrameIdx frame{i};
    const TimedPose* pose = PoseAt(truth, frames.time_s(frame));
    if (pose == nullptr)
      return InvalidInput(
          fmt::format("{}: frame {} has no true pose within 10 ms: what was seen of the objects "
                      "cannot be told",
                      truth.capture.string(),
                      i));
    const Result<Frame> depth = frames.ReadDepth(frame);
    if (!depth.ok()) continue;  // a frame that cannot be read showed nothing to anybody
    const auto instances =
        dataset::ReadDepthFile(truth.capture / "truth" / "instances" / fmt::format("{:06d}.png", i),
                               frames.camera().width,
                               frames.camera().height);
    if (!instances.ok()) return InvalidInput("instance mask " + instances.error().message);
    const Pose3 camera_from_world = pose->world_from_camera.Inverse();
    const eval::InstanceView view{frames.camera(), camera_from_world, depth->depth_m, *instances};
    ParallelFor(points.size(), [&](std::size_t n) {
      eval::MarkSeen(view, truth.objects[n].number, points[n], seen[n]);
    });
  }
  std::vector<std::vector<Eigen::Vector3d>> unseen(points.size());
  for (std::size_t n = 0; n < points.size(); ++n) {
    for (std::size_t k = 0; k < points[n].size(); ++k) {
      if (!seen[n][k]) unseen[n].push_back(points[n][k]);
    }
  }
  return unseen;
}

}  // namespace deepslam::tools

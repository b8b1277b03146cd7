#include "deepslam/discovery/flush_with_wall.h"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <map>

#include <fmt/format.h>

#include "deepslam/geometry/depth_noise.h"

namespace deepslam::discovery {
namespace {

// What hangs on a wall and is a thing stands out of it by more: the flattest televisions by 4 cm.
constexpr double kFlush_m = 0.02;
constexpr double kNumSigmas = 2;     // and by more than its depth's noise
constexpr double kFlushShare = 0.7;  // of the points measured
constexpr int kStep_px = 3;          // a ninth of the pixels is enough to tell

struct Measured {
  std::size_t num_points = 0;
  std::size_t num_flush = 0;
};

bool IsFlush(const Eigen::Vector3d& p_level, double reach_m, const Layout& layout) {
  return std::ranges::any_of(layout.walls, [&](const LayoutWall& wall) {
    const Eigen::Vector2d along = (wall.to_m - wall.from_m).normalized();
    const Eigen::Vector2d away = p_level.head<2>() - wall.from_m;
    const double at_m = away.dot(along);
    return std::abs(along.x() * away.y() - along.y() * away.x()) < reach_m && at_m > 0 &&
           at_m < wall.length_m() && p_level.z() > wall.bottom_m && p_level.z() < wall.top_m;
  });
}

void Measure(const Segment& segment, const HungThings& things, Measured& measured) {
  const Result<Frame> frame = things.frames.ReadDepth(segment.frame);
  if (!frame.ok()) return;
  const PinholeCamera& camera = things.frames.camera();
  const Mask mask = segment.mask.Unpacked();
  const Pose3 level_from_camera =
      things.layout.level_from_tracking * things.trajectory.at(segment.frame).world_from_camera;
  for (int v = 0; v < mask.height(); v += kStep_px) {
    for (int u = 0; u < mask.width(); u += kStep_px) {
      const auto depth_m = static_cast<double>(frame->depth_m(u, v));
      if (mask(u, v) == 0 || !(depth_m > 0)) continue;
      const Eigen::Vector3d p_level = level_from_camera * camera.Unproject(u, v, depth_m);
      ++measured.num_points;
      measured.num_flush +=
          IsFlush(p_level, kFlush_m + kNumSigmas * DepthSigmaM(depth_m), things.layout) ? 1 : 0;
    }
  }
}

bool LiesInWall(const ObjectTrack& track,
                const std::map<DetectionId, const Segment*>& segment_of,
                const HungThings& things) {
  Measured measured;
  for (const TrackMember& member : track.members) {
    const auto found = segment_of.find(member.detection);
    if (found != segment_of.end()) Measure(*found->second, things, measured);
  }
  return measured.num_points > 0 && static_cast<double>(measured.num_flush) >
                                        kFlushShare * static_cast<double>(measured.num_points);
}

SeenIn LargestIn(const ObjectTrack& track,
                 const std::map<DetectionId, const Segment*>& segment_of) {
  SeenIn largest;
  for (const TrackMember& member : track.members) {
    const auto found = segment_of.find(member.detection);
    if (found != segment_of.end() && found->second->box_px.area_px() > largest.box_px.area_px())
      largest = {found->second->frame, found->second->box_px};
  }
  return largest;
}

}  // namespace

void LeaveOutFlush(const HungThings& things, Association& association) {
  std::map<DetectionId, const Segment*> segment_of;
  for (const Segment& segment : things.segments) segment_of[segment.detection] = &segment;
  std::erase_if(association.tracks, [&](const ObjectTrack& track) {
    const Supports supports = things.classes.TraitsOf(track.class_name).supports;
    if (!supports.wall || supports.floor || !LiesInWall(track, segment_of, things)) return false;
    for (const TrackMember& member : track.members)
      association.rejections.push_back({member.detection, member.frame, "lies flush in a wall"});
    association.not_mapped.push_back(
        {fmt::format("{} seen in {} frames: flush in a wall, as a picture is",
                     track.class_name,
                     track.members.size()),
         LargestIn(track, segment_of)});
    return true;
  });
}

}  // namespace deepslam::discovery

#include "deepslam/loop/visits.h"

#include <algorithm>
#include <cstddef>
#include <iterator>
#include <optional>

#include "deepslam/loop/correction.h"
#include "deepslam/loop/level_icp.h"
#include "deepslam/loop/point_agreement.h"

namespace deepslam::loop {
namespace {

constexpr double kCell_m = 0.03;  // thinning

Eigen::Vector3d Mean(std::span<const Eigen::Vector3f> points) {
  Eigen::Vector3d sum = Eigen::Vector3d::Zero();
  for (const Eigen::Vector3f& p : points) sum += p.cast<double>();
  return sum / static_cast<double>(points.size());
}

// The visits that stand together, in order.
std::vector<ObjectTrack> Parts(std::vector<ObjectTrack> visits,
                               const std::vector<std::vector<Eigen::Vector3f>>& depth,
                               const Eigen::Vector3d& up_world,
                               const LoopOptions& options) {
  std::vector<ObjectTrack> parts;
  for (std::size_t k = 0; k < visits.size(); ++k) {
    if (k == 0 || (k < depth.size() && StandApart(depth[k - 1], depth[k], up_world, options))) {
      parts.push_back(std::move(visits[k]));
      continue;
    }
    std::move(visits[k].members.begin(),
              visits[k].members.end(),
              std::back_inserter(parts.back().members));
  }
  return parts;
}

}  // namespace

std::vector<ObjectTrack> Visits(const ObjectTrack& track, const LoopOptions& options) {
  std::vector<ObjectTrack> visits;
  for (const TrackMember& member : track.members) {
    const bool goes_on =
        !visits.empty() &&
        member.frame.value - visits.back().members.back().frame.value < options.min_gap_frames;
    if (!goes_on) visits.push_back({track.id, track.class_name, {}, track.reason});
    visits.back().members.push_back(member);
  }
  if (visits.empty()) visits.push_back(track);
  return visits;
}

bool StandApart(std::span<const Eigen::Vector3f> old_world,
                std::span<const Eigen::Vector3f> new_world,
                const Eigen::Vector3d& up_world,
                const LoopOptions& options) {
  const PointIndex old_points(Thinned(old_world, kCell_m));
  const std::vector<Eigen::Vector3f> thinned_old = Thinned(old_world, kCell_m);
  const std::vector<Eigen::Vector3f> thinned_new = Thinned(new_world, kCell_m);
  const std::vector<Belonging> clouds = {{thinned_new, &old_points}};
  const std::optional<Pose3> old_from_new =
      AlignLevel(clouds, {}, LevelFromWorld(up_world), options.verify_distance_m);
  if (!old_from_new) return false;
  const Eigen::Vector3d middle = Mean(thinned_new);
  if ((*old_from_new * middle - middle).norm() <= kApart_m) return false;
  const double agreement =
      std::max(AgreeingShare(thinned_new, *old_from_new, old_points, options.verify_distance_m),
               AgreeingShare(thinned_old,
                             old_from_new->Inverse(),
                             PointIndex(thinned_new),
                             options.verify_distance_m));
  return agreement >= options.min_object_agreement;
}

PartedObjects PartVisits(const Association& association,
                         const VisitDepth& depth,
                         const Eigen::Vector3d& up_world,
                         const LoopOptions& options) {
  int next_id = 0;
  for (const ObjectTrack& track : association.tracks)
    next_id = std::max(next_id, track.id.value + 1);
  PartedObjects parted;
  for (const ObjectTrack& track : association.tracks) {
    const auto own = depth.find(track.id);
    if (own == depth.end()) continue;
    std::vector<ObjectTrack> parts = Parts(Visits(track, options), own->second, up_world, options);
    if (parts.size() < 2) continue;
    for (std::size_t k = 0; k < parts.size(); ++k) {
      if (k > 0) parts[k].id = ObjectId{next_id++};
      parted.visits.push_back(
          {parts[k].id, track.id, parts[k].members.front().frame, parts[k].members.back().frame});
      parted.tracks.push_back(std::move(parts[k]));
    }
  }
  return parted;
}

}  // namespace deepslam::loop

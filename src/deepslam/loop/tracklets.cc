#include "deepslam/loop/tracklets.h"

#include <algorithm>
#include <cstddef>
#include <iterator>
#include <map>
#include <optional>

#include "deepslam/loop/correction.h"
#include "deepslam/loop/level_icp.h"
#include "deepslam/loop/point_agreement.h"

namespace deepslam::loop {
namespace {

using Points = std::vector<Eigen::Vector3f>;

// By this share of the points: support planes slide far on each other for less.
constexpr double kClearlyBetterSplit = 0.1;

Eigen::Vector3d Mean(const Points& points) {
  Eigen::Vector3d sum = Eigen::Vector3d::Zero();
  for (const Eigen::Vector3f& p : points) sum += p.cast<double>();
  return sum / static_cast<double>(points.size());
}

// Around the object, without the ground.
Points Surroundings(const ObjectEvidence& tracklet,
                    const Points& object,
                    const Eigen::Vector3d& up_world) {
  const double ground_top_m = GroundTop_m(object, up_world);
  Points around = Thinned(tracklet.surroundings_world, kThinnedCell_m);
  std::erase_if(around, [&](const Eigen::Vector3f& p) {
    return up_world.dot(p.cast<double>()) < ground_top_m;
  });
  return around;
}

Points Together(Points points, const Points& more) {
  points.insert(points.end(), more.begin(), more.end());
  return points;
}

struct Seen {
  Seen(const ObjectEvidence& tracklet, const Eigen::Vector3d& up_world)
      : object(Thinned(tracklet.depth_points_world, kThinnedCell_m)),
        all(Together(object, Surroundings(tracklet, object, up_world))),
        object_index(object) {}

  Points object;
  Points all;
  PointIndex object_index;
};

// Of the objects; the better direction, since one observation may have seen more.
double Agreement(const Seen& older,
                 const Seen& newer,
                 const Pose3& older_from_newer,
                 double radius_m) {
  return std::max(
      AgreeingShare(newer.object, older_from_newer, older.object_index, radius_m),
      AgreeingShare(older.object, older_from_newer.Inverse(), newer.object_index, radius_m));
}

// The observations that stand together, in order.
std::vector<ObjectTrack> Parts(std::vector<ObjectTrack> tracklets, const std::vector<bool>& apart) {
  std::vector<ObjectTrack> parts;
  for (std::size_t k = 0; k < tracklets.size(); ++k) {
    if (k == 0 || (k <= apart.size() && apart[k - 1])) {
      parts.push_back(std::move(tracklets[k]));
      continue;
    }
    std::move(tracklets[k].members.begin(),
              tracklets[k].members.end(),
              std::back_inserter(parts.back().members));
  }
  return parts;
}

}  // namespace

std::vector<ObjectTrack> Tracklets(const ObjectTrack& track, const LoopOptions& options) {
  std::vector<ObjectTrack> tracklets;
  for (const TrackMember& member : track.members) {
    const bool goes_on =
        !tracklets.empty() &&
        member.frame.value - tracklets.back().members.back().frame.value < options.min_gap_frames;
    if (!goes_on)
      tracklets.push_back({track.id, track.class_name, {}, track.reason, track.class_votes});
    tracklets.back().members.push_back(member);
  }
  if (tracklets.empty()) tracklets.push_back(track);
  return tracklets;
}

bool StandApart(const ObjectEvidence& old_tracklet,
                const ObjectEvidence& new_tracklet,
                const Eigen::Vector3d& up_world,
                const LoopOptions& options) {
  const Seen older(old_tracklet, up_world);
  const Seen newer(new_tracklet, up_world);
  if (std::min(older.object.size(), newer.object.size()) < kMinComparedPoints) return false;
  const Eigen::Quaterniond level_from_world = LevelFromWorld(up_world);
  const double radius_m = LoopOptions::kVerifyDistance_m;
  // The object first: around it walls may hold on to where they are.
  const std::vector<Belonging> object = {{newer.object, &older.object_index}};
  const PointIndex all_older(older.all);
  const std::vector<Belonging> all = {{newer.all, &all_older}};
  const std::optional<Pose3> start = AlignLevel(object, {}, level_from_world, radius_m);
  const std::optional<Pose3> aligned =
      AlignLevel(all, start.value_or(Pose3{}), level_from_world, radius_m);
  if (!aligned) return false;
  const Eigen::Vector3d middle = Mean(newer.object);
  if ((*aligned * middle - middle).norm() <= kApart_m) return false;
  const double moved = Agreement(older, newer, *aligned, radius_m);
  const double as_they_stand = Agreement(older, newer, {}, radius_m);
  return moved >= options.min_object_agreement && moved >= as_they_stand + kClearlyBetterSplit;
}

SplitObjects SplitTracklets(const Association& association,
                            const StandingApart& apart,
                            const LoopOptions& options) {
  int next_id = 0;
  for (const ObjectTrack& track : association.tracks)
    next_id = std::max(next_id, track.id.value + 1);
  SplitObjects parted;
  for (const ObjectTrack& track : association.tracks) {
    const auto own = apart.find(track.id);
    if (own == apart.end()) continue;
    std::vector<ObjectTrack> parts = Parts(Tracklets(track, options), own->second);
    if (parts.size() < 2) continue;
    for (std::size_t k = 0; k < parts.size(); ++k) {
      if (k > 0) parts[k].id = ObjectId{next_id++};
      parted.tracklets.push_back(
          {parts[k].id, track.id, parts[k].members.front().frame, parts[k].members.back().frame});
      parted.tracks.push_back(std::move(parts[k]));
    }
  }
  return parted;
}

std::vector<Constellation> ProposeReidentified(const std::vector<SplitTracklet>& tracklets,
                                               const ObjectMap& map,
                                               std::vector<Constellation>& proposed) {
  std::map<ObjectId, ObjectId> object_of;
  for (const SplitTracklet& tracklet : tracklets) object_of[tracklet.tracklet] = tracklet.object;
  const auto of_one_object = [&](const ObjectMerge& pair) {
    const auto kept = object_of.find(pair.kept);
    const auto merged = object_of.find(pair.merged);
    return kept != object_of.end() && merged != object_of.end() && kept->second == merged->second;
  };
  std::erase_if(proposed, [&](const Constellation& constellation) {
    return constellation.pairs.size() == 1 && of_one_object(constellation.pairs.front());
  });
  const auto is_proposed = [&](ObjectId a, ObjectId b) {
    return std::ranges::any_of(proposed, [&](const Constellation& constellation) {
      return std::ranges::any_of(constellation.pairs, [&](const ObjectMerge& pair) {
        return std::minmax(pair.kept, pair.merged) == std::minmax(a, b);
      });
    });
  };
  std::vector<Constellation> reidentified;
  for (std::size_t k = 1; k < tracklets.size(); ++k) {
    if (tracklets[k].object != tracklets[k - 1].object) continue;
    const auto older = std::ranges::find(map.objects, tracklets[k - 1].tracklet, &MapObject::id);
    const auto newer = std::ranges::find(map.objects, tracklets[k].tracklet, &MapObject::id);
    if (older == map.objects.end() || newer == map.objects.end() ||
        is_proposed(older->id, newer->id)) {
      continue;
    }
    Constellation single;
    single.pairs = {{older->id, newer->id}};
    single.old_world_from_new_world.translation_m =
        older->world_from_object.translation_m - newer->world_from_object.translation_m;
    single.position_error_m = single.old_world_from_new_world.translation_m.norm();
    reidentified.push_back(single);
  }
  return reidentified;
}

RejoinedTracklets RejoinTracklets(const std::vector<SplitTracklet>& tracklets,
                                  const std::vector<ObjectMerge>& merges) {
  std::map<ObjectId, ObjectId> kept;  // of everything that is in a merge
  for (const ObjectMerge& merge : merges) {
    kept[merge.merged] = merge.kept;
    kept[merge.kept] = merge.kept;
  }
  std::map<ObjectId, std::set<ObjectId>> own;  // observations by object
  for (const SplitTracklet& tracklet : tracklets) own[tracklet.object].insert(tracklet.tracklet);
  RejoinedTracklets rejoined;
  for (const auto& [object, of_object] : own) {
    std::set<ObjectId> groups, loose;
    for (const ObjectId tracklet : of_object) {
      const auto in_merge = kept.find(tracklet);
      (in_merge == kept.end() ? loose : groups)
          .insert(in_merge == kept.end() ? tracklet : in_merge->second);
    }
    if (groups.empty()) rejoined.whole.insert(object);
    if (groups.size() != 1 || loose.empty()) continue;
    const ObjectId group = *groups.begin();
    const std::set<ObjectId>& own_tracklets = of_object;  // clang 14 captures no binding
    const bool others = std::ranges::any_of(kept, [&](const auto& entry) {
      return entry.second == group && !own_tracklets.contains(entry.first);
    });
    if (others) continue;
    loose.insert(group);
    for (auto tracklet = std::next(loose.begin()); tracklet != loose.end(); ++tracklet)
      rejoined.merges.push_back({*loose.begin(), *tracklet});
  }
  return rejoined;
}

}  // namespace deepslam::loop

#include "deepslam/associate/review_objects.h"

#include <algorithm>
#include <cstdint>
#include <optional>
#include <string>
#include <utility>

namespace deepslam::associate {
namespace {

// Share of the smaller object that must lie inside one of another class to call it a part of that.
constexpr double kPartShare = 0.7;
// How much nearer than an object a measured surface must be to hide it.
constexpr double kHides_m = 0.15;
// A box of which the other covers this share lies in it.
constexpr double kContainedShare = 0.9;
constexpr double kSeenShare = 0.5;  // share of an object's points that must be visible
// So many points of an object are looked at: shares are then good to 5 %.
constexpr std::size_t kNumProbes = 100;

void Dissolve(const ObjectHypothesis& object,
              std::vector<Observation>& all,
              const std::string& reason,
              std::vector<Rejection>& rejections) {
  for (const int i : object.observations) {
    Observation& observation = all[static_cast<std::size_t>(i)];
    observation.object = ObjectId();
    rejections.push_back({observation.segment->detection, observation.segment->frame, reason});
  }
}

const Segment& SegmentOf(const ObjectHypothesis& object,
                         std::size_t member,
                         const std::vector<Observation>& all) {
  return *all[static_cast<std::size_t>(object.observations[member])].segment;
}

void Absorb(ObjectHypothesis& kept,
            const ObjectHypothesis& merged,
            std::vector<Observation>& all,
            std::vector<Rejection>& rejections) {
  const auto reject = [&](const Segment& segment) {
    rejections.push_back({segment.detection, segment.frame, "second detection of one object"});
  };
  for (std::size_t m = 0; m < merged.members.size(); ++m) {
    const int index = merged.observations[m];
    Observation& observation = all[static_cast<std::size_t>(index)];
    const Segment& segment = *observation.segment;
    if (const std::optional<std::size_t> rival = kept.MemberIn(segment.frame)) {
      const Segment& other = SegmentOf(kept, *rival, all);
      if (other.num_points >= segment.num_points) {
        observation.object = ObjectId();
        reject(segment);
        continue;
      }
      RemoveMember(kept, all, *rival);
      reject(other);
    }
    TrackMember member = merged.members[m];
    member.how = "merge";
    AddMember(kept, all, index, std::move(member));
  }
  kept.points_world.Add(merged.points_world.points(), 0.5 * AssociateOptions::kVoxel_m);
}

// Two boxes of which one lies in the other may be a thing and a half of it, detected twice.
bool StandSideBySide(const Box2& a_px, const Box2& b_px) {
  const double smaller_px = std::min(a_px.area_px(), b_px.area_px());
  return Intersection(a_px, b_px).area_px() < kContainedShare * smaller_px;
}

// Whether a frame shows both, side by side: then they are two.
bool AreSeenApart(const ObjectHypothesis& a,
                  const ObjectHypothesis& b,
                  const std::vector<Observation>& all) {
  for (std::size_t m = 0; m < a.members.size(); ++m) {
    const std::optional<std::size_t> n = b.MemberIn(a.members[m].frame);
    if (n && StandSideBySide(SegmentOf(a, m, all).box_px, SegmentOf(b, *n, all).box_px))
      return true;
  }
  return false;
}

enum class Relation { kApart, kSame, kPart };

Relation Compare(const ObjectHypothesis& a,
                 const ObjectHypothesis& b,
                 const std::vector<Observation>& all) {
  // Drift sets apart what was never seen side by side.
  const bool drift = a.class_name == b.class_name && !AreSeenApart(a, b, all);
  const double reach_m = drift ? AssociateOptions::kMaxDissimilarity_m : AssociateOptions::kVoxel_m;
  const double a_in_b = ShareNear(a.points_world.cloud(), b.points_world.cloud(), reach_m);
  const double b_in_a = ShareNear(b.points_world.cloud(), a.points_world.cloud(), reach_m);
  const double larger = std::max(a_in_b, b_in_a);
  if (a.class_name == b.class_name) {
    return larger > AssociateOptions::kMergeOverlap ? Relation::kSame : Relation::kApart;
  }
  if (std::min(a_in_b, b_in_a) > AssociateOptions::kMergeOverlap) return Relation::kSame;
  const bool a_inside = a_in_b > b_in_a;
  const std::size_t few = a_inside ? a.members.size() : b.members.size();
  const std::size_t many = a_inside ? b.members.size() : a.members.size();
  return larger > kPartShare && 2 * few <= many ? Relation::kPart : Relation::kApart;
}

bool IsVisible(const ObjectHypothesis& object,
               const CoarseView& view,
               const PinholeCamera& camera) {
  const std::vector<Eigen::Vector3f>& points = object.points_world.points();
  const std::size_t step = std::max<std::size_t>(1, points.size() / kNumProbes);
  int count = 0;
  int seen = 0;
  for (std::size_t i = 0; i < points.size(); i += step) {
    ++count;
    const Eigen::Vector3d p = view.camera_from_world * points[i].cast<double>();
    const auto pixel = camera.Project(p);
    if (!pixel || !(std::abs(pixel->x()) < 1e6) || !(std::abs(pixel->y()) < 1e6)) continue;
    const int u = static_cast<int>(pixel->x()) / kCoarseStep;
    const int v = static_cast<int>(pixel->y()) / kCoarseStep;
    if (pixel->x() < 0 || pixel->y() < 0 || !view.coarse_depth_m.Contains(u, v)) continue;
    const double depth_m = view.coarse_depth_m(u, v);
    seen += depth_m > 0 && depth_m > p.z() - kHides_m ? 1 : 0;
  }
  return seen > kSeenShare * count;
}

}  // namespace

void MergeDuplicates(std::vector<ObjectHypothesis>& objects,
                     std::vector<Observation>& all,
                     std::vector<Rejection>& rejections) {
  bool changed = true;
  while (changed) {
    changed = false;
    for (std::size_t a = 0; a < objects.size() && !changed; ++a) {
      for (std::size_t b = a + 1; b < objects.size() && !changed; ++b) {
        const Relation relation = Compare(objects[a], objects[b], all);
        if (relation == Relation::kApart) continue;
        std::size_t gone = b;
        if (relation == Relation::kSame) {
          Absorb(objects[a], objects[b], all, rejections);
        } else {
          gone = objects[a].members.size() < objects[b].members.size() ? a : b;
          Dissolve(objects[gone], all, "part of another object", rejections);
        }
        objects.erase(objects.begin() + static_cast<std::ptrdiff_t>(gone));
        changed = true;
      }
    }
  }
}

void RejectNoise(std::vector<ObjectHypothesis>& objects,
                 std::vector<Observation>& all,
                 const CoarseViews& views,
                 const PinholeCamera& camera,
                 const AssociateOptions& options,
                 std::vector<Rejection>& rejections) {
  std::erase_if(objects, [&](const ObjectHypothesis& object) {
    const auto num_members = static_cast<int>(object.members.size());
    const double num_views =
        views.NumThat([&](const CoarseView& view) { return IsVisible(object, view, camera); });
    std::string reason;
    if (num_members < options.min_members &&
        object.MeanScore(all) < AssociateOptions::kMinSingleScore) {
      reason = "object seen too seldom with too low a score";
    } else if (num_members < AssociateOptions::kMinDetectedShare * num_views) {
      reason = "object detected in too few of the frames that see it";
    }
    if (reason.empty()) return false;
    Dissolve(object, all, reason, rejections);
    return true;
  });
}

}  // namespace deepslam::associate

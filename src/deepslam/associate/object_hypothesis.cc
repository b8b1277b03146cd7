#include "deepslam/associate/object_hypothesis.h"

#include <algorithm>
#include <map>
#include <utility>

namespace deepslam::associate {
namespace {

// Of a class that is guessed by size, against one that a network or a person has recognised.
constexpr double kTrustInSize = 0.1;

}  // namespace

bool ObjectHypothesis::IsSeenIn(FrameIdx frame) const {
  return std::any_of(members.begin(), members.end(), [frame](const TrackMember& member) {
    return member.frame == frame;
  });
}

double ObjectHypothesis::MeanScore(const std::vector<Observation>& all) const {
  double sum = 0;
  for (const int i : observations) sum += all[static_cast<std::size_t>(i)].segment->score;
  return observations.empty() ? 0.0 : sum / static_cast<double>(observations.size());
}

void AddMember(ObjectHypothesis& object,
               std::vector<Observation>& all,
               int observation,
               TrackMember member,
               double cell_m) {
  Observation& added = all[static_cast<std::size_t>(observation)];
  added.object = object.id;
  member.detection = added.segment->detection;
  member.frame = added.segment->frame;
  // Members stay in ascending frames, also when an earlier detection is adopted late.
  const auto place = std::upper_bound(
      object.members.begin(),
      object.members.end(),
      member,
      [](const TrackMember& a, const TrackMember& b) { return a.frame < b.frame; });
  object.observations.insert(object.observations.begin() + (place - object.members.begin()),
                             observation);
  object.members.insert(place, std::move(member));
  object.class_name = MajorityClass(object, all);
  object.points_world.insert(object.points_world.end(),
                             added.cloud_world.points().begin(),
                             added.cloud_world.points().end());
  object.points_world = Thinned(object.points_world, cell_m);
  object.cloud_world = PointCloud(object.points_world);
}

std::string MajorityClass(const ObjectHypothesis& object, const std::vector<Observation>& all) {
  std::map<std::string, double> weights;
  for (const int i : object.observations) {
    const Segment& segment = *all[static_cast<std::size_t>(i)].segment;
    const double trust = segment.source == DetectionSource::kCluster ? kTrustInSize : 1;
    weights[segment.class_name] += trust * segment.score;
  }
  std::string best;
  double best_weight = -1;
  for (const auto& [name, weight] : weights) {
    if (weight > best_weight) {
      best = name;
      best_weight = weight;
    }
  }
  return best;
}

}  // namespace deepslam::associate

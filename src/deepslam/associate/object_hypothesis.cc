#include "deepslam/associate/object_hypothesis.h"

#include <algorithm>
#include <map>
#include <utility>

namespace deepslam::associate {
namespace {

// Of a class that is guessed by size, against one that a network or a person has recognised.
constexpr double kTrustInSize = 0.1;

bool IsEarlier(const TrackMember& a, const TrackMember& b) { return a.frame < b.frame; }

// Positive, or negative to take the segment out again.
void Weigh(ObjectHypothesis& object, const Segment& segment, double sign) {
  const double trust = segment.source == DetectionSource::kCluster ? kTrustInSize : 1;
  object.class_weights[segment.class_name] += sign * trust * segment.score;
  double best_weight = -1;
  for (const auto& [name, weight] : object.class_weights) {
    if (weight <= best_weight) continue;
    object.class_name = name;
    best_weight = weight;
  }
}

}  // namespace

std::optional<std::size_t> ObjectHypothesis::MemberIn(FrameIdx frame) const {
  TrackMember member;
  member.frame = frame;
  const auto place = std::lower_bound(members.begin(), members.end(), member, IsEarlier);
  if (place == members.end() || place->frame != frame) return std::nullopt;
  return static_cast<std::size_t>(place - members.begin());
}

std::map<std::string, double> ClassVotes(const ObjectHypothesis& object,
                                         const std::vector<Observation>& all) {
  std::map<std::string, double> votes;
  for (const int i : object.observations) {
    const Segment& segment = *all[static_cast<std::size_t>(i)].segment;
    if (segment.source != DetectionSource::kCluster) votes[segment.class_name] += segment.score;
  }
  return votes;
}

double ObjectHypothesis::MeanScore(const std::vector<Observation>& all) const {
  double sum = 0;
  for (const int i : observations) sum += all[static_cast<std::size_t>(i)].segment->score;
  return observations.empty() ? 0.0 : sum / static_cast<double>(observations.size());
}

void AddMember(ObjectHypothesis& object,
               std::vector<Observation>& all,
               int observation,
               TrackMember member) {
  Observation& added = all[static_cast<std::size_t>(observation)];
  added.object = object.id;
  member.detection = added.segment->detection;
  member.frame = added.segment->frame;
  // Members stay in ascending frames, also when an earlier detection is adopted late.
  const auto place =
      std::upper_bound(object.members.begin(), object.members.end(), member, IsEarlier);
  object.observations.insert(object.observations.begin() + (place - object.members.begin()),
                             observation);
  object.members.insert(place, std::move(member));
  Weigh(object, *added.segment, 1);
}

void RemoveMember(ObjectHypothesis& object, std::vector<Observation>& all, std::size_t member) {
  const auto place = static_cast<std::ptrdiff_t>(member);
  Observation& removed = all[static_cast<std::size_t>(object.observations[member])];
  removed.object = ObjectId();
  object.observations.erase(object.observations.begin() + place);
  object.members.erase(object.members.begin() + place);
  Weigh(object, *removed.segment, -1);
}

}  // namespace deepslam::associate

#include "deepslam/associate/match_frame.h"

#include <algorithm>
#include <map>
#include <optional>
#include <set>

#include "deepslam/core/parallel.h"

namespace deepslam::associate {
namespace {

// Detections of different classes on one thing must agree better: this factor on the greatest
// dissimilarity.
constexpr double kOtherClassFactor = 0.6;

std::vector<bool> InsideBox(const std::vector<Eigen::Vector3f>& points_world,
                            const Box2& box_px,
                            const PinholeCamera& camera,
                            const Pose3& camera_from_world) {
  std::vector<bool> inside;
  inside.reserve(points_world.size());
  for (const Eigen::Vector3f& p : points_world) {
    const auto pixel = camera.Project(camera_from_world * p.cast<double>());
    inside.push_back(pixel && box_px.Contains(pixel->x(), pixel->y()));
  }
  return inside;
}

// Closest-point error of a voter's points that fall into the box, and the other way round: one set
// may be a part of the other, so the better direction counts where the classes are one; else both.
std::optional<double> Dissimilarity(const Observation& voter,
                                    const Observation& current,
                                    const PinholeCamera& camera,
                                    const Pose3& camera_from_world) {
  const std::vector<bool> inside =
      InsideBox(voter.points_world, current.segment->box_px, camera, camera_from_world);
  const auto num_inside = static_cast<double>(std::count(inside.begin(), inside.end(), true));
  if (num_inside < AssociateOptions::kMinInsideShare * static_cast<double>(inside.size()) ||
      num_inside == 0) {
    return std::nullopt;
  }
  const double forth_m = MeanDistance(
      voter.points_world, current.cloud_world, AssociateOptions::kMaxCounted_m, inside);
  const double back_m =
      MeanDistance(current.points_world, voter.cloud_world, AssociateOptions::kMaxCounted_m);
  const bool same_class = voter.segment->class_name == current.segment->class_name;
  const double error_m = same_class ? std::min(forth_m, back_m) : std::max(forth_m, back_m);
  const double limit_m =
      AssociateOptions::kMaxDissimilarity_m * (same_class ? 1.0 : kOtherClassFactor);
  if (error_m > limit_m) return std::nullopt;
  return error_m;
}

struct Tally {
  int num_votes = 0;
  double sum_m = 0;
};

// Best object of every voting frame.
std::map<ObjectId, Tally> CollectVotes(const Observation& current,
                                       std::span<const std::vector<int>> voters,
                                       const std::vector<Observation>& all,
                                       const PinholeCamera& camera,
                                       const Pose3& camera_from_world) {
  std::map<ObjectId, Tally> tallies;
  for (const std::vector<int>& frame : voters) {
    ObjectId best;
    double best_m = 0;
    for (const int i : frame) {
      const Observation& voter = all[static_cast<std::size_t>(i)];
      if (!voter.object.valid()) continue;
      const auto error_m = Dissimilarity(voter, current, camera, camera_from_world);
      if (error_m && (!best.valid() || *error_m < best_m)) {
        best = voter.object;
        best_m = *error_m;
      }
    }
    if (!best.valid()) continue;
    ++tallies[best].num_votes;
    tallies[best].sum_m += best_m;
  }
  return tallies;
}

// Takes matches in the order given as long as neither side is taken.
std::vector<Match> TakeGreedily(const std::vector<Match>& sorted) {
  std::set<int> taken;
  std::set<ObjectId> matched;
  std::vector<Match> result;
  for (const Match& match : sorted) {
    if (taken.count(match.observation) != 0 || matched.count(match.object) != 0) continue;
    taken.insert(match.observation);
    matched.insert(match.object);
    result.push_back(match);
  }
  return result;
}

}  // namespace

std::vector<Match> MatchByVotes(std::span<const int> current,
                                std::span<const std::vector<int>> voters,
                                const std::vector<Observation>& all,
                                const PinholeCamera& camera,
                                const Pose3& camera_from_world) {
  std::vector<std::map<ObjectId, Tally>> all_tallies(current.size());
  ParallelFor(current.size(), [&](std::size_t n) {
    const Observation& observation = all[static_cast<std::size_t>(current[n])];
    all_tallies[n] = CollectVotes(observation, voters, all, camera, camera_from_world);
  });
  std::vector<Match> candidates;
  for (std::size_t n = 0; n < current.size(); ++n) {
    const std::map<ObjectId, Tally>& tallies = all_tallies[n];
    int total = 0;
    for (const auto& [object, tally] : tallies) total += tally.num_votes;
    for (const auto& [object, tally] : tallies) {
      if (tally.num_votes < AssociateOptions::kMinConsensus * total) continue;
      candidates.push_back({current[n], object, tally.num_votes, tally.sum_m / tally.num_votes});
    }
  }
  std::stable_sort(candidates.begin(), candidates.end(), [](const Match& a, const Match& b) {
    return a.num_votes != b.num_votes ? a.num_votes > b.num_votes
                                      : a.dissimilarity_m < b.dissimilarity_m;
  });
  return TakeGreedily(candidates);
}

std::vector<Match> MatchByModels(std::span<const int> unmatched,
                                 std::span<const ObjectHypothesis> objects,
                                 const std::vector<Observation>& all) {
  if (unmatched.empty()) return {};
  for (const ObjectHypothesis& object : objects) (void)object.points_world.cloud();
  std::vector<std::optional<Match>> found(unmatched.size() * objects.size());
  ParallelFor(found.size(), [&](std::size_t n) {
    const int i = unmatched[n / objects.size()];
    const ObjectHypothesis& object = objects[n % objects.size()];
    const Observation& current = all[static_cast<std::size_t>(i)];
    if (object.MemberIn(current.segment->frame)) return;
    const bool same_class = object.class_name == current.segment->class_name;
    const double limit_m =
        AssociateOptions::kMaxDissimilarity_m * (same_class ? 1.0 : kOtherClassFactor);
    const double error_m = MeanDistance(
        current.points_world, object.points_world.cloud(), AssociateOptions::kMaxCounted_m);
    if (error_m <= limit_m) found[n] = Match{i, object.id, 0, error_m};
  });
  std::vector<Match> candidates;
  for (const std::optional<Match>& match : found) {
    if (match) candidates.push_back(*match);
  }
  std::stable_sort(candidates.begin(), candidates.end(), [](const Match& a, const Match& b) {
    return a.dissimilarity_m < b.dissimilarity_m;
  });
  return TakeGreedily(candidates);
}

}  // namespace deepslam::associate

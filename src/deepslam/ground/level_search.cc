#include "deepslam/ground/level_search.h"

#include <algorithm>
#include <cmath>
#include <map>
#include <numbers>
#include <set>

namespace deepslam::ground {
namespace {

// Horizontal surfaces of one room agree to this angle, tracking drift included.
constexpr double kSameDirectionCosine = 0.985;  // 10 deg
// A level below another must hold this share of what the other holds in the same keyframes: mirror
// images in shiny floors and stray depth below the floor do not.
constexpr double kMinShareOfUpper = 0.15;
// A level seen in one keyframe only must be plain there.
constexpr double kMinSingleShare = 0.08;
// Points below the ground by more than the level separation: more of them than this and it is no
// ground.
constexpr double kMaxShareBelow = 0.15;

// Of long paths an even share of the sightings are directions to vote on; all vote.
constexpr std::size_t kMostSeeds = 4000;

struct Level {
  double height_m = 0;  // along the vertical direction, tracking world
  std::vector<std::size_t> members;
  std::map<std::size_t, double> share_of_keyframe;
  [[nodiscard]] double total() const {
    double sum = 0;
    for (const auto& [keyframe, share] : share_of_keyframe) sum += share;
    return sum;
  }
};

// Sightings by their height, and how much of the frames those up to each of them hold.
class ByHeight {
 public:
  ByHeight(std::span<const double> heights_m,
           std::span<const double> shares,
           std::vector<std::size_t> sightings)
      : heights_m_(heights_m), sorted_(std::move(sightings)) {
    std::ranges::stable_sort(sorted_, {}, [&](std::size_t k) { return heights_m_[k]; });
    for (const std::size_t k : sorted_) until_.push_back(until_.back() + shares[k]);
  }

  // Of those within `reach_m` of a height.
  [[nodiscard]] double Total(double height_m, double reach_m) const {
    const auto height = [&](std::size_t k) { return heights_m_[k]; };
    const auto first = std::ranges::partition_point(
        sorted_, [&](std::size_t k) { return height_m - height(k) > reach_m; });
    const auto end = std::ranges::partition_point(
        first, sorted_.end(), [&](std::size_t k) { return height(k) - height_m <= reach_m; });
    return until_[static_cast<std::size_t>(end - sorted_.begin())] -
           until_[static_cast<std::size_t>(first - sorted_.begin())];
  }

 private:
  std::span<const double> heights_m_;
  std::vector<std::size_t> sorted_;
  std::vector<double> until_ = {0};
};

// Greedy: the height with the most support first, then what is left.
std::vector<Level> FindLevels(std::span<const PlaneSighting> sightings,
                              const Eigen::Vector3d& up,
                              double separation_m) {
  std::vector<double> heights_m;
  std::vector<double> shares;
  std::vector<std::size_t> left;
  for (std::size_t k = 0; k < sightings.size(); ++k) {
    heights_m.push_back(up.dot(sightings[k].centroid_world));
    shares.push_back(sightings[k].share);
    if (sightings[k].plane_world.normal.dot(up) >= kSameDirectionCosine) left.push_back(k);
  }
  const double reach_m = 0.5 * separation_m;
  std::vector<Level> levels;
  while (!left.empty()) {
    const ByHeight by_height(heights_m, shares, left);
    std::size_t best = left.front();
    double best_total = -1;
    for (const std::size_t seed : left) {
      const double total = by_height.Total(heights_m[seed], reach_m);
      if (total <= best_total) continue;
      best_total = total;
      best = seed;
    }
    Level level;
    level.height_m = heights_m[best];
    const auto belongs = [&](std::size_t k) {
      return std::abs(heights_m[k] - level.height_m) <= reach_m;
    };
    for (const std::size_t k : left) {
      if (!belongs(k)) continue;
      level.members.push_back(k);
      level.share_of_keyframe[sightings[k].keyframe] += sightings[k].share;
    }
    std::erase_if(left, belongs);
    levels.push_back(std::move(level));
  }
  return levels;
}

bool HoldsAgainstUpper(const Level& level, std::span<const Level> levels) {
  for (const Level& upper : levels) {
    if (upper.height_m <= level.height_m) continue;
    double own = 0;
    double above = 0;
    for (const auto& [keyframe, share] : level.share_of_keyframe) {
      const auto found = upper.share_of_keyframe.find(keyframe);
      own += share;
      above += found != upper.share_of_keyframe.end() ? found->second : 0;
    }
    if (own < kMinShareOfUpper * above) return false;
  }
  return true;
}

bool PermissibleHeight(const Level& level,
                       std::span<const PlaneSighting> sightings,
                       const GroundOptions& options) {
  std::vector<double> heights;
  for (const std::size_t k : level.members) heights.push_back(sightings[k].camera_height_m);
  std::ranges::sort(heights);
  const double median = heights[heights.size() / 2];
  return median >= options.min_height_m && median <= options.max_height_m;
}

}  // namespace

std::optional<Eigen::Vector3d> VerticalDirection(std::span<const PlaneSighting> sightings) {
  std::optional<Eigen::Vector3d> best;
  double best_votes = 0;
  const std::size_t step = (sightings.size() + kMostSeeds - 1) / kMostSeeds;
  for (std::size_t n = 0; n < sightings.size(); n += step) {
    const PlaneSighting& seed = sightings[n];
    Eigen::Vector3d sum = Eigen::Vector3d::Zero();
    double votes = 0;
    for (const PlaneSighting& other : sightings) {
      if (seed.plane_world.normal.dot(other.plane_world.normal) < kSameDirectionCosine) continue;
      sum += other.share * other.plane_world.normal;
      votes += other.share;
    }
    if (votes > best_votes) {
      best_votes = votes;
      best = sum.normalized();
    }
  }
  return best;
}

double ShareBelow(std::span<const KeyframeSample> samples,
                  const Eigen::Vector3d& up_world,
                  double height_m) {
  const Eigen::Vector3f direction = up_world.cast<float>();
  const float limit = static_cast<float>(height_m);
  std::size_t below = 0;
  std::size_t all = 0;
  for (const KeyframeSample& sample : samples) {
    all += sample.points_world.size();
    below += static_cast<std::size_t>(std::ranges::count_if(
        sample.points_world, [&](const Eigen::Vector3f& p) { return direction.dot(p) < limit; }));
  }
  return all > 0 ? static_cast<double>(below) / static_cast<double>(all) : 0;
}

std::optional<std::size_t> FindGroundSighting(std::span<const PlaneSighting> sightings,
                                              std::span<const KeyframeSample> samples,
                                              const GroundOptions& options) {
  const std::optional<Eigen::Vector3d> up = VerticalDirection(sightings);
  if (!up) return std::nullopt;
  std::vector<Level> levels = FindLevels(sightings, *up, GroundOptions::kLevelSeparation_m);
  std::ranges::sort(levels, {}, &Level::height_m);
  for (const Level& level : levels) {
    const bool plain = level.share_of_keyframe.size() > 1 || level.total() >= kMinSingleShare;
    if (!plain || !HoldsAgainstUpper(level, levels) ||
        !PermissibleHeight(level, sightings, options))
      continue;
    if (ShareBelow(samples, *up, level.height_m - GroundOptions::kLevelSeparation_m) >
        kMaxShareBelow)
      return std::nullopt;
    return *std::ranges::max_element(
        level.members, {}, [&](std::size_t k) { return sightings[k].share; });
  }
  return std::nullopt;
}

}  // namespace deepslam::ground

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

// The direction most plane area agrees on: floor, table tops and shelves all vote for it.
std::optional<Eigen::Vector3d> VerticalDirection(std::span<const PlaneSighting> sightings) {
  std::optional<Eigen::Vector3d> best;
  double best_votes = 0;
  for (const PlaneSighting& seed : sightings) {
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

// Greedy: the height with the most support first, then what is left.
std::vector<Level> FindLevels(std::span<const PlaneSighting> sightings,
                              const Eigen::Vector3d& up,
                              double separation_m) {
  std::vector<std::size_t> left;
  for (std::size_t k = 0; k < sightings.size(); ++k) {
    if (sightings[k].plane_world.normal.dot(up) >= kSameDirectionCosine) left.push_back(k);
  }
  const auto height = [&](std::size_t k) { return up.dot(sightings[k].centroid_world); };
  std::vector<Level> levels;
  while (!left.empty()) {
    Level best;
    double best_total = -1;
    for (const std::size_t seed : left) {
      Level level;
      level.height_m = height(seed);
      for (const std::size_t k : left) {
        if (std::abs(height(k) - level.height_m) > 0.5 * separation_m) continue;
        level.members.push_back(k);
        level.share_of_keyframe[sightings[k].keyframe] += sightings[k].share;
      }
      if (level.total() > best_total) {
        best_total = level.total();
        best = level;
      }
    }
    std::erase_if(left, [&](std::size_t k) {
      return std::ranges::find(best.members, k) != best.members.end();
    });
    levels.push_back(std::move(best));
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

double ShareBelow(std::span<const KeyframeSample> samples,
                  const Eigen::Vector3d& up,
                  double height_m) {
  const Eigen::Vector3f direction = up.cast<float>();
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

}  // namespace

std::optional<std::size_t> FindGroundSighting(std::span<const PlaneSighting> sightings,
                                              std::span<const KeyframeSample> samples,
                                              const GroundOptions& options) {
  const std::optional<Eigen::Vector3d> up = VerticalDirection(sightings);
  if (!up) return std::nullopt;
  std::vector<Level> levels = FindLevels(sightings, *up, options.level_separation_m);
  std::ranges::sort(levels, {}, &Level::height_m);
  for (const Level& level : levels) {
    const bool plain = level.share_of_keyframe.size() > 1 || level.total() >= kMinSingleShare;
    if (!plain || !HoldsAgainstUpper(level, levels) ||
        !PermissibleHeight(level, sightings, options))
      continue;
    if (ShareBelow(samples, *up, level.height_m - options.level_separation_m) > kMaxShareBelow)
      return std::nullopt;
    return *std::ranges::max_element(
        level.members, {}, [&](std::size_t k) { return sightings[k].share; });
  }
  return std::nullopt;
}

}  // namespace deepslam::ground

#include "deepslam/layout/select_lines.h"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <utility>

#include "deepslam/core/angles.h"
#include "deepslam/core/parallel.h"

namespace deepslam::layout {
namespace {

constexpr double kBeyond_m = 0.5;     // a line is looked at this far beyond what is on it
constexpr double kSameWall_m = 0.16;  // windows stand back, pictures and radiators stand out
constexpr double kSameWall_deg = 8;
constexpr double kBridged_m = 0.3;  // gaps between runs of wall that count as wall for that
constexpr double kMostOfIt = 0.6;
constexpr double kHighShare = 0.25;  // of a line's slots that reach as high as a wall has to
constexpr double kMinSolid_m2 = 0.3;

struct Reach {
  double bottom_m = 0;
  double top_m = 0;
};

// Heights of all but the outermost of the surface.
Reach HeightsOf(const CoarseSurface& surface) {
  std::vector<float> heights;
  for (const Eigen::Vector3f& p : surface.mesh.vertices) heights.push_back(p.z());
  if (heights.empty()) return {};
  std::sort(heights.begin(), heights.end());
  const std::size_t outermost = heights.size() / 500;
  return {static_cast<double>(heights[outermost]) - kCell_m,
          static_cast<double>(heights[heights.size() - 1 - outermost]) + kCell_m};
}

std::vector<WallProfile> ProfilesOf(const CoarseSurface& surface,
                                    const std::vector<WallLine>& lines,
                                    const Reach& heights,
                                    const ProfileOptions& options) {
  std::vector<WallProfile> profiles(lines.size());
  ParallelFor(lines.size(), [&](std::size_t n) {
    const ProfileReach reach{
        lines[n].begin_m - kBeyond_m, lines[n].end_m + kBeyond_m, heights.bottom_m, heights.top_m};
    profiles[n] = ProfileOf(surface, lines[n], reach, options);
  });
  return profiles;
}

double WallLength(const WallProfile& profile) {
  return kCell_m *
         static_cast<double>(std::count(profile.is_wall.begin(), profile.is_wall.end(), 1));
}

bool HasWall(const WallProfile& profile, double floor_m, const LayoutOptions& options) {
  int num_slots = 0;
  int num_high = 0;
  int num_solid = 0;
  for (int slot = 0; slot < profile.num_slots; ++slot) {
    if (profile.is_wall[static_cast<std::size_t>(slot)] == 0) continue;
    ++num_slots;
    bool high = false;
    for (int row = 0; row < profile.num_rows; ++row) {
      if ((profile.at(slot, row) & kSolid) == 0) continue;
      ++num_solid;
      high = high || profile.HeightOf(row + 1) > floor_m + options.min_wall_top_m;
    }
    num_high += high ? 1 : 0;
  }
  return num_slots * kCell_m >= options.min_wall_m &&
         num_solid * kCell_m * kCell_m >= kMinSolid_m2 && num_high > kHighShare * num_slots;
}

// Whether wall of the line stands before or behind a place.
bool StandsAt(const WallLine& line, const WallProfile& profile, const Eigen::Vector2d& at) {
  if (std::abs(line.Distance(at)) > kSameWall_m) return false;
  const double position_m = line.along().dot(at);
  return profile.WallShare(position_m - kBridged_m, position_m + kBridged_m) > 0;
}

// Whether most of the wall on `weaker` stands before or behind wall of lines that face its way.
// They may be several: a line along the walls of two rooms, each of which has its own.
bool IsSameWall(const WallLine& weaker, const WallProfile& profile, const WallLines& stronger) {
  int num_slots = 0;
  int num_same = 0;
  for (int slot = 0; slot < profile.num_slots; ++slot) {
    if (profile.is_wall[static_cast<std::size_t>(slot)] == 0) continue;
    ++num_slots;
    const Eigen::Vector2d at = weaker.At(profile.PositionOf(slot) + 0.5 * kCell_m);
    bool same = false;
    for (std::size_t k = 0; k < stronger.lines.size() && !same; ++k) {
      same = weaker.normal.dot(stronger.lines[k].normal) >= std::cos(kSameWall_deg * kRadPerDeg) &&
             StandsAt(stronger.lines[k], stronger.profiles[k], at);
    }
    num_same += same ? 1 : 0;
  }
  return num_same > kMostOfIt * num_slots;
}

// At right angles to the first line, or to whatever most lines are.
bool AtRightAngles(const WallLine& line, const std::vector<WallLine>& others) {
  double near_m2 = 0;
  double whole_m2 = 0;
  for (const WallLine& other : others) {
    const double cosine = std::abs(line.normal.dot(other.normal));
    const double off = std::min(cosine, std::sqrt(std::max(0.0, 1 - cosine * cosine)));
    whole_m2 += other.area_m2;
    near_m2 += off < std::sin(4 * kRadPerDeg) ? other.area_m2 : 0;
  }
  return near_m2 > 0.5 * whole_m2;
}

}  // namespace

WallLines SelectLines(const CoarseSurface& surface,
                      std::vector<WallLine> candidates,
                      double floor_m,
                      const LayoutOptions& options) {
  const Reach heights = HeightsOf(surface);
  const std::vector<WallProfile> profiles =
      ProfilesOf(surface, candidates, heights, options.profiles);
  WallLines walls;
  for (std::size_t n = 0; n < candidates.size(); ++n) {
    if (!HasWall(profiles[n], floor_m, options)) continue;
    if (IsSameWall(candidates[n], profiles[n], walls)) continue;
    walls.lines.push_back(candidates[n]);
    walls.profiles.push_back(profiles[n]);
  }
  std::vector<WallLine> kept;
  for (std::size_t n = 0; n < walls.lines.size(); ++n) {
    if (WallLength(walls.profiles[n]) >= options.min_slanting_m ||
        AtRightAngles(walls.lines[n], walls.lines))
      kept.push_back(walls.lines[n]);
  }
  if (options.align) AlignLines(kept);
  walls.lines = std::move(kept);
  walls.profiles = ProfilesOf(surface, walls.lines, heights, options.profiles);
  return walls;
}

}  // namespace deepslam::layout

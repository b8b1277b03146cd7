#include "deepslam/layout/select_lines.h"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <functional>
#include <utility>

#include "deepslam/core/angles.h"
#include "deepslam/core/parallel.h"
#include "deepslam/layout/furniture_fronts.h"

namespace deepslam::layout {
namespace {

constexpr double kBeyond_m = 0.5;     // a line is looked at this far beyond what is on it
constexpr double kSameWall_m = 0.16;  // windows stand back, pictures and radiators stand out
constexpr double kSameWall_deg = 8;   // walls of homes that are not parallel differ by more
constexpr double kBridged_m = 0.3;    // gaps between runs of wall that count as wall for that
// Share of a line's wall: the rest may be noise at the ends of other lines.
constexpr double kMostOfIt = 0.6;
constexpr double kMinSolid_m2 = 0.3;  // of surface: a metre of wall, seen 0.3 m high
// Of the height to which most of the capture's wall was seen: what ends lower is furniture, the
// side of a wardrobe; how high walls are seen depends on where the camera looks.
constexpr double kLowShare = 0.75;

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

// What was measured of a line's wall.
struct SeenWall {
  double length_m = 0;
  double area_m2 = 0;
  double top_m = 0;
};

SeenWall SeenOf(const WallProfile& profile) {
  SeenWall seen;
  seen.length_m = WallLength(profile);
  seen.top_m = profile.SeenTop(0, profile.num_slots);
  for (int slot = 0; slot < profile.num_slots; ++slot) {
    if (profile.is_wall[static_cast<std::size_t>(slot)] == 0) continue;
    for (int row = 0; row < profile.num_rows; ++row)
      seen.area_m2 += (profile.at(slot, row) & kSolid) != 0 ? kCell_m * kCell_m : 0;
  }
  return seen;
}

bool IsWall(const SeenWall& seen, double lowest_top_m, const LayoutOptions& options) {
  return seen.length_m >= options.min_wall_m && seen.area_m2 >= kMinSolid_m2 &&
         seen.top_m > lowest_top_m;
}

// Half of all wall, by its area, was seen at least that high.
double UsualTop(std::vector<SeenWall> walls) {
  std::ranges::sort(walls, std::greater(), &SeenWall::top_m);
  double whole_m2 = 0;
  for (const SeenWall& wall : walls) whole_m2 += wall.area_m2;
  double higher_m2 = 0;
  for (const SeenWall& wall : walls) {
    higher_m2 += wall.area_m2;
    if (higher_m2 >= 0.5 * whole_m2) return wall.top_m;
  }
  return 0;
}

struct Walls {
  std::vector<std::uint8_t> of_line;  // for each of the lines, whether it carries one
  double usual_top_m = 0;
};

// Lines that carry a wall which was seen high enough.
Walls FindWalls(const std::vector<WallProfile>& profiles,
                double floor_m,
                const LayoutOptions& options) {
  std::vector<SeenWall> seen;
  std::vector<SeenWall> high_enough;
  for (const WallProfile& profile : profiles) {
    seen.push_back(SeenOf(profile));
    if (IsWall(seen.back(), floor_m + LayoutOptions::kMinWallTop_m, options))
      high_enough.push_back(seen.back());
  }
  Walls walls;
  walls.usual_top_m = UsualTop(std::move(high_enough));
  const double usual_m = walls.usual_top_m - floor_m;
  const double lowest_m = floor_m + std::max(LayoutOptions::kMinWallTop_m, kLowShare * usual_m);
  for (const SeenWall& wall : seen)
    walls.of_line.push_back(IsWall(wall, lowest_m, options) ? 1 : 0);
  return walls;
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
  const Walls found = FindWalls(profiles, floor_m, options);
  WallLines walls;
  for (std::size_t n = 0; n < candidates.size(); ++n) {
    if (found.of_line[n] == 0) continue;
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
  DropFurniture(found.usual_top_m, walls);
  return walls;
}

}  // namespace deepslam::layout

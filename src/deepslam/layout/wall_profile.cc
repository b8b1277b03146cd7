#include "deepslam/layout/wall_profile.h"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <functional>

namespace deepslam::layout {
namespace {

// Before and behind the face, in voxels: rays end a voxel and the noise before a surface, and a
// wall is thicker than two voxels.
constexpr double kBefore = 2.5;
constexpr double kWithin = 1.5;         // voxels
constexpr double kBehindFace = 4;       // voxels
constexpr double kMinWallFacing = 0.6;  // cosine between a vertex's normal and the face's
constexpr double kMaxVertical = 0.5;    // of a vertex's normal
constexpr double kThingDepth_m = 0.75;  // wardrobes are up to 70 cm deep, shelves and desks less
constexpr double kFootOfWall_m = 0.1;   // nothing is told of the wall where it meets the ground

std::size_t IndexOf(const WallProfile& profile, int slot, int row) {
  return static_cast<std::size_t>(slot) * static_cast<std::size_t>(profile.num_rows) +
         static_cast<std::size_t>(row);
}

void MarkSurface(const CoarseSurface& surface,
                 const WallLine& line,
                 const ProfileOptions& options,
                 WallProfile& profile) {
  const Eigen::Vector2f normal = line.normal.cast<float>();
  const Eigen::Vector2f along = line.along().cast<float>();
  const auto offset = static_cast<float>(line.offset_m);
  const auto thickness = static_cast<float>(options.thickness_m);
  const auto deepest = static_cast<float>(kThingDepth_m);
  std::vector<std::uint16_t> counts(profile.cells.size(), 0);
  for (std::size_t v = 0; v < surface.mesh.vertices.size(); ++v) {
    const Eigen::Vector3f& p = surface.mesh.vertices[v];
    const float off = normal.dot(p.head<2>()) - offset;
    if (off < -thickness || off > deepest) continue;
    const int slot = profile.SlotOf(static_cast<double>(along.dot(p.head<2>())));
    const int row =
        static_cast<int>(std::floor((static_cast<double>(p.z()) - profile.bottom_m) / kCell_m));
    if (slot < 0 || slot >= profile.num_slots || row < 0 || row >= profile.num_rows) continue;
    const std::size_t at = IndexOf(profile, slot, row);
    if (off > thickness) {
      profile.cells[at] |= kThing;
      continue;
    }
    const Eigen::Vector3f& facing = surface.normals[v];
    if (std::abs(static_cast<double>(facing.z())) > kMaxVertical ||
        static_cast<double>(facing.head<2>().dot(normal)) < kMinWallFacing)
      continue;
    profile.cells[at] |= kSolid | kFront;
    ++counts[at];
    profile.offset_m[at] += (off - profile.offset_m[at]) / static_cast<float>(counts[at]);
  }
}

std::uint8_t SpaceBits(const ObservedSpace& space,
                       const Eigen::Vector3d& p,
                       const Eigen::Vector3d& normal) {
  const double voxel_m = space.voxel_m();
  std::uint8_t bits = 0;
  if (space.Passed(p + kBefore * voxel_m * normal) > 0) bits |= kFront;
  const bool open = space.Passed(p) > 0 && space.Passed(p - kWithin * voxel_m * normal) > 0;
  if (open) bits |= kOpen;
  if (open && space.Passed(p - kBehindFace * voxel_m * normal) > 0) bits |= kBehind;
  constexpr int kFewestBlind = 2;  // rays without a measurement: a single one may be a stray
  if (!open && space.Blind(p) >= kFewestBlind) bits |= kBlind;
  return bits;
}

void MarkSpace(const CoarseSurface& surface, const WallLine& line, WallProfile& profile) {
  const Eigen::Vector3d normal(line.normal.x(), line.normal.y(), 0);
  for (int slot = 0; slot < profile.num_slots; ++slot) {
    const Eigen::Vector2d at = line.At(profile.PositionOf(slot) + 0.5 * kCell_m);
    for (int row = 0; row < profile.num_rows; ++row) {
      const Eigen::Vector3d p(at.x(), at.y(), profile.HeightOf(row) + 0.5 * kCell_m);
      std::uint8_t& cell = profile.cells[IndexOf(profile, slot, row)];
      std::uint8_t bits = SpaceBits(surface.space, p, normal);
      if ((cell & kSolid) != 0) bits &= static_cast<std::uint8_t>(~(kOpen | kBehind | kBlind));
      cell |= bits;
    }
  }
}

// Rows above the topmost wall of a slot that rays went through.
int NumOpenAbove(const WallProfile& profile, int slot) {
  int num_open = 0;
  for (int row = profile.num_rows - 1; row >= 0 && (profile.at(slot, row) & kSolid) == 0; --row)
    num_open += (profile.at(slot, row) & kOpen) != 0 ? 1 : 0;
  return num_open;
}

bool IsWall(const WallProfile& profile, int slot, const ProfileOptions& options) {
  int num_solid = 0;
  int top = -1;
  int top_seen = -1;
  const int first = std::max(0, static_cast<int>(kFootOfWall_m / kCell_m));
  for (int row = first; row < profile.num_rows; ++row) {
    const std::uint8_t cell = profile.at(slot, row);
    if ((cell & kSolid) != 0) {
      ++num_solid;
      top = row;
    }
    if ((cell & kFront) != 0) top_seen = row;
  }
  return num_solid * kCell_m >= options.min_solid_m &&
         NumOpenAbove(profile, slot) * kCell_m < options.max_open_above_m &&
         (top_seen - top) * kCell_m < options.max_below_seen_m;
}

void DropShortRuns(double min_run_m, WallProfile& profile) {
  for (const auto& [first, end] : profile.WallRuns()) {
    if ((end - first) * kCell_m >= min_run_m) continue;
    std::fill(profile.is_wall.begin() + first, profile.is_wall.begin() + end, std::uint8_t{0});
  }
}

// Fronts of furniture that reach nearly as high as anybody looked: what is over them is a strip too
// narrow to tell in one slot, but not in most of a run. Over walls rays go nowhere.
void DropSeenOver(WallProfile& profile) {
  for (const auto& [first, end] : profile.WallRuns()) {
    int num_seen_over = 0;
    for (int slot = first; slot < end; ++slot)
      num_seen_over += NumOpenAbove(profile, slot) > 0 ? 1 : 0;
    if (2 * num_seen_over <= end - first) continue;
    std::fill(profile.is_wall.begin() + first, profile.is_wall.begin() + end, std::uint8_t{0});
  }
}

}  // namespace

int WallProfile::SlotOf(double position_m) const {
  return static_cast<int>(std::floor((position_m - begin_m) / kCell_m));
}

double WallProfile::WallShare(double from_m, double to_m) const {
  const int first = static_cast<int>(std::lround((from_m - begin_m) / kCell_m));
  const int end = std::max(first + 1, static_cast<int>(std::lround((to_m - begin_m) / kCell_m)));
  int num_wall = 0;
  for (int slot = std::max(first, 0); slot < std::min(end, num_slots); ++slot)
    num_wall += is_wall[static_cast<std::size_t>(slot)];
  return static_cast<double>(num_wall) / (end - first);
}

double WallProfile::SeenTop(int first, int end) const {
  constexpr double kHighShare = 0.25;  // of the slots: where the camera looked up
  std::vector<double> tops_m;
  for (int slot = first; slot < end; ++slot) {
    if (is_wall[static_cast<std::size_t>(slot)] == 0) continue;
    int top = -1;
    for (int row = 0; row < num_rows; ++row) {
      if ((at(slot, row) & kSolid) != 0) top = row;
    }
    tops_m.push_back(HeightOf(top + 1));
  }
  if (tops_m.empty()) return bottom_m;
  std::ranges::sort(tops_m, std::greater());
  return tops_m[static_cast<std::size_t>(kHighShare * static_cast<double>(tops_m.size()))];
}

std::vector<std::pair<int, int>> WallProfile::WallRuns() const {
  std::vector<std::pair<int, int>> runs;
  for (int slot = 0; slot < num_slots; ++slot) {
    if (is_wall[static_cast<std::size_t>(slot)] == 0) continue;
    if (runs.empty() || runs.back().second != slot) runs.emplace_back(slot, slot);
    runs.back().second = slot + 1;
  }
  return runs;
}

WallProfile ProfileOf(const CoarseSurface& surface,
                      const WallLine& line,
                      const ProfileReach& reach,
                      const ProfileOptions& options) {
  WallProfile profile;
  profile.begin_m = reach.begin_m;
  profile.bottom_m = reach.bottom_m;
  profile.num_slots = std::max(0, static_cast<int>((reach.end_m - reach.begin_m) / kCell_m) + 1);
  profile.num_rows = std::max(0, static_cast<int>((reach.top_m - reach.bottom_m) / kCell_m) + 1);
  profile.cells.assign(
      static_cast<std::size_t>(profile.num_slots) * static_cast<std::size_t>(profile.num_rows), 0);
  profile.offset_m.assign(profile.cells.size(), 0);
  MarkSurface(surface, line, options, profile);
  MarkSpace(surface, line, profile);
  profile.is_wall.resize(static_cast<std::size_t>(profile.num_slots));
  for (int slot = 0; slot < profile.num_slots; ++slot) {
    profile.is_wall[static_cast<std::size_t>(slot)] = IsWall(profile, slot, options) ? 1 : 0;
  }
  DropShortRuns(options.min_run_m, profile);
  DropSeenOver(profile);
  return profile;
}

}  // namespace deepslam::layout

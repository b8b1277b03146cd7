// What was seen of a wall's face, in cells along it and up it: its surface, or that rays went
// through it, or nothing.
#pragma once

#include <cstddef>
#include <cstdint>
#include <utility>
#include <vector>

#include "deepslam/layout/wall_line.h"
#include "deepslam/scene/coarse_surface.h"

namespace deepslam::layout {

// Larger than a voxel, so that wall leaves no cell empty.
inline constexpr double kCell_m = 0.05;

// Bits of a cell.
enum FaceCell : std::uint8_t {
  kSolid = 1,    // a surface lies in the face
  kOpen = 2,     // rays went through it, and nothing lies there
  kFront = 4,    // the space before it was looked into, or its surface was seen
  kBlind = 8,    // it was looked at, and nothing was measured there
  kBehind = 16,  // rays went on well behind it
  kThing = 32,   // a surface stands before it, no further off than furniture at a wall is deep
};

// Cells of kCell_m: slot s begins at begin_m + s * kCell_m along the line, row r at
// bottom_m + r * kCell_m.
struct WallProfile {
  double begin_m = 0;
  double bottom_m = 0;
  int num_slots = 0;
  int num_rows = 0;
  std::vector<std::uint8_t> cells;  // rows running fastest
  std::vector<float> offset_m;      // of what is solid, mean over it: before the line, or behind it
  std::vector<std::uint8_t> is_wall;  // per slot: a wall stands there

  [[nodiscard]] std::uint8_t at(int slot, int row) const {
    return cells[static_cast<std::size_t>(slot) * static_cast<std::size_t>(num_rows) +
                 static_cast<std::size_t>(row)];
  }
  [[nodiscard]] double OffsetAt(int slot, int row) const {
    return static_cast<double>(
        offset_m[static_cast<std::size_t>(slot) * static_cast<std::size_t>(num_rows) +
                 static_cast<std::size_t>(row)]);
  }
  // The slot of a position along the line; it may lie outside.
  [[nodiscard]] int SlotOf(double position_m) const;
  [[nodiscard]] double PositionOf(int slot) const { return begin_m + slot * kCell_m; }
  [[nodiscard]] double HeightOf(int row) const { return bottom_m + row * kCell_m; }
  // Share of [from_m, to_m] where a wall stands.
  [[nodiscard]] double WallShare(double from_m, double to_m) const;
  // Height that a quarter of the wall in slots [first, end) was seen to; the bottom without any.
  [[nodiscard]] double SeenTop(int first, int end) const;
  // Runs of slots where a wall stands, as [first, end).
  [[nodiscard]] std::vector<std::pair<int, int>> WallRuns() const;
};

struct ProfileOptions {
  double thickness_m = 0.10;  // surface this near the line, and facing as it does, is the wall's
  double min_solid_m = 0.25;  // of a slot's height that has to be wall: a lintel is no less
  double max_open_above_m = 0.15;  // rays through the face above the wall: then it is furniture
  double max_below_seen_m = 0.30;  // it ends this far below what was looked at before it, at most
  double min_run_m = 0.15;         // shorter pieces of wall are none
};

// Heights from `bottom_m` to `top_m`; positions from `begin_m` to `end_m` along the line.
struct ProfileReach {
  double begin_m = 0;
  double end_m = 0;
  double bottom_m = 0;
  double top_m = 0;
};
[[nodiscard]] WallProfile ProfileOf(const CoarseSurface& surface,
                                    const WallLine& line,
                                    const ProfileReach& reach,
                                    const ProfileOptions& options);

}  // namespace deepslam::layout

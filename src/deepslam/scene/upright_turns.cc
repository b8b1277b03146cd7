#include "deepslam/scene/upright_turns.h"

#include <algorithm>
#include <array>
#include <cstddef>
#include <optional>

#include "deepslam/geometry/upright.h"

namespace deepslam {
namespace {

std::optional<QuarterTurn> TurnOf(const TrackedFrame& frame, const Ground& ground) {
  const std::optional<Plane> plane = GroundInCamera(ground, frame.frame, frame.world_from_camera);
  return plane ? UprightTurn(plane->normal) : QuarterTurn::kNone;
}

QuarterTurn MostCommon(std::span<const std::optional<QuarterTurn>> turns) {
  std::array<std::size_t, 4> counts{};
  for (const std::optional<QuarterTurn>& turn : turns) {
    if (turn) ++counts[static_cast<std::size_t>(*turn)];
  }
  return static_cast<QuarterTurn>(std::ranges::max_element(counts) - counts.begin());
}

}  // namespace

std::vector<QuarterTurn> UprightTurns(std::span<const TrackedFrame> frames, const Ground& ground) {
  std::vector<std::optional<QuarterTurn>> told;
  for (const TrackedFrame& frame : frames) told.push_back(TurnOf(frame, ground));
  std::vector<QuarterTurn> turns;
  QuarterTurn last = MostCommon(told);
  for (const std::optional<QuarterTurn>& turn : told) {
    last = turn.value_or(last);
    turns.push_back(last);
  }
  return turns;
}

}  // namespace deepslam

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
  return plane ? UprightTurn(plane->normal) : ground.upright;
}

}  // namespace

QuarterTurn MostCommon(std::span<const QuarterTurn> turns) {
  std::array<std::size_t, 4> counts{};
  for (const QuarterTurn turn : turns) ++counts[static_cast<std::size_t>(turn)];
  return static_cast<QuarterTurn>(std::ranges::max_element(counts) - counts.begin());
}

std::vector<QuarterTurn> UprightTurns(std::span<const TrackedFrame> frames, const Ground& ground) {
  std::vector<std::optional<QuarterTurn>> turns;
  std::vector<QuarterTurn> told;
  for (const TrackedFrame& frame : frames) {
    turns.push_back(TurnOf(frame, ground));
    if (turns.back()) told.push_back(*turns.back());
  }
  std::vector<QuarterTurn> filled;
  QuarterTurn last = told.empty() ? ground.upright.value_or(QuarterTurn::kNone) : MostCommon(told);
  for (const std::optional<QuarterTurn>& turn : turns) {
    last = turn.value_or(last);
    filled.push_back(last);
  }
  return filled;
}

QuarterTurn UprightTurnIn(const OptimizedMap& map, FrameIdx frame) {
  if (!map.has_ground) return map.upright.value_or(QuarterTurn::kNone);
  const Pose3& world_from_camera =
      map.frames[static_cast<std::size_t>(frame.value)].world_from_camera;
  return UprightTurn(world_from_camera.rotation.inverse() * Eigen::Vector3d::UnitZ())
      .value_or(QuarterTurn::kNone);
}

}  // namespace deepslam

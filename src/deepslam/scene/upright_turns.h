// How pictures have to be turned to stand upright: phones and tablets record them lying on their
// side, and detectors know furniture that stands.
#pragma once

#include <span>
#include <vector>

#include "deepslam/core/quarter_turn.h"
#include "deepslam/scene/ground.h"
#include "deepslam/scene/optimized_map.h"
#include "deepslam/scene/trajectory.h"

namespace deepslam {

// One per frame, by where the ground lies from its camera; where no ground is known, as the user
// says. Pictures of which neither tells it (a ground that is seen from steeply above does not) are
// turned as the ones before, the first ones as most are. Nothing is turned where nothing tells.
[[nodiscard]] std::vector<QuarterTurn> UprightTurns(std::span<const TrackedFrame> frames,
                                                    const Ground& ground);

// The same of one frame in the final world. Nothing is turned that looks steeply up or down on a
// ground.
[[nodiscard]] QuarterTurn UprightTurnIn(const OptimizedMap& map, FrameIdx frame);

// The first of those that are as many; nothing is turned where there are none.
[[nodiscard]] QuarterTurn MostCommon(std::span<const QuarterTurn> turns);

}  // namespace deepslam

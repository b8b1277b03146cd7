// How the camera was held: phones and tablets are often held on their side or upside down, and
// record pictures that lie so. Then a wall lies where the floor would be.
//
// The ground is looked for with the pictures as they are, and where that does not convince, with
// each quarter turn. A floor stays below the camera wherever it turns, and a wall does not.
#pragma once

#include <span>

#include "deepslam/core/quarter_turn.h"
#include "deepslam/ground/ground_plane.h"

namespace deepslam::ground {

// What speaks for a ground that was found by pictures turned so.
struct Holding {
  double held_share = 0;       // of the keyframes: they stand to it as the options permit
  double seen_share = 0;       // of the keyframes: they see it
  double headings_deg = 0;     // how far round its normal the keyframes look
  double roll_spread_deg = 0;  // of its normal in the pictures: a hand keeps the horizon level
};

[[nodiscard]] Holding MeasureHolding(const Ground& ground,
                                     std::span<const TrackedFrame> keyframes,
                                     QuarterTurn upright);

// Nothing else need be looked for.
[[nodiscard]] bool Convinces(const Holding& holding);

// Otherwise it is a wall that some of the keyframes could take for a floor.
[[nodiscard]] bool IsPossible(const Holding& holding);

// How much speaks for it, 0 to 1.
[[nodiscard]] double Evidence(const Holding& holding);

// Whether pictures turned by `turn` against what was taken for granted are to be accepted. Half a
// turn makes a floor of each ceiling, so that next to nothing may speak against it.
[[nodiscard]] bool Outweighs(const Holding& turned, QuarterTurn turn, const Holding& as_is);

}  // namespace deepslam::ground

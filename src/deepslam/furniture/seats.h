// Parts of what one sits on: a seat, its back, its arms.
#pragma once

#include "deepslam/core/random.h"
#include "deepslam/furniture/solids.h"

namespace deepslam::furniture {

struct Seat {
  double depth = 0;   // along x
  double width = 0;   // along y
  double height = 0;  // of its upper side
  double thickness = 0;
  double corner = 1;  // where its rim crosses the diagonal, as a share of the corner's distance
};

// Board, plate, cushion or hollow shell of plywood; changes thickness and corner to what it drew.
void SeatBoard(Random& random, Seat& seat, Solids& solids);
// Back of boards, slats, rungs, padding or bent wood, behind the seat (-x); `on_column`: as on a
// chair that turns, on one post at times.
void SeatBack(Random& random, const Seat& seat, bool on_column, Solids& solids);
// On posts or of bent tube, at both sides of the seat.
void SeatArms(Random& random, const Seat& seat, double back_lean, Solids& solids);

}  // namespace deepslam::furniture

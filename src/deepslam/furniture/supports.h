// What furniture stands on.
#pragma once

#include <Eigen/Core>

#include "deepslam/core/random.h"
#include "deepslam/furniture/solids.h"

namespace deepslam::furniture {

// Where legs carry something: its depth (x) and width (y), and the height of its underside.
struct Footing {
  Eigen::Vector2d size;
  double height = 0;
  double inset = 0;  // of the legs from the rim
};

// How far from the middle the rim of a plate or cushion of this roundness (solids.h) crosses the
// diagonal, as a share of its box's corner: legs stand within.
[[nodiscard]] double CornerShare(double roundness);

// Where four legs stand.
struct LegPlan {
  Eigen::Vector2d half = Eigen::Vector2d::Zero();  // from the middle, at the top
  double splay = 0;                                // how much farther at the floor
  double height = 1;

  [[nodiscard]] Eigen::Vector2d HalfAt(double z) const {
    return half.array() + splay * (1 - z / height);
  }
};

// Four legs (square, tapered, round, turned or splayed), with stretchers and an apron or without.
LegPlan FourLegs(Random& random, const Footing& footing, Solids& solids);
// Two frames of bent tube: sledges, or cantilevers open at the back.
void Sledges(Random& random, const Footing& footing, Solids& solids);
// Column on a star of four or five arms with castors or glides.
void Star(Random& random, double height, double radius, Solids& solids);
// Column on a round plate.
void Pedestal(Random& random, double height, double radius, Solids& solids);
// Short feet below a body: blocks, cones or a plinth, from the floor to `footing.height`.
void Feet(Random& random, const Footing& footing, Solids& solids);

}  // namespace deepslam::furniture

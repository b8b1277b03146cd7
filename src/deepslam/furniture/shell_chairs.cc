// Chairs whose seat and back are one shell: of plastic or plywood, or padded.
#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>
#include <vector>

#include "deepslam/furniture/draw.h"
#include "deepslam/furniture/kinds.h"
#include "deepslam/furniture/supports.h"

namespace deepslam::furniture {
namespace {

// Seen from the side: from the lip of the seat back to its rear, round a bend, up to the top.
struct Shell {
  double depth = 0;
  double width = 0;
  double seat = 0;  // height of the lip
  double top = 0;
  double lean = 0;       // of the back, per height
  double dip = 0;        // of the seat's rear below the lip
  double bend = 0;       // radius, as a share of what there is
  double wing = 0;       // how far the sides rise
  double wing_from = 0;  // share of the profile where they begin
  double narrow = 0;     // of the top's width
  double thickness = 0;
};

Shell DrawShell(Random& random) {
  Shell shell;
  const bool lounge = Chance(random, 0.3);
  shell.depth = lounge ? random.Uniform(0.5, 0.68) : random.Uniform(0.38, 0.5);
  shell.width = lounge ? random.Uniform(0.55, 0.8) : random.Uniform(0.4, 0.58);
  shell.seat = lounge ? random.Uniform(0.34, 0.43) : random.Uniform(0.42, 0.5);
  shell.top = shell.seat + (lounge ? random.Uniform(0.35, 0.65) : random.Uniform(0.3, 0.48));
  shell.lean = random.Uniform(0.08, lounge ? 0.55 : 0.3);
  shell.dip = random.Uniform(0.0, 0.06);
  shell.bend = random.Uniform(0.2, 1.0);
  shell.wing = Chance(random, 0.6) ? random.Uniform(0.04, 0.24) : random.Uniform(0.0, 0.03);
  shell.wing_from = random.Uniform(0.1, 0.45);
  shell.narrow = random.Uniform(0.55, 1.05);
  shell.thickness = Chance(random, 0.6) ? random.Uniform(0.012, 0.03) : random.Uniform(0.03, 0.12);
  return shell;
}

// Middle of the shell at t from 0 (lip) to 1 (top): a path of two lines with the corner cut round.
Eigen::Vector2d ProfileAt(const Shell& shell, double t) {
  const Eigen::Vector2d lip(0.5 * shell.depth, shell.seat);
  const Eigen::Vector2d corner(-0.5 * shell.depth, shell.seat - shell.dip);
  const Eigen::Vector2d top(-0.5 * shell.depth - shell.lean * (shell.top - shell.seat), shell.top);
  const double seat_share = 0.5;
  const double round = 0.45 * shell.bend;
  const auto straight = [&](double s) -> Eigen::Vector2d {
    return s < seat_share ? lip + (corner - lip) * (s / seat_share)
                          : corner + (top - corner) * ((s - seat_share) / (1 - seat_share));
  };
  const double from = seat_share - round;
  const double to = seat_share + round;
  if (t <= from || t >= to) return straight(t);
  const double s = (t - from) / (to - from);
  const Eigen::Vector2d a = straight(from);
  const Eigen::Vector2d b = straight(to);
  return (1 - s) * (1 - s) * a + 2 * s * (1 - s) * corner + s * s * b;
}

Solids::Ring RingAt(const Shell& shell, double t) {
  constexpr int kPointsAcross = 13;  // points across the shell; odd, so that one lies in the middle
  // Of the profile's length, on either side: for its direction.
  constexpr double kProfileStep = 1e-3;
  const Eigen::Vector2d at = ProfileAt(shell, t);
  const Eigen::Vector2d along = (ProfileAt(shell, std::min(1.0, t + kProfileStep)) -
                                 ProfileAt(shell, std::max(0.0, t - kProfileStep)))
                                    .normalized();
  const Eigen::Vector2d inward(along.y(), -along.x());  // up from the seat, forward from the back
  const double share = std::clamp((t - shell.wing_from) / (1 - shell.wing_from), 0.0, 1.0);
  const double rise = shell.wing * std::pow(std::sin(std::numbers::pi * share), 0.7);
  const double half = 0.5 * shell.width *
                      (t < 0.5 ? 0.85 + 0.3 * t : 1 + (shell.narrow - 1) * (2 * t - 1)) *
                      (t < 0.06 || t > 0.94 ? 0.9 : 1.0);
  Solids::Ring inner, outer;
  for (int n = 0; n < kPointsAcross; ++n) {
    const double u = 2.0 * n / (kPointsAcross - 1) - 1;
    const double lift = rise * std::pow(std::abs(u), 2.5);
    const Eigen::Vector2d in = at + (lift + 0.5 * shell.thickness) * inward;
    const Eigen::Vector2d out = at + (lift - 0.5 * shell.thickness) * inward;
    inner.push_back({in.x(), u * half, in.y()});
    outer.push_back({out.x(), u * half, out.y()});
  }
  inner.insert(inner.end(), outer.rbegin(), outer.rend());
  return inner;
}

}  // namespace

void BuildShellChair(Random& random, Solids& solids) {
  const Shell shell = DrawShell(random);
  constexpr int kShellRings = 19;  // from the front edge to the top: bends look round at 64 voxels
  std::vector<Solids::Ring> rings;
  for (int n = 0; n < kShellRings; ++n) rings.push_back(RingAt(shell, n / (kShellRings - 1.0)));
  solids.Loft(Material::kTop, rings);
  // A plate below the seat carries it.
  const Eigen::Vector2d middle = ProfileAt(shell, 0.25);
  const double plate = random.Uniform(0.02, 0.05);
  const double top = middle.y() - 0.5 * shell.thickness + 0.015 + 0.25 * shell.dip;
  const Eigen::Vector2d size(random.Uniform(0.5, 0.8) * shell.depth,
                             random.Uniform(0.4, 0.75) * shell.width);
  solids.Box(Material::kDetail, {0, 0, top - 0.5 * plate}, {size.x(), size.y(), plate});
  const double underside = top - 0.5 * plate;
  const std::size_t base = Pick(random, std::array{1.0, 0.25, 0.3, 0.45});
  if (base == 0) {
    FourLegs(random, {size, underside, 0.0}, solids);
  } else if (base == 1) {
    Sledges(random, {size, underside, 0.0}, solids);
  } else if (base == 2) {
    Star(random, underside, random.Uniform(0.24, 0.34), solids);
  } else {
    Pedestal(random, underside, random.Uniform(0.2, 0.32), solids);
  }
}

}  // namespace deepslam::furniture

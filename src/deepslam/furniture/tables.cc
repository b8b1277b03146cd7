// Tables and desks. Their long side is along y; one sits at a desk's front, +x.
#include <algorithm>
#include <array>
#include <cmath>

#include "deepslam/furniture/draw.h"
#include "deepslam/furniture/kinds.h"
#include "deepslam/furniture/supports.h"

namespace deepslam::furniture {
namespace {

struct Top {
  double depth = 0;  // along x
  double width = 0;  // along y
  double height = 0;
  double thickness = 0;
};

double DrawHeight(Random& random) {
  return Chance(random, 0.6) ? random.Uniform(0.68, 0.8) : random.Uniform(0.32, 0.62);
}

void Trestles(Random& random, const Top& top, Solids& solids) {
  const double thickness = random.Uniform(0.02, 0.08);
  const double underside = top.height - top.thickness + 0.005;
  const double depth = top.depth * random.Uniform(0.55, 0.95);
  const std::size_t kind = Pick(random, std::array{1.0, 0.7, 0.7, 0.6});
  for (const double side : kSides) {
    const double y = side * 0.5 * top.width * 0.82;
    if (kind == 0) {  // panel
      solids.Box(Material::kFrame, {0, y, 0.5 * underside}, {depth, thickness, underside});
    } else if (kind == 1) {  // A
      for (const double end : kSides)
        solids.Tube(Material::kFrame,
                    {{end * 0.5 * depth, y, 0}, {end * 0.08, y, underside}},
                    0.45 * thickness + 0.008,
                    0.45 * thickness + 0.008);
    } else if (kind == 2) {  // frame
      const double r = 0.5 * thickness;
      for (const double end : kSides)
        solids.Box(Material::kFrame,
                   {end * (0.5 * depth - r), y, 0.5 * underside},
                   {thickness, thickness, underside});
      solids.Box(Material::kFrame, {0, y, r}, {depth, thickness, thickness});
    } else {  // T
      solids.Box(Material::kFrame, {0, y, 0.5 * underside}, {0.07, thickness, underside});
      solids.Box(Material::kFrame, {0, y, 0.025}, {depth, 0.06, 0.05});
    }
  }
  if (Chance(random, 0.5)) {
    const double bar = random.Uniform(0.03, 0.16);
    // Where the middle of the trestles is open the bar runs right below the top.
    const bool open = kind == 1 || kind == 2;
    const double z = open ? underside - 0.5 * bar : underside * random.Uniform(0.35, 0.8);
    solids.Box(Material::kFrame, {0, 0, z}, {0.03, 0.82 * top.width, bar});
  }
}

void CrossedLegs(const Top& top, double thickness, Solids& solids) {
  const double underside = top.height - top.thickness + 0.005;
  for (const double side : kSides) {
    for (const double way : kSides) {
      const double x = 0.42 * top.depth;
      solids.Tube(
          Material::kFrame,
          {{way * x, side * 0.4 * top.width, 0}, {-way * x, side * 0.4 * top.width, underside}},
          thickness,
          thickness);
    }
  }
}

// Between the legs.
void LowerShelf(Random& random, const LegPlan& legs, bool round, Solids& solids) {
  const double z = legs.height * random.Uniform(0.15, 0.5);
  const Eigen::Vector2d half = legs.HalfAt(z);
  const double thickness = random.Uniform(0.012, 0.03);
  if (round) {
    const double out = 1.0 / CornerShare(1.0);
    solids.Plate(
        Material::kTop, {0, 0, z}, {2 * out * half.x(), 2 * out * half.y(), thickness}, 1.0);
  } else {
    solids.Box(Material::kTop, {0, 0, z}, {2 * half.x(), 2 * half.y(), thickness});
  }
}

// Box with drawers below a top, at the left (side 1) or right (-1).
void Drawers(Random& random, const Top& top, double side, Solids& solids) {
  const double width = std::min(0.45, top.width * random.Uniform(0.25, 0.34));
  const double depth = top.depth * random.Uniform(0.8, 0.96);
  const double underside = top.height - top.thickness + 0.005;
  const double low =
      Chance(random, 0.6) ? random.Uniform(0.0, 0.12) : underside * random.Uniform(0.4, 0.7);
  const double y = side * (0.5 * top.width - 0.5 * width - 0.02);
  solids.Box(Material::kBody, {0, y, 0.5 * (low + underside)}, {depth, width, underside - low});
  const int count = Count(random, 1, 4);
  for (int n = 0; n < count; ++n) {
    const double height = (underside - low) / count;
    const double z = low + height * (n + 0.5);
    solids.Box(Material::kTop, {0.5 * depth + 0.006, y, z}, {0.014, width - 0.02, height - 0.02});
    solids.Box(Material::kDetail, {0.5 * depth + 0.022, y, z}, {0.02, 0.3 * width, 0.015});
  }
}

}  // namespace

void BuildTable(Random& random, Solids& solids) {
  Top top;
  top.width = random.Uniform(0.5, 2.0);
  top.depth = std::clamp(top.width * random.Uniform(0.4, 1.0), 0.35, 1.1);
  if (Chance(random, 0.15)) top.depth = top.width = random.Uniform(0.45, 1.1);
  top.height = DrawHeight(random);
  top.thickness = random.Uniform(0.014, 0.07);
  const Eigen::Vector3d size(top.depth, top.width, top.thickness);
  const Eigen::Vector3d middle(0, 0, top.height - 0.5 * top.thickness);
  double corner = 1;
  if (Chance(random, 0.75)) {
    solids.Box(Material::kTop, middle, size);
  } else {
    const double roundness = random.Uniform(0.12, 0.5);
    corner = CornerShare(roundness);
    solids.Plate(Material::kTop, middle, size, roundness);
  }
  const double underside = top.height - top.thickness + 0.005;
  const std::size_t base = Pick(random, std::array{1.0, 0.3, 0.08, 0.08, 0.06, 0.05});
  if (base == 0) {
    const LegPlan legs = FourLegs(
        random,
        {corner * Eigen::Vector2d(top.depth, top.width), underside, random.Uniform(0.0, 0.09)},
        solids);
    if (Chance(random, 0.2)) LowerShelf(random, legs, false, solids);
  } else if (base == 1) {
    Trestles(random, top, solids);
  } else if (base == 2) {
    Pedestal(random, underside, random.Uniform(0.25, 0.4) * top.depth, solids);
  } else if (base == 3) {
    CrossedLegs(top, random.Uniform(0.012, 0.035), solids);
  } else if (base == 4) {
    solids.Box(
        Material::kBody,
        {0, 0, 0.5 * underside},
        {top.depth * random.Uniform(0.6, 0.98), top.width * random.Uniform(0.6, 0.98), underside});
  } else {
    const double plate = 0.3 * top.depth;
    for (const double side : kSides) {
      const Eigen::Vector3d foot(0, side * 0.3 * top.width, 0);
      solids.Turned(Material::kFrame,
                    foot,
                    {{plate, 0}, {plate, 0.03}, {0.045, 0.05}, {0.045, underside}},
                    16);
    }
  }
}

void BuildRoundTable(Random& random, Solids& solids) {
  Top top;
  top.width = random.Uniform(0.4, 1.4);
  top.depth =
      Chance(random, 0.7) ? top.width : std::max(0.38, top.width * random.Uniform(0.55, 1.0));
  top.height = DrawHeight(random);
  top.thickness = random.Uniform(0.014, 0.06);
  solids.Plate(Material::kTop,
               {0, 0, top.height - 0.5 * top.thickness},
               {top.depth, top.width, top.thickness},
               1.0);
  const double underside = top.height - top.thickness + 0.005;
  const std::size_t base = Pick(random, std::array{1.0, 0.9, 0.15, 0.2});
  const Eigen::Vector2d inner = CornerShare(1.0) * Eigen::Vector2d(top.depth, top.width);
  if (base == 0) {
    const LegPlan legs = FourLegs(random, {inner, underside, 0.0}, solids);
    if (Chance(random, 0.2)) LowerShelf(random, legs, true, solids);
  } else if (base == 1) {
    Pedestal(random, underside, random.Uniform(0.22, 0.38) * top.depth, solids);
  } else if (base == 2) {
    solids.Plate(Material::kBody,
                 {0, 0, 0.5 * underside},
                 {0.85 * top.depth, 0.85 * top.width, underside},
                 1.0);
  } else {
    const double r = random.Uniform(0.012, 0.03);
    const double first = random.Uniform(0, 6.28);
    for (int n = 0; n < 3; ++n) {
      const double angle = first + 6.2831853 * n / 3;
      const Eigen::Vector2d out(std::cos(angle), std::sin(angle));
      const Eigen::Vector2d foot = 0.42 * out.cwiseProduct(Eigen::Vector2d(top.depth, top.width));
      const Eigen::Vector2d head = random.Uniform(0.5, 0.9) * foot;
      solids.Tube(
          Material::kFrame, {{foot.x(), foot.y(), 0}, {head.x(), head.y(), underside}}, 0.7 * r, r);
    }
  }
}

void BuildDesk(Random& random, Solids& solids) {
  Top top;
  top.width = random.Uniform(0.9, 1.9);
  top.depth = random.Uniform(0.45, 0.9);
  top.height = random.Uniform(0.68, 0.78);
  top.thickness = random.Uniform(0.016, 0.05);
  solids.Box(Material::kTop,
             {0, 0, top.height - 0.5 * top.thickness},
             {top.depth, top.width, top.thickness});
  const double underside = top.height - top.thickness + 0.005;
  const bool sides = Chance(random, 0.5);
  if (sides) {
    const double thickness = random.Uniform(0.016, 0.04);
    for (const double side : kSides)
      solids.Box(Material::kBody,
                 {0, side * (0.5 * top.width - 0.5 * thickness), 0.5 * underside},
                 {0.96 * top.depth, thickness, underside});
  } else {
    FourLegs(random, {{top.depth, top.width}, underside, random.Uniform(0.0, 0.05)}, solids);
  }
  if (Chance(random, 0.5)) {
    const double height = underside * random.Uniform(0.3, 0.8);
    solids.Box(Material::kBody,
               {-0.5 * top.depth + 0.05, 0, underside - 0.5 * height},
               {0.018, top.width - 0.06, height});
  }
  const double side = Chance(random, 0.5) ? 1.0 : -1.0;
  if (Chance(random, 0.7)) Drawers(random, top, side, solids);
  if (Chance(random, 0.25)) Drawers(random, top, -side, solids);
  if (Chance(random, 0.2)) {  // shelf at the rear edge
    const double height = random.Uniform(0.12, 0.4);
    const double depth = random.Uniform(0.15, 0.25);
    const double x = -0.5 * top.depth + 0.5 * depth;
    solids.Box(Material::kBody, {x, 0, top.height + height}, {depth, top.width, 0.02});
    for (const double end : kSides)
      solids.Box(Material::kBody,
                 {x, end * (0.5 * top.width - 0.01), top.height + 0.5 * height},
                 {depth, 0.02, height + 0.02});
  }
}

}  // namespace deepslam::furniture

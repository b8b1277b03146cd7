#include "deepslam/furniture/supports.h"

#include <array>
#include <cmath>
#include <numbers>
#include <vector>

#include "deepslam/furniture/draw.h"

namespace deepslam::furniture {
namespace {

struct LegStyle {
  std::size_t kind = 0;  // square, tapered, round, splayed round, turned, splayed square
  double top = 0;        // thickness
  double bottom = 0;
  double splay = 0;
};

LegStyle DrawLegStyle(Random& random) {
  LegStyle style;
  style.kind = Pick(random, std::array{3.0, 2.0, 1.5, 1.5, 0.8, 1.0});
  style.top = random.Uniform(0.022, 0.062);
  style.bottom = style.top;
  if (style.kind == 1 || style.kind == 3) style.bottom *= random.Uniform(0.45, 0.85);
  if (style.kind == 3 || style.kind == 5) style.splay = random.Uniform(0.02, 0.09);
  return style;
}

void Leg(const LegStyle& style,
         const Eigen::Vector3d& foot,
         const Eigen::Vector3d& head,
         Solids& solids) {
  if (style.kind == 2 || style.kind == 3) {
    solids.Tube(Material::kFrame, {foot, head}, 0.5 * style.bottom, 0.5 * style.top, 10);
    return;
  }
  if (style.kind == 4) {
    const double r = 0.5 * style.top;
    const double h = head.z();
    std::vector<Eigen::Vector2d> profile = {{0.6 * r, 0},
                                            {0.6 * r, 0.1 * h},
                                            {r, 0.22 * h},
                                            {0.7 * r, 0.34 * h},
                                            {r, 0.6 * h},
                                            {0.65 * r, 0.74 * h},
                                            {r, 0.8 * h},
                                            {r, h}};
    solids.Turned(Material::kFrame, foot, profile, 10);
    return;
  }
  solids.Frustum(
      Material::kFrame, foot, {style.bottom, style.bottom}, head, {style.top, style.top});
}

// Bars between the legs at one height; `half` is where the legs stand at that height.
void Stretchers(
    Random& random, const Eigen::Vector2d& half, double height, double thickness, Solids& solids) {
  const bool round = Chance(random, 0.4);
  const auto bar = [&](const Eigen::Vector3d& from, const Eigen::Vector3d& to) {
    if (round) {
      solids.Tube(Material::kFrame, {from, to}, 0.5 * thickness, 0.5 * thickness);
      return;
    }
    const Eigen::Vector3d size = (to - from).cwiseAbs() + Eigen::Vector3d::Constant(thickness);
    solids.Box(Material::kFrame, 0.5 * (from + to), size);
  };
  const std::size_t layout = Pick(random, std::array{1.0, 1.0, 0.6, 0.4});
  const double second = height * random.Uniform(0.75, 1.25);
  for (const double side : kSides) {
    bar({-half.x(), side * half.y(), height}, {half.x(), side * half.y(), height});
    if (layout == 1) bar({side * half.x(), -half.y(), second}, {side * half.x(), half.y(), second});
  }
  if (layout == 0) bar({0, -half.y(), height}, {0, half.y(), height});
  if (layout == 2) bar({-half.x(), -half.y(), second}, {-half.x(), half.y(), second});
}

}  // namespace

double CornerShare(double roundness) { return std::pow(0.5, 0.5 * roundness); }

LegPlan FourLegs(Random& random, const Footing& footing, Solids& solids) {
  const LegStyle style = DrawLegStyle(random);
  const Eigen::Vector2d half =
      0.5 * footing.size - Eigen::Vector2d::Constant(footing.inset + 0.5 * style.top);
  const LegPlan plan = {half, style.splay, footing.height};
  for (const double x : kSides) {
    for (const double y : kSides) {
      const Eigen::Vector3d head(x * half.x(), y * half.y(), footing.height);
      Leg(style, {head.x() + x * style.splay, head.y() + y * style.splay, 0}, head, solids);
    }
  }
  if (Chance(random, 0.4)) {
    const double height = footing.height * random.Uniform(0.15, 0.6);
    Stretchers(random, plan.HalfAt(height), height, 0.6 * style.top, solids);
  }
  if (Chance(random, 0.5)) {
    const double depth = random.Uniform(0.03, 0.09);
    const double z = footing.height - 0.5 * depth;
    for (const double side : kSides) {
      solids.Box(Material::kFrame, {0, side * half.y(), z}, {2 * half.x(), 0.6 * style.top, depth});
      solids.Box(Material::kFrame, {side * half.x(), 0, z}, {0.6 * style.top, 2 * half.y(), depth});
    }
  }
  return plan;
}

void Sledges(Random& random, const Footing& footing, Solids& solids) {
  const double r = random.Uniform(0.009, 0.018);
  const double x = 0.5 * footing.size.x() - 0.02;
  const double y = 0.5 * footing.size.y() - r;
  const double top = footing.height;
  const double bend = random.Uniform(0.03, 0.08);
  const bool cantilever = Chance(random, 0.5);
  for (const double side : kSides) {
    const double at = side * y;
    std::vector<Eigen::Vector3d> line;
    if (cantilever) {
      line = {{-x, at, top},
              {x - bend, at, top},
              {x, at, top - bend},
              {x, at, r + bend},
              {x - bend, at, r},
              {-x, at, r}};
    } else {
      const double lean = random.Uniform(0.0, 0.06);
      line = {{x - bend - lean, at, top},
              {x, at, r + bend},
              {x - bend, at, r},
              {-x + bend, at, r},
              {-x, at, r + bend},
              {-x + bend + lean, at, top}};
    }
    solids.Tube(Material::kFrame, line, r, r);
  }
  if (cantilever || Chance(random, 0.5))
    solids.Tube(Material::kFrame, {{-x, -y, r}, {-x, y, r}}, r, r);
  if (Chance(random, 0.5)) solids.Box(Material::kFrame, {0, 0, top - r}, {0.04, 2 * y, 2 * r});
}

void Star(Random& random, double height, double radius, Solids& solids) {
  const int arms = Chance(random, 0.25) ? 4 : 5;
  const double hub = random.Uniform(0.06, 0.12);
  const double first = random.Uniform(0, 2 * std::numbers::pi);
  const bool castors = Chance(random, 0.8);
  for (int n = 0; n < arms; ++n) {
    const double angle = first + 2 * std::numbers::pi * n / arms;
    const Eigen::Vector2d tip(radius * std::cos(angle), radius * std::sin(angle));
    solids.Tube(Material::kFrame,
                {{0, 0, hub + 0.02}, {tip.x(), tip.y(), castors ? 0.07 : 0.03}},
                0.026,
                0.016);
    if (castors) {
      solids.Cushion(Material::kDetail, {tip.x(), tip.y(), 0.03}, {0.05, 0.05, 0.06}, 1, 1);
    } else {
      solids.Tube(
          Material::kDetail, {{tip.x(), tip.y(), 0}, {tip.x(), tip.y(), 0.03}}, 0.018, 0.018);
    }
  }
  const double column = random.Uniform(0.018, 0.04);
  solids.Turned(Material::kFrame,
                {0, 0, hub - 0.02},
                {{1.4 * column, 0},
                 {1.4 * column, 0.5 * (height - hub)},
                 {column, 0.5 * (height - hub)},
                 {column, height - hub + 0.02}});
}

void Pedestal(Random& random, double height, double radius, Solids& solids) {
  const double plate = random.Uniform(0.012, 0.04);
  const double column = random.Uniform(0.02, 0.05) * (radius > 0.25 ? 1.6 : 1.0);
  const std::size_t shape = Pick(random, std::array{1.0, 0.7, 0.4});
  if (shape == 0) {
    solids.Turned(Material::kFrame, {0, 0, 0}, {{radius, 0}, {radius, plate}}, 24);
    solids.Turned(
        Material::kFrame, {0, 0, 0.5 * plate}, {{column, 0}, {column, height - 0.5 * plate}});
    return;
  }
  if (shape == 1) {  // tulip
    solids.Turned(Material::kFrame,
                  {0, 0, 0},
                  {{radius, 0},
                   {0.9 * radius, plate},
                   {1.4 * column, 0.22 * height},
                   {column, 0.5 * height},
                   {1.3 * column, 0.85 * height},
                   {2.2 * column, height}},
                  24);
    return;
  }
  // Cross of two beams.
  solids.Box(Material::kFrame, {0, 0, 0.5 * plate + 0.01}, {2 * radius, 0.07, plate + 0.02});
  solids.Box(Material::kFrame, {0, 0, 0.5 * plate + 0.01}, {0.07, 2 * radius, plate + 0.02});
  solids.Box(Material::kFrame, {0, 0, 0.5 * height}, {2 * column, 2 * column, height});
}

void Feet(Random& random, const Footing& footing, Solids& solids) {
  const std::size_t kind = Pick(random, std::array{1.0, 1.0, 0.7});
  const double height = footing.height + 0.005;
  if (kind == 2) {
    solids.Box(
        Material::kFrame,
        {0, 0, 0.5 * height},
        {footing.size.x() - 2 * footing.inset, footing.size.y() - 2 * footing.inset, height});
    return;
  }
  const double thickness = random.Uniform(0.025, 0.07);
  const Eigen::Vector2d half =
      0.5 * footing.size - Eigen::Vector2d::Constant(footing.inset + 0.5 * thickness);
  const double taper = kind == 1 ? random.Uniform(0.4, 0.8) : 1.0;
  for (const double x : kSides) {
    for (const double y : kSides) {
      const Eigen::Vector3d foot(x * half.x(), y * half.y(), 0);
      const Eigen::Vector3d head(foot.x(), foot.y(), height);
      if (kind == 1) {
        solids.Tube(Material::kFrame, {foot, head}, 0.5 * taper * thickness, 0.5 * thickness);
      } else {
        solids.Frustum(
            Material::kFrame, foot, {thickness, thickness}, head, {thickness, thickness});
      }
    }
  }
}

}  // namespace deepslam::furniture

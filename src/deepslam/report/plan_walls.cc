#include "deepslam/report/plan_walls.h"

#include <cstddef>
#include <span>
#include <string_view>
#include <utility>
#include <vector>

#include <fmt/format.h>

#include "deepslam/report/plan_geometry.h"
#include "deepslam/scene/wall_geometry.h"

namespace deepslam::report {
namespace {

constexpr double kDoubtful = 0.5;  // confidence below

std::string Points(const PlanCanvas& canvas, std::span<const Eigen::Vector2d> points_m) {
  std::string text;
  for (const Eigen::Vector2d& p_m : points_m) {
    const Eigen::Vector2d p = canvas.ToPixels(p_m);
    text += fmt::format("{:.1f},{:.1f} ", p.x(), p.y());
  }
  return text;
}

std::string Line(const PlanCanvas& canvas,
                 const Eigen::Vector2d& a_m,
                 const Eigen::Vector2d& b_m,
                 std::string_view css_class) {
  const Eigen::Vector2d a = canvas.ToPixels(a_m);
  const Eigen::Vector2d b = canvas.ToPixels(b_m);
  return fmt::format(
      "<path class='{}' d='M{:.1f} {:.1f}L{:.1f} {:.1f}'/>", css_class, a.x(), a.y(), b.x(), b.y());
}

// The leaf of a door, and the arc that it goes along.
std::string Leaf(const PlanCanvas& canvas,
                 const LayoutWall& wall,
                 const std::pair<double, double>& span) {
  const DoorLeaf leaf = LeafOf(wall, span);
  const Eigen::Vector2d open = canvas.ToPixels(leaf.open_m);
  const Eigen::Vector2d shut = canvas.ToPixels(leaf.latch_m);
  const double radius_px = leaf.width_m * kPlanPixelsPerMetre;
  return Line(canvas, leaf.hinge_m, leaf.open_m, "fp-leaf") +
         fmt::format("<path class='fp-arc' d='M{:.1f} {:.1f}A{:.1f} {:.1f} 0 0 {} {:.1f} {:.1f}'/>",
                     open.x(),
                     open.y(),
                     radius_px,
                     radius_px,
                     leaf.shuts_clockwise ? 1 : 0,
                     shut.x(),
                     shut.y());
}

std::string OpeningShape(const PlanCanvas& canvas,
                         const Layout& layout,
                         const LayoutOpening& opening) {
  const LayoutWall& wall = layout.walls[static_cast<std::size_t>(opening.wall)];
  const WallFrame frame(wall);
  const auto span = SpanOf(opening, wall);
  const double thickness_m = DrawnThickness(layout, wall);
  std::string svg = fmt::format("<g class='{}'><polygon class='fp-gap' points='{}'/>",
                                opening.confidence < kDoubtful ? "fp-doubtful" : "fp-sure",
                                Points(canvas, BodyOutline(layout, wall, span)));
  // Jambs.
  for (const double at_m : {span.first, span.second})
    svg += Line(canvas, frame.At(at_m, 0), frame.At(at_m, -thickness_m), "fp-jamb");
  const auto across = [&](double share, std::string_view css_class) {
    return Line(canvas,
                frame.At(span.first, -share * thickness_m),
                frame.At(span.second, -share * thickness_m),
                css_class);
  };
  switch (opening.kind) {
    case OpeningKind::kWindow:
      svg += across(0, "fp-thin") + across(0.38, "fp-pane") + across(0.62, "fp-pane") +
             across(1, "fp-thin");
      break;
    case OpeningKind::kDoor:
      svg += across(0, "fp-sill") + across(1, "fp-sill") + Leaf(canvas, wall, span);
      break;
    case OpeningKind::kPassage:
      svg += across(0, "fp-dashed") + across(1, "fp-dashed");
      break;
  }
  return svg + "</g>";
}

}  // namespace

std::string PlanWalls(const PlanCanvas& canvas, const Layout& layout) {
  std::string svg;
  for (const auto& [from_m, to_m] : UnseenSides(layout))
    svg += Line(canvas, from_m, to_m, "fp-guessed");
  for (const LayoutWall& wall : layout.walls) {
    svg += fmt::format("<polygon class='{}' points='{}'/>",
                       wall.confidence < kDoubtful ? "fp-wall fp-unsure" : "fp-wall",
                       Points(canvas, BodyOutline(layout, wall, BodyOf(layout, wall))));
  }
  return svg;
}

std::string PlanOpenings(const PlanCanvas& canvas, const Layout& layout) {
  std::string svg;
  for (const LayoutOpening& opening : layout.openings) svg += OpeningShape(canvas, layout, opening);
  return svg;
}

}  // namespace deepslam::report

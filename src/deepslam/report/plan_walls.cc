#include "deepslam/report/plan_walls.h"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <numbers>
#include <string_view>
#include <utility>
#include <vector>

#include <fmt/format.h>

#include "deepslam/scene/wall_geometry.h"

namespace deepslam::report {
namespace {

// Drawn where the other face was not seen: an inner wall's usual thickness.
constexpr double kUnknownThickness_m = 0.12;
constexpr double kDoubtful = 0.5;        // confidence below
constexpr double kLeastLabel_m = 0.8;    // shorter walls go without their length
constexpr double kLabelBefore_m = 0.13;  // lengths stand this far before the face

double DrawnThickness(const Layout& layout, const LayoutWall& wall) {
  return ThicknessOf(layout, wall).value_or(kUnknownThickness_m);
}

// A point of a wall: along it from its beginning, before its face (behind it: negative).
class WallFrame {
 public:
  explicit WallFrame(const LayoutWall& wall)
      : from_m_(wall.from_m), along_(AlongOf(wall)), inward_(-along_.y(), along_.x()) {}

  [[nodiscard]] Eigen::Vector2d At(double along_m, double before_m) const {
    return from_m_ + along_m * along_ + before_m * inward_;
  }
  [[nodiscard]] const Eigen::Vector2d& along() const { return along_; }

 private:
  Eigen::Vector2d from_m_;
  Eigen::Vector2d along_;
  Eigen::Vector2d inward_;
};

std::string Points(const PlanCanvas& canvas, const std::vector<Eigen::Vector2d>& points_m) {
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

// The leaf of a door, open by a right angle into the room, and the arc that it goes along; hung at
// the end that is nearer to the wall's.
std::string Leaf(const PlanCanvas& canvas,
                 const LayoutWall& wall,
                 const std::pair<double, double>& span) {
  const WallFrame frame(wall);
  const bool at_begin = span.first <= wall.length_m() - span.second;
  const double hinge_m = at_begin ? span.first : span.second;
  const double latch_m = at_begin ? span.second : span.first;
  const double width_m = span.second - span.first;
  const Eigen::Vector2d open = canvas.ToPixels(frame.At(hinge_m, width_m));
  const Eigen::Vector2d shut = canvas.ToPixels(frame.At(latch_m, 0));
  const double radius_px = width_m * kPlanPixelsPerMetre;
  return Line(canvas, frame.At(hinge_m, 0), frame.At(hinge_m, width_m), "fp-leaf") +
         fmt::format("<path class='fp-arc' d='M{:.1f} {:.1f}A{:.1f} {:.1f} 0 0 {} {:.1f} {:.1f}'/>",
                     open.x(),
                     open.y(),
                     radius_px,
                     radius_px,
                     at_begin ? 1 : 0,
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
                                Points(canvas,
                                       {frame.At(span.first, 0),
                                        frame.At(span.second, 0),
                                        frame.At(span.second, -thickness_m),
                                        frame.At(span.first, -thickness_m)}));
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
  for (const LayoutRoom& room : layout.rooms) {
    for (std::size_t n = 0; n < room.polygon_m.size(); ++n) {
      if (n >= room.guessed.size() || !room.guessed[n]) continue;
      svg += Line(
          canvas, room.polygon_m[n], room.polygon_m[(n + 1) % room.polygon_m.size()], "fp-guessed");
    }
  }
  for (const LayoutWall& wall : layout.walls) {
    const WallFrame frame(wall);
    const double thickness_m = DrawnThickness(layout, wall);
    const double begin_m = MeetsInHollowCorner(layout, wall, false) ? -thickness_m : 0;
    const double end_m =
        wall.length_m() + (MeetsInHollowCorner(layout, wall, true) ? thickness_m : 0);
    svg += fmt::format("<polygon class='{}' points='{}'/>",
                       wall.confidence < kDoubtful ? "fp-wall fp-unsure" : "fp-wall",
                       Points(canvas,
                              {frame.At(begin_m, 0),
                               frame.At(end_m, 0),
                               frame.At(end_m, -thickness_m),
                               frame.At(begin_m, -thickness_m)}));
  }
  return svg;
}

std::string PlanOpenings(const PlanCanvas& canvas, const Layout& layout) {
  std::string svg;
  for (const LayoutOpening& opening : layout.openings) svg += OpeningShape(canvas, layout, opening);
  return svg;
}

std::string PlanLengths(const PlanCanvas& canvas, const Layout& layout) {
  std::string svg;
  for (const LayoutWall& wall : layout.walls) {
    if (wall.length_m() < kLeastLabel_m) continue;
    const WallFrame frame(wall);
    // Before doors lie their arcs: the middle of the widest piece of wall.
    std::vector<std::pair<double, double>> spans;
    for (const LayoutOpening& opening : layout.openings) {
      if (&layout.walls[static_cast<std::size_t>(opening.wall)] == &wall)
        spans.push_back(SpanOf(opening, wall));
    }
    std::sort(spans.begin(), spans.end());
    spans.emplace_back(wall.length_m(), wall.length_m());
    double middle_m = 0.5 * wall.length_m();
    double widest_m = 0;
    double begin_m = 0;
    for (const auto& [first, last] : spans) {
      if (first - begin_m > widest_m) {
        widest_m = first - begin_m;
        middle_m = 0.5 * (first + begin_m);
      }
      begin_m = std::max(begin_m, last);
    }
    const Eigen::Vector2d at = canvas.ToPixels(frame.At(middle_m, kLabelBefore_m));
    const Eigen::Vector2d along = canvas.Turned(frame.along());
    double angle_deg = std::atan2(along.y(), along.x()) * 180 / std::numbers::pi;
    if (angle_deg > 90.5) angle_deg -= 180;
    if (angle_deg <= -89.5) angle_deg += 180;
    svg += fmt::format(
        "<text class='fp-length' transform='translate({:.1f} {:.1f}) rotate({:.1f})' dy='.35em'>"
        "{:.2f}</text>",
        at.x(),
        at.y(),
        angle_deg,
        wall.length_m());
  }
  return svg;
}

}  // namespace deepslam::report

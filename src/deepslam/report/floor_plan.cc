#include "deepslam/report/floor_plan.h"

#include <algorithm>
#include <cmath>
#include <complex>
#include <cstddef>
#include <span>
#include <string_view>

#include <fmt/format.h>
#include <Eigen/Geometry>

#include "deepslam/report/html.h"
#include "deepslam/report/plan_labels.h"
#include "deepslam/report/plan_walls.h"
#include "deepslam/scene/wall_geometry.h"

namespace deepslam::report {
namespace {

constexpr double kMargin_px = 84;  // measures stand in it
constexpr double kFooter_px = 46;  // scale and caption

constexpr std::string_view kStyle =
    "<style>.fp text{font-family:Helvetica,Arial,sans-serif;fill:#222;text-anchor:middle}"
    ".fp-floor{fill:#faf8f3}.fp-wall{fill:#2b2b2b;stroke:#2b2b2b;stroke-width:.6}"
    ".fp-unsure{fill:#9a9a9a;stroke:#9a9a9a}"
    ".fp-guessed{stroke:#999;stroke-width:1.2;stroke-dasharray:7 5;fill:none}"
    ".fp-gap{fill:#fff;stroke:#fff;stroke-width:1.4}"
    ".fp-jamb{stroke:#2b2b2b;stroke-width:1.6;fill:none}"
    ".fp-thin,.fp-pane,.fp-sill,.fp-arc,.fp-dashed{stroke:#2b2b2b;stroke-width:.8;fill:none}"
    ".fp-sill{stroke:#bbb}.fp-dashed{stroke-dasharray:5 4;stroke:#777}"
    ".fp-leaf{stroke:#2b2b2b;stroke-width:2.4;fill:none}"
    ".fp-doubtful path{stroke-dasharray:3 3}"
    ".fp-thing{stroke:#444;stroke-width:1;fill-opacity:.28}"
    ".fp-front{stroke:#444;stroke-width:2.6;fill:none}"
    ".fp text.fp-size{fill:#555}.fp text.fp-length{font-size:10px;fill:#666}"
    ".fp text.fp-opening{font-size:7.5px;fill:#444}"
    ".fp-opening,.fp-name,.fp-size,.fp-length,.fp-room,.fp-area,.fp-small{paint-order:stroke;"
    "stroke:#fff;stroke-opacity:.75;stroke-width:2px;stroke-linejoin:round}"
    ".fp text.fp-room{font-size:14px;font-weight:bold}.fp text.fp-area{font-size:12px;fill:#444}"
    ".fp-measure{stroke:#555;stroke-width:.8;fill:none}.fp text.fp-measured{font-size:11px}"
    ".fp text.fp-left{text-anchor:start}.fp text.fp-title{font-size:15px;font-weight:bold;"
    "text-anchor:start}.fp text.fp-small{font-size:10px;fill:#555}</style>";

// The angle that most of the walls' length runs along, or at right angles to it; within 45 degrees.
double MainDirection(const Layout& layout) {
  std::complex<double> sum = 0;
  for (const LayoutWall& wall : layout.walls) {
    const Eigen::Vector2d along = AlongOf(wall);
    sum += std::polar(wall.length_m(), 4 * std::atan2(along.y(), along.x()));
  }
  return std::abs(sum) > 0 ? std::arg(sum) / 4 : 0;
}

std::vector<Eigen::Vector2d> LayoutPlaces(const FloorPlanContent& content) {
  std::vector<Eigen::Vector2d> places;
  for (const LayoutRoom& room : content.layout_world.rooms)
    places.insert(places.end(), room.polygon_m.begin(), room.polygon_m.end());
  for (const LayoutWall& wall : content.layout_world.walls) {
    const double thickness_m = ThicknessOf(content.layout_world, wall).value_or(0);
    const Eigen::Vector2d along = AlongOf(wall);
    const Eigen::Vector2d outward(along.y(), -along.x());
    for (const Eigen::Vector2d& end : {wall.from_m, wall.to_m}) {
      places.push_back(end);
      places.emplace_back(end + thickness_m * outward);
    }
  }
  return places;
}

std::vector<Eigen::Vector2d> AllPlaces(const FloorPlanContent& content) {
  std::vector<Eigen::Vector2d> places = LayoutPlaces(content);
  places.insert(places.end(), content.others_m.begin(), content.others_m.end());
  for (const PlanThing& thing : content.things)
    places.insert(places.end(), thing.corners_m.begin(), thing.corners_m.end());
  if (places.empty()) places.emplace_back(0, 0);
  return places;
}

std::string PolygonPoints(const PlanCanvas& canvas, std::span<const Eigen::Vector2d> polygon_m) {
  std::string points;
  for (const Eigen::Vector2d& corner : polygon_m) {
    const Eigen::Vector2d p = canvas.ToPixels(corner);
    points += fmt::format("{:.1f},{:.1f} ", p.x(), p.y());
  }
  return points;
}

std::string ThingShape(const PlanCanvas& canvas, const PlanThing& thing) {
  const Eigen::Vector2d a = canvas.ToPixels(thing.corners_m[0]);
  const Eigen::Vector2d b = canvas.ToPixels(thing.corners_m[1]);
  return fmt::format(
      "<polygon class='fp-thing' points='{}' fill='rgb({},{},{})'/>"
      "<path class='fp-front' d='M{:.1f} {:.1f}L{:.1f} {:.1f}'/>",
      PolygonPoints(canvas, thing.corners_m),
      thing.colour.r,
      thing.colour.g,
      thing.colour.b,
      a.x(),
      a.y(),
      b.x(),
      b.y());
}

// Overall measures left of what is drawn and below it.
std::string OverallMeasures(const PlanCanvas& canvas) {
  const Eigen::Vector2d low = canvas.min_px();
  const Eigen::Vector2d high = canvas.max_px();
  // Beside all that is drawn, furniture that reaches out of its room as well.
  constexpr double kBeside_px = 36;
  const double x = kMargin_px - kBeside_px;
  const double y = canvas.height_px() - kFooter_px - kMargin_px + kBeside_px;
  const auto tick = [](double at_x, double at_y) {
    return fmt::format("M{:.1f} {:.1f}l8 -8", at_x - 4, at_y + 4);
  };
  return fmt::format(
      "<path class='fp-measure' d='M{0:.1f} {1:.1f}V{2:.1f}M{3:.1f} {4:.1f}H{5:.1f}{6}{7}{8}{9}'/>"
      "<text class='fp-measured' transform='translate({10:.1f} {11:.1f}) rotate(-90)'>{12:.2f}"
      "</text><text class='fp-measured' x='{13:.1f}' y='{14:.1f}'>{15:.2f}</text>",
      x,
      low.y(),
      high.y(),
      low.x(),
      y,
      high.x(),
      tick(x, low.y()),
      tick(x, high.y()),
      tick(low.x(), y),
      tick(high.x(), y),
      x - 5,
      0.5 * (low.y() + high.y()),
      (high.y() - low.y()) / kPlanPixelsPerMetre,
      0.5 * (low.x() + high.x()),
      y - 5,
      (high.x() - low.x()) / kPlanPixelsPerMetre);
}

// Metres in turn black and white.
std::string ScaleBar(const PlanCanvas& canvas) {
  const double height_px = 6;
  const int metres = canvas.max_px().x() - canvas.min_px().x() > 7 * kPlanPixelsPerMetre ? 5 : 2;
  const double x = kMargin_px;
  const double y = canvas.height_px() - 24;
  std::string svg;
  for (int metre = 0; metre < metres; ++metre) {
    svg += fmt::format(
        "<rect x='{:.1f}' y='{:.1f}' width='{}' height='{}' fill='{}' stroke='#222' "
        "stroke-width='.8'/>",
        x + metre * kPlanPixelsPerMetre,
        y,
        kPlanPixelsPerMetre,
        height_px,
        metre % 2 == 0 ? "#222" : "#fff");
  }
  for (int metre = 0; metre <= metres; ++metre) {
    svg += fmt::format("<text class='fp-small' x='{:.1f}' y='{:.1f}'>{}{}</text>",
                       x + metre * kPlanPixelsPerMetre,
                       y + 17,
                       metre,
                       metre == metres ? " m" : "");
  }
  return svg;
}

// Where the world's x axis points: ahead of the first camera. No compass comes with a capture.
std::string FirstViewArrow(const PlanCanvas& canvas) {
  const Eigen::Vector2d ahead = canvas.Turned(Eigen::Vector2d::UnitX());
  const Eigen::Vector2d across(-ahead.y(), ahead.x());
  const Eigen::Vector2d at(canvas.width_px() - 40, 30);
  const Eigen::Vector2d tip = at + 15 * ahead;
  const Eigen::Vector2d left = at - 9 * ahead + 7 * across;
  const Eigen::Vector2d right = at - 9 * ahead - 7 * across;
  const Eigen::Vector2d notch = at - 4 * ahead;
  return fmt::format(
      "<circle class='fp-measure' cx='{:.1f}' cy='{:.1f}' r='17'/><path fill='#222' d='M{:.1f} "
      "{:.1f}L{:.1f} {:.1f}L{:.1f} {:.1f}L{:.1f} {:.1f}Z'/><text class='fp-small' x='{:.1f}' "
      "y='{:.1f}'>first view</text>",
      at.x(),
      at.y(),
      tip.x(),
      tip.y(),
      left.x(),
      left.y(),
      notch.x(),
      notch.y(),
      right.x(),
      right.y(),
      at.x(),
      at.y() + 30);
}

std::string TitleOf(const FloorPlanContent& content) {
  double area_m2 = 0;
  for (const LayoutRoom& room : content.layout_world.rooms) area_m2 += AreaOf(room.polygon_m);
  std::string text = EscapeHtml(content.title);
  const std::size_t num_rooms = content.layout_world.rooms.size();
  if (num_rooms > 0) {
    text += fmt::format(
        "<tspan font-weight='normal' fill='#555' dx='10' font-size='12'>{} "
        "room{}, {:.1f} m²; measures in metres</tspan>",
        num_rooms,
        num_rooms == 1 ? "" : "s",
        area_m2);
  }
  return fmt::format("<text class='fp-title' x='{}' y='26'>{}</text>", kMargin_px, text);
}

}  // namespace

PlanThing MakePlanThing(const std::string& name,
                        const Pose3& world_from_object,
                        const Eigen::Vector3d& size_m,
                        Rgb8 colour) {
  const Eigen::Vector3d h = 0.5 * size_m;
  const auto corner = [&](double x, double y) {
    return Eigen::Vector2d((world_from_object * Eigen::Vector3d(x, y, 0)).head<2>());
  };
  return {
      name,
      {corner(h.x(), -h.y()), corner(h.x(), h.y()), corner(-h.x(), h.y()), corner(-h.x(), -h.y())},
      size_m,
      colour};
}

PlanCanvas::PlanCanvas(const FloorPlanContent& content) {
  turn_ = Eigen::Rotation2Dd(-MainDirection(content.layout_world)).toRotationMatrix();
  Eigen::AlignedBox2d box;
  for (const Eigen::Vector2d& p : AllPlaces(content)) box.extend(Eigen::Vector2d(turn_ * p));
  constexpr double kLeastPlanSide_m =
      1.0;  // of either side: a plan of next to nothing has a picture still
  box.extend(Eigen::Vector2d(box.min() + Eigen::Vector2d::Constant(kLeastPlanSide_m)));
  low_m_ = box.min();
  high_m_ = box.max();
  const Eigen::Vector2d size_px = kPlanPixelsPerMetre * (high_m_ - low_m_);
  min_px_ = Eigen::Vector2d::Constant(kMargin_px);
  max_px_ = min_px_ + size_px;
  Eigen::AlignedBox2d of_layout;
  for (const Eigen::Vector2d& p : LayoutPlaces(content)) of_layout.extend(ToPixels(p));
  if (!of_layout.isEmpty()) {
    min_px_ = of_layout.min();
    max_px_ = of_layout.max();
  }
  width_px_ = size_px.x() + 2 * kMargin_px;
  height_px_ = size_px.y() + 2 * kMargin_px + kFooter_px;
}

Eigen::Vector2d PlanCanvas::ToPixels(const Eigen::Vector2d& p_m) const {
  const Eigen::Vector2d p = turn_ * p_m;
  return {kMargin_px + kPlanPixelsPerMetre * (p.x() - low_m_.x()),
          kMargin_px + kPlanPixelsPerMetre * (high_m_.y() - p.y())};
}

Eigen::Vector2d PlanCanvas::Turned(const Eigen::Vector2d& direction) const {
  const Eigen::Vector2d d = turn_ * direction;
  return {d.x(), -d.y()};
}

std::string FloorPlan(const FloorPlanContent& content,
                      const std::function<std::string(const PlanCanvas&)>& draw_over) {
  const PlanCanvas canvas(content);
  const Layout& layout = content.layout_world;
  std::string svg = fmt::format(
      "<svg xmlns='http://www.w3.org/2000/svg' class='map fp' viewBox='0 0 {0:.0f} {1:.0f}' "
      "role='img' aria-label='floor plan'>{2}<rect width='{0:.0f}' height='{1:.0f}' fill='#fff'/>",
      canvas.width_px(),
      canvas.height_px(),
      kStyle);
  for (const LayoutRoom& room : layout.rooms) {
    svg += fmt::format("<polygon class='fp-floor' points='{}'/>",
                       PolygonPoints(canvas, room.polygon_m));
  }
  for (const PlanThing& thing : content.things) svg += ThingShape(canvas, thing);
  svg += PlanWalls(canvas, layout) + PlanOpenings(canvas, layout);
  if (draw_over) svg += draw_over(canvas);
  svg += PlanLabels(canvas, content);
  if (!layout.walls.empty() || !layout.rooms.empty()) svg += OverallMeasures(canvas);
  return svg + ScaleBar(canvas) + FirstViewArrow(canvas) + TitleOf(content) + "</svg>\n";
}

}  // namespace deepslam::report

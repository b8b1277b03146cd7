#include "deepslam/report/plan_dxf.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <string_view>
#include <utility>
#include <vector>

#include <fmt/format.h>

#include "deepslam/core/angles.h"
#include "deepslam/report/dxf_text.h"
#include "deepslam/report/plan_geometry.h"
#include "deepslam/scene/wall_geometry.h"

namespace deepslam::report {
namespace {

constexpr std::string_view kWalls = "WALLS";
constexpr std::string_view kDoors = "DOORS";
constexpr std::string_view kWindows = "WINDOWS";
constexpr std::string_view kFurniture = "FURNITURE";
constexpr std::string_view kText = "TEXT";
// Colours by AutoCAD's index: black or white, brown, blue, grey.
constexpr std::array<DxfLayer, 5> kLayers = {
    {{kWalls, 7}, {kDoors, 34}, {kWindows, 5}, {kFurniture, 8}, {kText, 7}}};

// As high as letters are on a plan of 1:50 that has them 2.5 and 1.6 mm high.
constexpr double kRoomText_m = 0.125;
constexpr double kSmallText_m = 0.08;      // of things and lengths
constexpr double kLineSpacing = 1.6;       // of texts below each other, of their height
constexpr double kTextBeforeWall_m = 0.1;  // lengths stand this far before their wall
constexpr double kLeastLength_m = 0.3;     // shorter walls go without

class PlanDrawing {
 public:
  explicit PlanDrawing(const FloorPlanContent& content)
      : content_(content), layout_(content.layout_world), dxf_(kLayers) {}

  std::string Draw() && {
    for (const auto& [from_m, to_m] : UnseenSides(layout_))
      dxf_.AddLine(kWalls, from_m, to_m, DxfLine::kDashed);
    for (const LayoutWall& wall : layout_.walls) DrawWall(wall);
    for (const LayoutOpening& opening : layout_.openings) DrawOpening(opening);
    for (const PlanThing& thing : content_.things) DrawThing(thing);
    for (std::size_t n = 0; n < layout_.rooms.size(); ++n) LabelRoom(n);
    return dxf_.Finish();
  }

 private:
  // A wall of which both faces were seen is two walls of the layout, each of which draws its own.
  void DrawWall(const LayoutWall& wall) {
    const bool is_outer = !ThicknessOf(layout_, wall).has_value();
    const WallFrame frame(wall);
    for (const auto& span : SolidSpans(layout_, wall)) {
      if (is_outer) {
        dxf_.AddOutline(kWalls, BodyOutline(layout_, wall, span));
      } else {
        dxf_.AddLine(kWalls,
                     frame.At(std::max(0.0, span.first), 0),
                     frame.At(std::min(wall.length_m(), span.second), 0));
      }
    }
    if (wall.length_m() < kLeastLength_m) return;
    dxf_.AddText(kText,
                 frame.At(0.5 * wall.length_m(), kTextBeforeWall_m),
                 kSmallText_m,
                 ReadableAngleDeg(frame.along()),
                 fmt::format("{:.2f}", wall.length_m()));
  }

  void DrawOpening(const LayoutOpening& opening) {
    const LayoutWall& wall = layout_.walls[static_cast<std::size_t>(opening.wall)];
    const WallFrame frame(wall);
    const auto span = SpanOf(opening, wall);
    const double thickness_m = DrawnThickness(layout_, wall);
    const std::string_view layer = opening.kind == OpeningKind::kWindow ? kWindows : kDoors;
    for (const double at_m : {span.first, span.second})
      dxf_.AddLine(layer, frame.At(at_m, 0), frame.At(at_m, -thickness_m));
    const auto across = [&](double share, DxfLine line) {
      dxf_.AddLine(layer,
                   frame.At(span.first, -share * thickness_m),
                   frame.At(span.second, -share * thickness_m),
                   line);
    };
    switch (opening.kind) {
      case OpeningKind::kWindow:
        for (const double share : {0.0, 0.38, 0.62, 1.0}) across(share, DxfLine::kContinuous);
        break;
      case OpeningKind::kDoor:
        DrawLeaf(LeafOf(wall, span));
        break;
      case OpeningKind::kPassage:
        across(0, DxfLine::kDashed);
        across(1, DxfLine::kDashed);
        break;
    }
  }

  void DrawLeaf(const DoorLeaf& leaf) {
    dxf_.AddLine(kDoors, leaf.hinge_m, leaf.open_m);
    if (leaf.shuts_clockwise) {
      dxf_.AddArc(kDoors, leaf.hinge_m, leaf.latch_m, leaf.open_m);
    } else {
      dxf_.AddArc(kDoors, leaf.hinge_m, leaf.open_m, leaf.latch_m);
    }
  }

  void DrawThing(const PlanThing& thing) {
    dxf_.AddOutline(kFurniture, thing.corners_m);
    constexpr double kFrontInset = 0.06;  // of the depth: a second line along the front side
    const Eigen::Vector2d inset = kFrontInset * (thing.corners_m[3] - thing.corners_m[0]);
    dxf_.AddLine(kFurniture, thing.corners_m[0] + inset, thing.corners_m[1] + inset);
    const Eigen::Vector2d middle = 0.5 * (thing.corners_m[0] + thing.corners_m[2]);
    const Eigen::Vector2d side = thing.corners_m[1] - thing.corners_m[0];
    const Eigen::Vector2d depth = thing.corners_m[3] - thing.corners_m[0];
    const double angle_deg = ReadableAngleDeg(side.norm() > depth.norm() ? side : depth);
    AddLines(
        middle,
        kSmallText_m,
        angle_deg,
        {thing.name,
         fmt::format(
             "{:.2f} x {:.2f} x {:.2f}", thing.size_m.x(), thing.size_m.y(), thing.size_m.z())});
  }

  void LabelRoom(std::size_t number) {
    const LayoutRoom& room = layout_.rooms[number];
    std::vector<std::string> lines = {fmt::format("Room {}", number),
                                      fmt::format("{:.1f} m2", AreaOf(room.polygon_m))};
    if (HasCeiling(room)) lines.push_back(fmt::format("h {:.2f}", room.ceiling_m - room.floor_m));
    AddLines(FreePlace(room, ObstaclesOf(content_)), kRoomText_m, 0, lines);
  }

  // Below each other, about a place.
  void AddLines(const Eigen::Vector2d& middle_m,
                double height_m,
                double angle_deg,
                const std::vector<std::string>& lines) {
    const double angle = angle_deg * kRadPerDeg;
    const Eigen::Vector2d down(std::sin(angle), -std::cos(angle));
    for (std::size_t n = 0; n < lines.size(); ++n) {
      const double below = static_cast<double>(n) - 0.5 * static_cast<double>(lines.size() - 1);
      dxf_.AddText(
          kText, middle_m + below * kLineSpacing * height_m * down, height_m, angle_deg, lines[n]);
    }
  }

  // In (-90, 90]: texts are read from below or from the right.
  static double ReadableAngleDeg(const Eigen::Vector2d& along) {
    const double angle = std::atan2(along.y(), along.x()) * kDegPerRad;
    constexpr double kMaxReadable_deg = 90.001;  // rounding must not turn vertical texts round
    if (angle > kMaxReadable_deg) return angle - 180;
    return angle <= kMaxReadable_deg - 180 ? angle + 180 : angle;
  }

  const FloorPlanContent& content_;
  const Layout& layout_;
  DxfText dxf_;
};

}  // namespace

std::string FloorPlanDxf(const FloorPlanContent& content) { return PlanDrawing(content).Draw(); }

}  // namespace deepslam::report

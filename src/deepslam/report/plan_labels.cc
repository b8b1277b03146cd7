#include "deepslam/report/plan_labels.h"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <optional>
#include <string_view>
#include <utility>
#include <vector>

#include <fmt/format.h>
#include <Eigen/Geometry>

#include "deepslam/core/angles.h"
#include "deepslam/report/html.h"
#include "deepslam/report/plan_geometry.h"
#include "deepslam/scene/wall_geometry.h"

namespace deepslam::report {
namespace {

constexpr double kLeastFont_px = 6.5;   // smaller ones cannot be read: texts exceed their outline
constexpr double kLargestFont_px = 11;  // below that of rooms' names
constexpr double kCharacter = 0.56;  // width of one, of the size of the font
constexpr double kLength_px = 10;    // sizes of fonts
constexpr double kOpening_px = 7.5;  // as .fp-opening of floor_plan.cc has it
constexpr double kRoom_px = 14;      // and .fp-room
constexpr double kLeastLength_m = 0.3;    // shorter walls go without their length
constexpr double kLengthBefore_m = 0.13;  // lengths stand this far before the face, or behind

double WidthOf(std::string_view text, double font_px) {
  // Bytes that go on with a character are none.
  const auto num_characters = std::count_if(text.begin(), text.end(), [](char c) {
    return (static_cast<unsigned char>(c) & 0xC0U) != 0x80U;
  });
  return kCharacter * font_px * static_cast<double>(num_characters);
}

// Where a text of one or several lines may stand: its middle and the angle it is turned by.
struct TextPlace {
  Eigen::Vector2d middle_px;
  double angle_deg = 0;
};

Eigen::AlignedBox2d BoxOf(const TextPlace& place, const Eigen::Vector2d& size_px) {
  const double angle = place.angle_deg * kRadPerDeg;
  const double c = std::abs(std::cos(angle));
  const double s = std::abs(std::sin(angle));
  const Eigen::Vector2d half =
      0.5 * Eigen::Vector2d(c * size_px.x() + s * size_px.y(), s * size_px.x() + c * size_px.y());
  return {place.middle_px - half, place.middle_px + half};
}

// Texts are read from below or from the right.
double ReadableAngle(const Eigen::Vector2d& along_px) {
  double angle_deg = std::atan2(along_px.y(), along_px.x()) * kDegPerRad;
  if (angle_deg > 90.5) angle_deg -= 180;
  if (angle_deg <= -89.5) angle_deg += 180;
  return angle_deg;
}

class LabelWriter {
 public:
  LabelWriter(const PlanCanvas& canvas, const FloorPlanContent& content)
      : canvas_(canvas), content_(content), layout_(content.layout_world) {}

  std::string Write() && {
    for (const PlanThing& thing : content_.things) LabelThing(thing);
    for (const LayoutOpening& opening : layout_.openings) LabelOpening(opening);
    KeepDoorsFree();
    for (std::size_t n = 0; n < layout_.rooms.size(); ++n) LabelRoom(n);
    for (const LayoutWall& wall : layout_.walls) LabelWall(wall);
    return std::move(svg_);
  }

 private:
  [[nodiscard]] bool IsFree(const Eigen::AlignedBox2d& box) const {
    return std::none_of(taken_.begin(), taken_.end(), [&](const Eigen::AlignedBox2d& other) {
      return (box.min().array() < other.max().array()).all() &&
             (other.min().array() < box.max().array()).all();
    });
  }

  // The first free one, which is taken then.
  std::optional<TextPlace> Choose(const std::vector<TextPlace>& places,
                                  const Eigen::Vector2d& size_px) {
    for (const TextPlace& place : places) {
      const Eigen::AlignedBox2d box = BoxOf(place, size_px);
      if (!IsFree(box)) continue;
      taken_.push_back(box);
      return place;
    }
    return std::nullopt;
  }

  void Group(const TextPlace& place, std::string_view texts) {
    svg_ += fmt::format("<g transform='translate({:.1f} {:.1f}) rotate({:.1f})'>{}</g>",
                        place.middle_px.x(),
                        place.middle_px.y(),
                        place.angle_deg,
                        texts);
  }

  // Name and measures, as large as the outline lets them be.
  void LabelThing(const PlanThing& thing) {
    Eigen::AlignedBox2d box;
    for (const Eigen::Vector2d& corner : thing.corners_m) box.extend(canvas_.ToPixels(corner));
    const std::string measures = fmt::format(
        "{:.2f} x {:.2f} x {:.2f}", thing.size_m.x(), thing.size_m.y(), thing.size_m.z());
    // Height by width of an outline from which on texts run upwards.
    constexpr double kUprightRatio = 1.6;
    const bool upright = box.sizes().y() > kUprightRatio * box.sizes().x();
    const double room_px = upright ? box.sizes().y() : box.sizes().x();
    const auto size_of = [&](const std::string& text, double largest_px) {
      return std::clamp(0.94 * room_px / WidthOf(text, 1), kLeastFont_px, largest_px);
    };
    const double name_px = size_of(thing.name, kLargestFont_px);
    const double size_px = std::min(name_px, size_of(measures, kLargestFont_px - 2));
    const Eigen::Vector2d text_px(
        std::max(WidthOf(thing.name, name_px), WidthOf(measures, size_px)), name_px + size_px);
    std::vector<TextPlace> places;
    const Eigen::Vector2d spare =
        0.5 * (box.sizes() - BoxOf({{0, 0}, upright ? -90.0 : 0.0}, text_px).sizes());
    for (const auto& [right, down] : {std::pair(0.0, 0.0),
                                      {0, 0.5},
                                      {0, -0.5},
                                      {0.5, 0},
                                      {-0.5, 0},
                                      {0, 1},
                                      {0, -1},
                                      {1, 0},
                                      {-1, 0}}) {
      places.push_back({box.center() + spare.cwiseMax(0).cwiseProduct(Eigen::Vector2d(right, down)),
                        upright ? -90.0 : 0.0});
    }
    // In its outline in any case: a name that stands elsewhere is somebody else's.
    const TextPlace place = Choose(places, text_px).value_or(places.front());
    Group(place,
          fmt::format("<text class='fp-name' style='font-size:{:.1f}px' y='-1'>{}</text><text "
                      "class='fp-size' style='font-size:{:.1f}px' y='{:.1f}'>{}</text>",
                      name_px,
                      EscapeHtml(thing.name),
                      size_px,
                      size_px + 1,
                      measures));
  }

  // In the gap, along the wall; the width alone where both do not fit.
  void LabelOpening(const LayoutOpening& opening) {
    const LayoutWall& wall = layout_.walls[static_cast<std::size_t>(opening.wall)];
    const WallFrame frame(wall);
    const auto span = SpanOf(opening, wall);
    const double width_m = span.second - span.first;
    std::string text = fmt::format("{:.2f} x {:.2f}", width_m, opening.top_m - opening.bottom_m);
    if (WidthOf(text, kOpening_px) > kPlanPixelsPerMetre * width_m)
      text = fmt::format("{:.2f}", width_m);
    const TextPlace place{canvas_.ToPixels(frame.At(0.5 * (span.first + span.second),
                                                    -0.5 * DrawnThickness(layout_, wall))),
                          ReadableAngle(canvas_.Turned(frame.along()))};
    taken_.push_back(BoxOf(place, {WidthOf(text, kOpening_px), kOpening_px}));
    Group(place, fmt::format("<text class='fp-opening' dy='.35em'>{}</text>", text));
  }

  // What leaves of doors go over.
  void KeepDoorsFree() {
    for (const auto& corners_m : DoorSwings(layout_)) {
      Eigen::AlignedBox2d box;
      for (const Eigen::Vector2d& corner : corners_m) box.extend(canvas_.ToPixels(corner));
      taken_.push_back(box);
    }
  }

  void LabelRoom(std::size_t number) {
    const LayoutRoom& room = layout_.rooms[number];
    const TextPlace place{canvas_.ToPixels(FreePlace(room, ObstaclesOf(content_))), 0};
    const std::string name = fmt::format("Room {}", number);
    const std::string area = fmt::format("{:.1f} m²", AreaOf(room.polygon_m));
    std::string texts = fmt::format(
        "<text class='fp-room' y='-3'>{}</text><text class='fp-area' y='12'>{}</text>", name, area);
    if (HasCeiling(room)) {
      texts += fmt::format("<text class='fp-small' y='25'>h {:.2f}</text>",
                           room.ceiling_m - room.floor_m);
    }
    constexpr double kHeight_px = 44;  // of lines of 14, 12 and 10 px
    taken_.push_back(
        BoxOf(place, {std::max(WidthOf(name, kRoom_px), WidthOf(area, kRoom_px)), kHeight_px}));
    Group(place, texts);
  }

  // Beside the pieces between openings, the longest first, in the room or behind the wall.
  void LabelWall(const LayoutWall& wall) {
    if (wall.length_m() < kLeastLength_m) return;
    const WallFrame frame(wall);
    const double angle_deg = ReadableAngle(canvas_.Turned(frame.along()));
    const std::string text = fmt::format("{:.2f}", wall.length_m());
    std::vector<std::pair<double, double>> pieces = SolidSpans(layout_, wall);
    std::stable_sort(pieces.begin(), pieces.end(), [](const auto& a, const auto& b) {
      return a.second - a.first > b.second - b.first;
    });
    std::vector<double> before_m = {kLengthBefore_m};
    if (!ThicknessOf(layout_, wall))
      before_m.push_back(-DrawnThickness(layout_, wall) - kLengthBefore_m);
    std::vector<TextPlace> places;
    for (const double before : before_m) {
      for (const auto& [first_m, last_m] : pieces) {
        for (const double share : {0.5, 0.3, 0.7, 0.15, 0.85}) {
          const double at_m =
              std::clamp(first_m + share * (last_m - first_m), 0.0, wall.length_m());
          places.push_back({canvas_.ToPixels(frame.At(at_m, before)), angle_deg});
        }
      }
    }
    if (const auto place = Choose(places, {WidthOf(text, kLength_px), kLength_px}))
      Group(*place, fmt::format("<text class='fp-length' dy='.35em'>{}</text>", text));
  }

  const PlanCanvas& canvas_;
  const FloorPlanContent& content_;
  const Layout& layout_;
  std::vector<Eigen::AlignedBox2d> taken_;
  std::string svg_;
};

}  // namespace

std::string PlanLabels(const PlanCanvas& canvas, const FloorPlanContent& content) {
  return LabelWriter(canvas, content).Write();
}

}  // namespace deepslam::report

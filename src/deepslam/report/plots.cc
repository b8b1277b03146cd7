#include "deepslam/report/plots.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <vector>

#include <fmt/format.h>

#include "deepslam/geometry/box.h"
#include "deepslam/report/html.h"

namespace deepslam::report {
namespace {

std::string_view StatusColour(TrackingStatus status) {
  switch (status) {
    case TrackingStatus::kTracked:
      return "#2a9d4e";
    case TrackingStatus::kDegenerate:
      return "#e59400";
    case TrackingStatus::kLost:
      return "#d62828";
    case TrackingStatus::kUnreadable:
      return "#7b2cbf";
  }
  return "#000";
}

// Corners of an object's footprint in the world, front side first.
std::array<Eigen::Vector3d, 4> Footprint(const ObjectRow& object) {
  const Eigen::Vector3d h = 0.5 * object.size_m;
  return {object.world_from_object * Eigen::Vector3d(h.x(), -h.y(), 0),
          object.world_from_object * Eigen::Vector3d(h.x(), h.y(), 0),
          object.world_from_object * Eigen::Vector3d(-h.x(), h.y(), 0),
          object.world_from_object * Eigen::Vector3d(-h.x(), -h.y(), 0)};
}

// Maps world metres to the drawing; y grows upwards in the world and downwards in SVG.
class Canvas {
 public:
  Canvas(const Box3& bounds, double width_px)
      : min_(bounds.min.head<2>()), max_(bounds.max.head<2>()) {
    scale_ = width_px / std::max(0.5, (max_ - min_).maxCoeff());
  }
  [[nodiscard]] double x(double x_m) const { return (x_m - min_.x()) * scale_; }
  [[nodiscard]] double y(double y_m) const { return (max_.y() - y_m) * scale_; }
  [[nodiscard]] double width() const { return (max_.x() - min_.x()) * scale_; }
  [[nodiscard]] double height() const { return (max_.y() - min_.y()) * scale_; }
  [[nodiscard]] const Eigen::Vector2d& min() const { return min_; }
  [[nodiscard]] const Eigen::Vector2d& max() const { return max_; }

 private:
  Eigen::Vector2d min_;
  Eigen::Vector2d max_;
  double scale_ = 1;
};

Box3 Bounds(const ReportContent& content) {
  Box3 bounds;
  for (const TrackedFrame& frame : content.map.frames) {
    bounds.Extend(frame.world_from_camera.translation_m);
  }
  for (const ObjectRow& object : content.objects) {
    for (const Eigen::Vector3d& corner : Footprint(object)) bounds.Extend(corner);
  }
  if (bounds.empty()) bounds.Extend(Eigen::Vector3d::Zero());
  constexpr double kMargin_m = 0.4;
  bounds.min.array() -= kMargin_m;
  bounds.max.array() += kMargin_m;
  return bounds;
}

std::string Grid(const Canvas& canvas) {
  std::string svg;
  for (double x = std::ceil(canvas.min().x()); x <= canvas.max().x(); x += 1.0) {
    svg += fmt::format("<path class=grid d='M{:.1f} 0V{:.1f}'/>", canvas.x(x), canvas.height());
  }
  for (double y = std::ceil(canvas.min().y()); y <= canvas.max().y(); y += 1.0) {
    svg += fmt::format("<path class=grid d='M0 {:.1f}H{:.1f}'/>", canvas.y(y), canvas.width());
  }
  return svg;
}

std::string ObjectShape(const Canvas& canvas, const ObjectRow& object) {
  const auto corners = Footprint(object);
  std::string points;
  for (const Eigen::Vector3d& c : corners) {
    points += fmt::format("{:.1f},{:.1f} ", canvas.x(c.x()), canvas.y(c.y()));
  }
  const Eigen::Vector3d& centre = object.world_from_object.translation_m;
  return fmt::format(
      "<polygon points='{}' fill='rgb({},{},{})' fill-opacity='.55' stroke='#222'/>"
      "<path d='M{:.1f} {:.1f}L{:.1f} {:.1f}' stroke='#222' stroke-width='4'/>"
      "<text x='{:.1f}' y='{:.1f}' text-anchor='middle'>{}</text>",
      points,
      object.colour.r,
      object.colour.g,
      object.colour.b,
      canvas.x(corners[0].x()),
      canvas.y(corners[0].y()),
      canvas.x(corners[1].x()),
      canvas.y(corners[1].y()),
      canvas.x(centre.x()),
      canvas.y(centre.y()) + 4,
      EscapeHtml(object.name));
}

std::string CameraPath(const Canvas& canvas, std::span<const TrackedFrame> frames) {
  std::string svg;
  for (std::size_t i = 1; i < frames.size(); ++i) {
    const Eigen::Vector3d& a = frames[i - 1].world_from_camera.translation_m;
    const Eigen::Vector3d& b = frames[i].world_from_camera.translation_m;
    svg += fmt::format("<path d='M{:.1f} {:.1f}L{:.1f} {:.1f}' stroke='{}' stroke-width='2'/>",
                       canvas.x(a.x()),
                       canvas.y(a.y()),
                       canvas.x(b.x()),
                       canvas.y(b.y()),
                       StatusColour(frames[i].status));
  }
  return svg;
}

std::string TrackedPath(const Canvas& canvas, std::span<const Pose3> world_from_camera) {
  if (world_from_camera.size() < 2) return {};
  std::string svg = "<path fill='none' stroke='#999' stroke-dasharray='4 3' d='";
  char command = 'M';
  for (const Pose3& pose : world_from_camera) {
    svg += fmt::format("{}{:.1f} {:.1f}",
                       command,
                       canvas.x(pose.translation_m.x()),
                       canvas.y(pose.translation_m.y()));
    command = 'L';
  }
  return svg + "'/>";
}

struct PlotPoint {
  double frame = 0;
  double value_cm = 0;
};

struct PlotLine {
  std::vector<PlotPoint> points;
  std::string_view colour;
  std::string_view dashes;
};

// 1, 2 or 5 times a power of ten, so that about four lines stand over the range.
double TickStep(double range) {
  const double rough = std::max(range, 1e-6) / 4;
  const double power = std::pow(10.0, std::floor(std::log10(rough)));
  for (const double factor : {1.0, 2.0, 5.0}) {
    if (factor * power >= rough) return factor * power;
  }
  return 10 * power;
}

// Lines over the frames of the capture; the zero line is in the picture.
std::string LinePlot(std::span<const PlotLine> lines, int num_frames, std::string_view label) {
  constexpr double kWidth = 720;
  constexpr double kHeight = 130;
  constexpr double kLeastRange_cm = 2;  // less would make noise look like drift
  double low = 0;
  double high = kLeastRange_cm;
  for (const PlotLine& line : lines) {
    for (const PlotPoint& p : line.points) {
      low = std::min(low, p.value_cm);
      high = std::max(high, p.value_cm);
    }
  }
  const double step = TickStep(high - low);
  low = std::floor(low / step) * step;
  high = std::ceil(high / step) * step;
  const auto y = [&](double value) { return kHeight * (high - value) / (high - low); };
  std::string svg = fmt::format(
      "<svg viewBox='-58 -8 {} {}' role='img' aria-label='{}'>", kWidth + 68, kHeight + 30, label);
  for (double tick = low; tick <= high + 0.5 * step; tick += step) {
    svg += fmt::format(
        "<path class=grid d='M0 {0:.1f}H{1}'/><text x='-6' y='{2:.1f}' text-anchor='end'>{3:g} "
        "cm</text>",
        y(tick),
        kWidth,
        y(tick) + 4,
        std::abs(tick) < 1e-9 ? 0.0 : tick);
  }
  for (const PlotLine& line : lines) {
    svg += fmt::format("<path fill='none' stroke='{}' stroke-width='2' stroke-dasharray='{}' d='",
                       line.colour,
                       line.dashes.empty() ? "none" : line.dashes);
    char command = 'M';
    for (const PlotPoint& p : line.points) {
      svg += fmt::format(
          "{}{:.1f} {:.1f}", command, kWidth * p.frame / std::max(1, num_frames), y(p.value_cm));
      command = 'L';
    }
    svg += "'/>";
  }
  return svg +
         fmt::format(
             "<text x='0' y='{0}'>frame 0</text><text x='{1}' y='{0}' text-anchor='end'>frame "
             "{2}</text></svg>",
             kHeight + 16,
             kWidth,
             num_frames - 1);
}

}  // namespace

std::string TopView(const ReportContent& content) {
  const Canvas canvas(Bounds(content), 720);
  std::string svg = fmt::format(
      "<svg class=map viewBox='0 0 {:.0f} {:.0f}' role='img' aria-label='room from above'>",
      canvas.width(),
      canvas.height());
  svg += Grid(canvas);
  for (const ObjectRow& object : content.objects) svg += ObjectShape(canvas, object);
  svg += TrackedPath(canvas, content.tracked_world_from_camera);
  svg += CameraPath(canvas, content.map.frames);
  for (const FrameIdx keyframe : content.map.keyframes) {
    const auto& t = content.map.frames[static_cast<std::size_t>(keyframe.value)]
                        .world_from_camera.translation_m;
    svg += fmt::format(
        "<circle cx='{:.1f}' cy='{:.1f}' r='3' fill='#1d3557'/>", canvas.x(t.x()), canvas.y(t.y()));
  }
  return svg + "</svg>";
}

std::string HeightOverTime(std::span<const TrackedFrame> frames) {
  constexpr double kWidth = 720;
  constexpr double kHeight = 130;
  constexpr double kStrip = 12;
  if (frames.empty()) return {};
  double low = frames.front().world_from_camera.translation_m.z();
  double high = low;
  for (const TrackedFrame& f : frames) {
    low = std::min(low, f.world_from_camera.translation_m.z());
    high = std::max(high, f.world_from_camera.translation_m.z());
  }
  low = std::min(0.0, low);
  high = std::max(high, low + 0.5) * 1.1;
  const double step = kWidth / static_cast<double>(frames.size());
  const auto y = [&](double z) { return kHeight * (high - z) / (high - low); };
  std::string line;
  std::string strip;
  for (std::size_t i = 0; i < frames.size(); ++i) {
    const double x = step * static_cast<double>(i);
    line += fmt::format(
        "{}{:.1f} {:.1f}", i == 0 ? 'M' : 'L', x, y(frames[i].world_from_camera.translation_m.z()));
    strip += fmt::format("<rect x='{:.2f}' y='{}' width='{:.2f}' height='{}' fill='{}'/>",
                         x,
                         kHeight + 4,
                         step + 0.05,
                         kStrip,
                         StatusColour(frames[i].status));
  }
  std::string svg =
      fmt::format("<svg viewBox='-40 -6 {} {}' role='img' aria-label='camera height'>",
                  kWidth + 50,
                  kHeight + kStrip + 12);
  for (double z = std::ceil(low * 2) / 2; z <= high; z += 0.5) {
    svg += fmt::format(
        "<path class=grid d='M0 {:.1f}H{}'/><text x='-6' y='{:.1f}' "
        "text-anchor='end'>{:.1f} m</text>",
        y(z),
        kWidth,
        y(z) + 4,
        z);
  }
  svg += fmt::format(
      "<path fill='none' stroke='#1d3557' stroke-width='2' d='{}'/>{}</svg>", line, strip);
  return svg;
}

std::string HeightDrift(std::span<const HeightCheck> heights, int num_frames) {
  if (heights.size() < 2) return {};
  std::vector<PlotPoint> before;
  std::vector<PlotPoint> after;
  for (const HeightCheck& h : heights) {
    const double frame = h.frame.value;
    before.push_back({frame, 100 * (h.before_m - h.measured_m)});
    after.push_back({frame, 100 * (h.after_m - h.measured_m)});
  }
  const PlotLine lines[] = {{before, "#999", "5 3"}, {after, "#1d3557", ""}};
  return LinePlot(lines, num_frames, "drift of the height, cm");
}

std::string GraphCorrection(std::span<const TrackedFrame> frames,
                            std::span<const Pose3> tracked_world_from_camera) {
  const std::size_t count = std::min(frames.size(), tracked_world_from_camera.size());
  if (count < 2) return {};
  std::vector<PlotPoint> moved;
  for (std::size_t i = 0; i < count; ++i) {
    const Eigen::Vector3d step =
        frames[i].world_from_camera.translation_m - tracked_world_from_camera[i].translation_m;
    moved.push_back({static_cast<double>(i), 100 * step.norm()});
  }
  const PlotLine lines[] = {{moved, "#1d3557", ""}};
  return LinePlot(lines, static_cast<int>(count), "moved by the graph, cm");
}

}  // namespace deepslam::report

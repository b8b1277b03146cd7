#include "deepslam/report/plots.h"

#include <algorithm>
#include <cmath>
#include <set>
#include <utility>
#include <vector>

#include <fmt/format.h>

#include "deepslam/report/floor_plan.h"

namespace deepslam::report {
namespace {

constexpr double kStrip_px = 12;  // height of the band of tracking's states

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

// Points of a picture, px. An hour has a hundred thousand frames: what no eye could tell apart is
// drawn once.
using Points = std::vector<Eigen::Vector2d>;

// The first, the last, and of those between what lies a pixel from the last one taken.
Points Apart(const Points& points) {
  Points apart;
  for (std::size_t n = 0; n < points.size(); ++n) {
    const bool is_end = n == 0 || n + 1 == points.size();
    if (is_end || (points[n] - apart.back()).norm() >= 1) apart.push_back(points[n]);
  }
  return apart;
}

// Of those that share half a pixel's width the first, the lowest, the highest and the last: the
// line through them covers the same. x ascends.
Points ByColumns(const Points& points) {
  const auto lower = [](const auto& a, const auto& b) { return a.y() < b.y(); };
  Points kept;
  for (auto begin = points.begin(); begin != points.end();) {
    const double column = std::floor(2 * begin->x());
    const auto end = std::find_if(
        begin, points.end(), [&](const auto& p) { return std::floor(2 * p.x()) != column; });
    const auto [lowest, highest] = std::minmax_element(begin, end, lower);
    const std::set of_column = {begin, lowest, highest, end - 1};
    for (const auto& point : of_column) kept.push_back(*point);
    begin = end;
  }
  return kept;
}

// The path data of the line through them.
std::string LineThrough(const Points& points) {
  std::string data;
  for (const Eigen::Vector2d& p : points)
    data += fmt::format("{}{:.1f} {:.1f}", data.empty() ? 'M' : 'L', p.x(), p.y());
  return data;
}

Eigen::Vector2d Place(const PlanCanvas& canvas, const Pose3& world_from_camera) {
  return canvas.ToPixels(world_from_camera.translation_m.head<2>());
}

// Each step in the colour of the frame that it leads to.
std::string CameraPath(const PlanCanvas& canvas, std::span<const TrackedFrame> frames) {
  std::string svg;
  for (std::size_t begin = 1; begin < frames.size();) {
    const TrackingStatus status = frames[begin].status;
    Points run = {Place(canvas, frames[begin - 1].world_from_camera)};
    for (; begin < frames.size() && frames[begin].status == status; ++begin)
      run.push_back(Place(canvas, frames[begin].world_from_camera));
    svg += fmt::format("<path fill='none' stroke='{}' stroke-width='2' d='{}'/>",
                       StatusColour(status),
                       LineThrough(Apart(run)));
  }
  return svg;
}

std::string TrackedPath(const PlanCanvas& canvas, std::span<const Pose3> world_from_camera) {
  if (world_from_camera.size() < 2) return {};
  Points path;
  for (const Pose3& pose : world_from_camera) path.push_back(Place(canvas, pose));
  return fmt::format("<path fill='none' stroke='#999' stroke-dasharray='4 3' d='{}'/>",
                     LineThrough(Apart(path)));
}

// One for those that share a pixel.
std::string KeyframeDots(const PlanCanvas& canvas, const OptimizedMap& map) {
  std::string svg;
  std::set<std::pair<long, long>> taken;
  for (const FrameIdx keyframe : map.keyframes) {
    const Eigen::Vector2d at =
        Place(canvas, map.frames[static_cast<std::size_t>(keyframe.value)].world_from_camera);
    if (!taken.emplace(std::lround(at.x()), std::lround(at.y())).second) continue;
    svg += fmt::format("<circle cx='{:.1f}' cy='{:.1f}' r='3' fill='#1d3557'/>", at.x(), at.y());
  }
  return svg;
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
  constexpr double kWidth = 720;        // units of the drawing, which is scaled to the page
  constexpr double kHeight = 130;       // curves are read along time: wide and low
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
    Points points;
    for (const PlotPoint& p : line.points)
      points.emplace_back(kWidth * p.frame / std::max(1, num_frames), y(p.value_cm));
    svg +=
        fmt::format("<path fill='none' stroke='{}' stroke-width='2' stroke-dasharray='{}' d='{}'/>",
                    line.colour,
                    line.dashes.empty() ? "none" : line.dashes,
                    LineThrough(ByColumns(points)));
  }
  return svg +
         fmt::format(
             "<text x='0' y='{0}'>frame 0</text><text x='{1}' y='{0}' text-anchor='end'>frame "
             "{2}</text></svg>",
             kHeight + 16,
             kWidth,
             num_frames - 1);
}

// A band below a plot, each frame in its status' colour and at least as wide as can be seen where
// something is amiss: drawn last.
std::string StatusStrip(std::span<const TrackedFrame> frames, double y_px, double step_px) {
  constexpr double kLeast_px = 0.5;  // narrower bands are not seen
  std::string as_it_should;
  std::string amiss;
  for (std::size_t begin = 0, end = 0; begin < frames.size(); begin = end) {
    const TrackingStatus status = frames[begin].status;
    while (end < frames.size() && frames[end].status == status) ++end;
    const double width_px = step_px * static_cast<double>(end - begin) + 0.05;
    const bool fine = status == TrackingStatus::kTracked;
    (fine ? as_it_should : amiss) +=
        fmt::format("<rect x='{:.2f}' y='{}' width='{:.2f}' height='{}' fill='{}'/>",
                    step_px * static_cast<double>(begin),
                    y_px,
                    fine ? width_px : std::max(width_px, kLeast_px),
                    kStrip_px,
                    StatusColour(status));
  }
  return as_it_should + amiss;
}

}  // namespace

std::string PlanWithPath(const ReportContent& content) {
  FloorPlanContent plan;
  plan.title = content.title;
  plan.layout_world = content.layout_world;
  for (const ObjectRow& object : content.objects) {
    plan.things.push_back(
        MakePlanThing(object.name, object.world_from_object, object.size_m, object.colour));
  }
  for (const TrackedFrame& frame : content.map.frames)
    plan.others_m.emplace_back(frame.world_from_camera.translation_m.head<2>());
  return FloorPlan(plan, [&](const PlanCanvas& canvas) {
    return "<g class='fp-path' opacity='.75'>" +
           TrackedPath(canvas, content.tracked_world_from_camera) +
           CameraPath(canvas, content.map.frames) + KeyframeDots(canvas, content.map) + "</g>";
  });
}

std::string HeightOverTime(std::span<const TrackedFrame> frames) {
  constexpr double kWidth = 720;   // as LinePlot, since they stand below each other
  constexpr double kHeight = 130;  // without frame of axes and strip
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
  Points line;
  for (std::size_t i = 0; i < frames.size(); ++i) {
    line.emplace_back(step * static_cast<double>(i),
                      y(frames[i].world_from_camera.translation_m.z()));
  }
  std::string svg =
      fmt::format("<svg viewBox='-40 -6 {} {}' role='img' aria-label='camera height'>",
                  kWidth + 50,
                  kHeight + kStrip_px + 12);
  for (double z = std::ceil(low * 2) / 2; z <= high; z += 0.5) {
    svg += fmt::format(
        "<path class=grid d='M0 {:.1f}H{}'/><text x='-6' y='{:.1f}' "
        "text-anchor='end'>{:.1f} m</text>",
        y(z),
        kWidth,
        y(z) + 4,
        z);
  }
  svg += fmt::format("<path fill='none' stroke='#1d3557' stroke-width='2' d='{}'/>{}</svg>",
                     LineThrough(ByColumns(line)),
                     StatusStrip(frames, kHeight + 4, step));
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

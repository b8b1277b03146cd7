#include "deepslam/segment/segment_objects.h"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <utility>

#include "deepslam/scene/ground.h"
#include "deepslam/segment/assign_pieces.h"
#include "deepslam/segment/connect.h"
#include "deepslam/segment/fill_unmeasured.h"
#include "deepslam/segment/image_pieces.h"
#include "deepslam/segment/region.h"
#include "deepslam/segment/support_plane.h"
#include "deepslam/segment/surface_behind.h"
#include "deepslam/segment/top_carriers.h"

namespace deepslam::segment {
namespace {

// Parts apart from the main one belong to it inside its bounds widened by this.
constexpr float kExtentMargin_m = 0.05F;
// Width of the weight by which the middle of a box counts, in units of the box's sides.
constexpr double kCentralWidth = 0.3;

// Points in axes along the ground's tangents and its normal, so that bounds of upright things are
// tight.
Eigen::Matrix3f Upright(const std::optional<Plane>& ground_camera) {
  if (!ground_camera) return Eigen::Matrix3f::Identity();
  Eigen::Matrix3d axes;
  axes << GroundTangentBasis(ground_camera->normal), ground_camera->normal;
  return axes.transpose().cast<float>();
}

// Drops what neither hangs together with the main part nor lies within its bounds.
std::vector<PixelPoint> KeepMainPart(const std::vector<PixelPoint>& points,
                                     const Region& region,
                                     const std::optional<Plane>& ground_camera) {
  const Groups groups = ConnectPoints(points, SegmentOptions::kJoin_m);
  if (groups.count <= 1) return points;
  const double u_mid = 0.5 * (region.u_min + region.u_max);
  const double v_mid = 0.5 * (region.v_min + region.v_max);
  const double u_width = kCentralWidth * (region.u_max - region.u_min + 1);
  const double v_width = kCentralWidth * (region.v_max - region.v_min + 1);
  const int main = groups.Heaviest([&](std::size_t i) {
    const double du = (points[i].u - u_mid) / u_width;
    const double dv = (points[i].v - v_mid) / v_width;
    return std::exp(-0.5 * (du * du + dv * dv));
  });
  const Eigen::Matrix3f upright = Upright(ground_camera);
  Eigen::Vector3f low = Eigen::Vector3f::Constant(1e9F);
  Eigen::Vector3f high = -low;
  for (std::size_t i = 0; i < points.size(); ++i) {
    if (groups.of_point[i] != main) continue;
    const Eigen::Vector3f p = upright * points[i].p_camera;
    low = low.cwiseMin(p);
    high = high.cwiseMax(p);
  }
  low.array() -= kExtentMargin_m;
  high.array() += kExtentMargin_m;
  if (ground_camera) low.z() = -1e9F;  // legs reach down to the ground
  std::vector<PixelPoint> kept;
  for (std::size_t i = 0; i < points.size(); ++i) {
    const Eigen::Vector3f p = upright * points[i].p_camera;
    const bool within = (p.array() >= low.array()).all() && (p.array() <= high.array()).all();
    if (groups.of_point[i] == main || within) kept.push_back(points[i]);
  }
  return kept;
}

// The support planes of those whose class has one, with their pixels claimed.
std::vector<OwnedTop> ClaimTops(const FrameToSegment& seen,
                                const ClassTable& classes,
                                const ImagePieces& pieces,
                                std::span<const Region> regions,
                                Owners& owners) {
  std::vector<OwnedTop> tops;
  std::vector<PieceHeights> heights;
  for (std::size_t d = 0; d < seen.detections.size(); ++d) {
    if (!classes.TraitsOf(seen.detections[d].class_name).support_plane) continue;
    if (heights.empty()) heights = HeightsOf(pieces);
    const int owner = static_cast<int>(d);
    std::optional<SupportPlane> top = ClaimSupportPlane(
        pieces, heights, seen.camera, *seen.ground_camera, regions[d], owner, owners);
    if (top) tops.push_back({owner, std::move(*top)});
  }
  return tops;
}

// What is a support plane has what lies on it, and no more.
std::vector<bool> TakesPieces(std::size_t num_detections, std::span<const OwnedTop> tops) {
  std::vector<bool> takes(num_detections, true);
  for (const OwnedTop& top : tops) takes[static_cast<std::size_t>(top.owner)] = false;
  return takes;
}

std::vector<std::vector<PixelPoint>> PointsOf(const ImagePieces& pieces,
                                              std::span<const Region> regions,
                                              const Owners& owners) {
  std::vector<std::vector<PixelPoint>> points(regions.size());
  for (int v = 0; v < owners.height(); ++v) {
    const std::int32_t* const owner_row = owners.row(v);
    for (int u = 0; u < owners.width(); ++u) {
      const std::int32_t owner = owner_row[u];
      if (owner < 0 || !regions[static_cast<std::size_t>(owner)].Contains(u, v)) continue;
      points[static_cast<std::size_t>(owner)].push_back({u, v, pieces.points_camera(u, v)});
    }
  }
  return points;
}

Segment Describe(const Detection& detection,
                 const Region& region,
                 const std::vector<PixelPoint>& points,
                 int width,
                 int height,
                 const SegmentOptions& options,
                 Mask& mask) {
  Segment segment;
  segment.detection = detection.id;
  segment.frame = detection.frame;
  segment.class_name = detection.class_name;
  segment.score = detection.score;
  segment.source = detection.source;
  segment.box_px = detection.box_px;
  mask = Mask(width, height);
  for (const PixelPoint& p : points) {
    mask(p.u, p.v) = 1;
    segment.extent_camera.Extend(p.p_camera.cast<double>());
  }
  segment.num_points = static_cast<int>(points.size());
  const int area_px = region.area_px();
  segment.depth_support = area_px > 0 ? static_cast<double>(points.size()) / area_px : 0.0;
  const double margin = SegmentOptions::kBorderMargin_px;
  segment.touches_border = region.empty() || region.u_min < margin || region.v_min < margin ||
                           region.u_max > width - 1 - margin || region.v_max > height - 1 - margin;
  segment.usable = segment.num_points >= options.min_points &&
                   segment.depth_support >= SegmentOptions::kMinBoxShare;
  if (region.empty()) {
    segment.reason = "box outside the image";
  } else if (segment.num_points < options.min_points) {
    segment.reason = "too few points";
  } else if (!segment.usable) {
    segment.reason = "too little depth in the box";
  }
  return segment;
}

}  // namespace

void Describe(OptionsVisitor& visitor, SegmentOptions& options) {
  visitor.Field("max_depth_m", options.max_depth_m, {0.5, 50}, "m", "farther depth is not used");
}

std::vector<Segment> SegmentFrame(const FrameToSegment& seen,
                                  const ClassTable& classes,
                                  const SegmentOptions& options) {
  const auto& [frame, camera, ground_camera, detections, upright] = seen;
  const int width = frame.depth_m.width();
  const int height = frame.depth_m.height();
  const std::vector<Region> regions = MakeRegions(detections, width, height, options);
  Owners owners(width, height, -1);
  ImagePieces pieces;
  std::vector<OwnedTop> tops;
  if (!detections.empty() && camera.fx > 0 && camera.fy > 0) {
    pieces = CutIntoPieces(frame.depth_m, camera, ground_camera, options);
    if (ground_camera) {
      tops = ClaimTops(seen, classes, pieces, regions, owners);
      ClaimCarriers(pieces, *ground_camera, tops, owners);
    }
    AssignPieces(pieces, regions, TakesPieces(detections.size(), tops), options, owners);
  }
  const std::vector<std::vector<PixelPoint>> points = PointsOf(pieces, regions, owners);
  std::vector<Segment> segments;
  Mask filled(width, height);
  for (std::size_t d = 0; d < detections.size(); ++d) {
    const bool is_top = std::any_of(tops.begin(), tops.end(), [d](const OwnedTop& top) {
      return top.owner == static_cast<int>(d);
    });
    const std::vector<PixelPoint> kept =
        is_top ? points[d] : KeepMainPart(points[d], regions[d], ground_camera);
    Mask mask;
    segments.push_back(Describe(detections[d], regions[d], kept, width, height, options, mask));
    // Clusters are depth themselves.
    Segment& segment = segments.back();
    if (segment.usable && !is_top && segment.source != DetectionSource::kCluster &&
        IsSurfaceBehind(kept, regions[d], frame.depth_m, camera, ground_camera, upright)) {
      segment.usable = false;
      segment.reason = "its depth is that of the wall behind";
    }
    FillUnmeasured(frame.depth_m, camera, regions[d], SegmentOptions::kFillGap_m, filled, mask);
    segment.mask = mask;
  }
  return segments;
}

}  // namespace deepslam::segment

#include "deepslam/registration/measured_view.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <vector>

#include "deepslam/core/order_statistics.h"
#include "deepslam/core/parallel.h"
#include "deepslam/geometry/depth_noise.h"
#include "deepslam/shape/view_points.h"

namespace deepslam::registration {
namespace {

// Neighbouring depths further apart than this share of the depth are different surfaces.
constexpr double kJumpShare = 0.03;
// Two views that measure a point within this along the ray mean the same surface, drift and noise
// included.
constexpr double kSameSurfaceM = 0.05;

bool IsUsable(const ObjectView& view) {
  const int width = view.depth_crop_m.width();
  const int height = view.depth_crop_m.height();
  const PinholeCamera& camera = view.camera;
  const bool fits = width > 0 && height > 0 && view.mask_crop.width() == width &&
                    view.mask_crop.height() == height;
  const bool camera_ok = std::isfinite(camera.fx) && std::isfinite(camera.fy) && camera.fx > 0 &&
                         camera.fy > 0 && std::isfinite(camera.cx) && std::isfinite(camera.cy);
  const Pose3& pose = view.world_from_camera;
  return fits && camera_ok && pose.translation_m.allFinite() &&
         pose.rotation.coeffs().allFinite() && std::abs(pose.rotation.norm() - 1.0) < 1e-3;
}

bool IsValidDepth(float depth_m) { return std::isfinite(depth_m) && depth_m > 0.0f; }

void AddPoints(const ObjectView& view, int max_points, MeasuredView& out) {
  const shape::ViewPoints points = shape::ExtractViewPoints(view, max_points);
  for (std::size_t i = 0; i < points.points_camera.size(); ++i) {
    const Eigen::Vector3f& point = points.points_camera[i];
    const Eigen::Vector3f& normal = points.normals_camera[i];
    if (!point.allFinite() || !normal.allFinite() || std::abs(normal.norm() - 1.0f) > 0.01f)
      continue;
    out.points_camera.push_back(point);
    out.normals_camera.push_back(normal);
    out.sigmas_m.push_back(static_cast<float>(DepthSigmaM(point.z())));
  }
}

// A reduced pixel takes the middle pixel of its block, or the first valid one where the middle has
// no depth.
void AddReducedCrop(const ObjectView& view, int factor, MeasuredView& out) {
  out.camera = view.camera.Reduced(factor);
  const int width = std::max(1, view.depth_crop_m.width() / factor);
  const int height = std::max(1, view.depth_crop_m.height() / factor);
  out.camera.width = width;
  out.camera.height = height;
  out.depth_m = DepthImage(width, height);
  out.mask = Mask(width, height);
  const auto pick = [&](int u, int v) {
    const int u_max = std::min(view.depth_crop_m.width(), (u + 1) * factor);
    const int v_max = std::min(view.depth_crop_m.height(), (v + 1) * factor);
    std::array<int, 2> best = {std::min(u * factor + factor / 2, u_max - 1),
                               std::min(v * factor + factor / 2, v_max - 1)};
    if (IsValidDepth(view.depth_crop_m(best[0], best[1]))) return best;
    for (int y = v * factor; y < v_max; ++y) {
      for (int x = u * factor; x < u_max; ++x) {
        if (IsValidDepth(view.depth_crop_m(x, y))) return std::array<int, 2>{x, y};
      }
    }
    return best;
  };
  for (int v = 0; v < height; ++v) {
    for (int u = 0; u < width; ++u) {
      const auto [x, y] = pick(u, v);
      const float depth = view.depth_crop_m(x, y);
      if (!IsValidDepth(depth)) continue;
      out.depth_m(u, v) = depth;
      out.mask(u, v) = view.mask_crop(x, y) != 0 ? 1 : 0;
    }
  }
}

void AddNormals(MeasuredView& out) {
  const int width = out.depth_m.width();
  const int height = out.depth_m.height();
  out.normals = Image<Eigen::Vector3f>(width, height, Eigen::Vector3f::Zero());
  std::vector<double> rays_x, rays_y;
  for (int u = 0; u < width; ++u) rays_x.push_back(out.camera.Ray(u, 0).x());
  for (int v = 0; v < height; ++v) rays_y.push_back(out.camera.Ray(0, v).y());
  const auto point = [&](int u, int v) -> Eigen::Vector3d {
    const auto depth = static_cast<double>(out.depth_m(u, v));
    return depth * Eigen::Vector3d(rays_x[static_cast<std::size_t>(u)],
                                   rays_y[static_cast<std::size_t>(v)],
                                   1.0);
  };
  for (int v = 1; v + 1 < height; ++v) {
    for (int u = 1; u + 1 < width; ++u) {
      const double depth = out.depth_m(u, v);
      const std::array<float, 4> around = {out.depth_m(u - 1, v),
                                           out.depth_m(u + 1, v),
                                           out.depth_m(u, v - 1),
                                           out.depth_m(u, v + 1)};
      const bool smooth = depth > 0 && std::all_of(around.begin(), around.end(), [&](float d) {
                            return d > 0 && std::abs(d - depth) < kJumpShare * depth;
                          });
      if (!smooth) continue;
      const Eigen::Vector3d normal =
          (point(u + 1, v) - point(u - 1, v)).cross(point(u, v + 1) - point(u, v - 1));
      if (!(normal.norm() > 1e-12)) continue;
      const Eigen::Vector3d unit = normal.normalized();
      out.normals(u, v) = (unit.dot(point(u, v)) > 0 ? Eigen::Vector3d(-unit) : unit).cast<float>();
    }
  }
}

// In every pixel the nearest row of its column with an object pixel, of two the first; -1 without.
Image<int> NearestObjectRows(const Mask& mask) {
  Image<int> nearest_row(mask.width(), mask.height(), -1);
  for (int u = 0; u < mask.width(); ++u) {
    int last = -1;
    for (int v = 0; v < mask.height(); ++v) {
      if (mask(u, v) != 0) last = v;
      nearest_row(u, v) = last;
    }
    last = -1;
    for (int v = mask.height() - 1; v >= 0; --v) {
      if (mask(u, v) != 0) last = v;
      const int above = nearest_row(u, v);
      if (last >= 0 && (above < 0 || last - v < v - above)) nearest_row(u, v) = last;
    }
  }
  return nearest_row;
}

// The nearest object pixel to (u, v), of several that of the first column; `nearest_row` is of row
// v. Columns are asked outwards until none can be nearer.
PixelIndex NearestObjectPixel(const int* nearest_row, int width, int u, int v) {
  PixelIndex nearest;
  int best = std::numeric_limits<int>::max();
  const auto ask = [&](int x, int squared_step) {
    const int row = nearest_row[x];
    if (row < 0) return;
    const int squared = squared_step + (row - v) * (row - v);
    if (squared > best || (squared == best && x > nearest.u)) return;
    best = squared;
    nearest = {static_cast<std::int16_t>(x), static_cast<std::int16_t>(row)};
  };
  for (int step = 0; step < width && step * step <= best; ++step) {
    if (u - step >= 0) ask(u - step, step * step);
    if (step > 0 && u + step < width) ask(u + step, step * step);
  }
  return nearest;
}

// Exact, separable.
void AddNearestObjectPixel(MeasuredView& out) {
  const int width = out.mask.width();
  const int height = out.mask.height();
  out.nearest_object_pixel = Image<PixelIndex>(width, height);
  const Image<int> nearest_row = NearestObjectRows(out.mask);
  for (int v = 0; v < height; ++v) {
    for (int u = 0; u < width; ++u)
      out.nearest_object_pixel(u, v) = NearestObjectPixel(nearest_row.row(v), width, u, v);
  }
}

double PatchShare(const std::vector<Eigen::Vector3f>& points, double patch_m) {
  std::vector<std::array<int, 3>> patches;
  patches.reserve(points.size());
  for (const Eigen::Vector3f& point : points) {
    const Eigen::Vector3d cell = (point.cast<double>() / patch_m).array().floor();
    patches.push_back(
        {static_cast<int>(cell.x()), static_cast<int>(cell.y()), static_cast<int>(cell.z())});
  }
  std::sort(patches.begin(), patches.end());
  patches.erase(std::unique(patches.begin(), patches.end()), patches.end());
  return points.empty() ? 0.0
                        : static_cast<double>(patches.size()) / static_cast<double>(points.size());
}

// How the other views see a point: +1 where it lies in their segment, -1 where they measured the
// same surface but outside it, 0 where they say nothing.
int VoteOn(const Eigen::Vector3d& p_world, const MeasuredView& other) {
  const Eigen::Vector3d p = other.world_from_camera.Inverse() * p_world;
  const auto pixel = other.camera.Project(p);
  if (!pixel || !(pixel->cwiseAbs().maxCoeff() < 1e6)) return 0;
  const int u = static_cast<int>(std::lround(pixel->x()));
  const int v = static_cast<int>(std::lround(pixel->y()));
  if (!other.depth_m.Contains(u, v) || other.depth_m(u, v) <= 0) return 0;
  if (std::abs(other.depth_m(u, v) - p.z()) > kSameSurfaceM) return 0;
  return other.mask(u, v) != 0 ? 1 : -1;
}

// Which points of a view most other views that see them count to something else: background under a
// wrong mask.
std::vector<bool> Outvoted(const MeasuredView& view, std::span<const MeasuredView> all) {
  std::vector<bool> outvoted;
  for (const Eigen::Vector3f& point : view.points_camera) {
    const Eigen::Vector3d p_world = view.world_from_camera * point.cast<double>();
    int votes = 1;  // its own
    for (const MeasuredView& other : all) {
      if (&other != &view && !other.empty()) votes += VoteOn(p_world, other);
    }
    outvoted.push_back(votes < 0);
  }
  return outvoted;
}

void RemovePoints(const std::vector<bool>& removed, MeasuredView& view) {
  std::size_t kept = 0;
  for (std::size_t i = 0; i < removed.size(); ++i) {
    if (removed[i]) continue;
    view.points_camera[kept] = view.points_camera[i];
    view.normals_camera[kept] = view.normals_camera[i];
    view.sigmas_m[kept] = view.sigmas_m[i];
    ++kept;
  }
  view.points_camera.resize(kept);
  view.normals_camera.resize(kept);
  view.sigmas_m.resize(kept);
}

void AddStatistics(double patch_m, MeasuredView& view) {
  view.patch_m = patch_m;
  view.patch_share = PatchShare(view.points_camera, patch_m);
  Eigen::Vector3d sum = Eigen::Vector3d::Zero();
  for (const Eigen::Vector3f& point : view.points_camera) sum += point.cast<double>();
  if (!view.empty()) view.centroid_camera = sum / static_cast<double>(view.points_camera.size());
}

bool IsUsablePlane(const Plane& plane) {
  return plane.normal.allFinite() && std::abs(plane.normal.norm() - 1.0) < 1e-3 &&
         std::isfinite(plane.d_m);
}

// Mean normal, and the median height under the object: planes seen under tracking drift differ most
// far away from it.
std::optional<Plane> ConsensusGround(std::span<const ObjectView> views,
                                     std::span<const MeasuredView> measured) {
  std::vector<Plane> planes;
  Eigen::Vector3d centroid = Eigen::Vector3d::Zero();
  Eigen::Vector3d normal = Eigen::Vector3d::Zero();
  for (std::size_t i = 0; i < views.size(); ++i) {
    if (measured[i].empty() || !views[i].ground_camera || !IsUsablePlane(*views[i].ground_camera)) {
      continue;
    }
    planes.push_back(Transformed(measured[i].world_from_camera, *views[i].ground_camera));
    centroid += measured[i].world_from_camera * measured[i].centroid_camera;
    normal += planes.back().normal;
  }
  if (planes.empty() || normal.norm() < 0.5 * static_cast<double>(planes.size())) {
    return std::nullopt;
  }
  centroid /= static_cast<double>(planes.size());
  normal.normalize();
  std::vector<double> heights;
  for (const Plane& plane : planes) heights.push_back(plane.SignedDistance(centroid));
  return Plane{normal, Median(heights) - normal.dot(centroid)};
}

// Without any ground the mean of the cameras' own "up" is the best guess.
Eigen::Vector3d AssumedUpWorld(std::span<const MeasuredView> measured) {
  Eigen::Vector3d up = Eigen::Vector3d::Zero();
  for (const MeasuredView& view : measured) {
    if (!view.empty()) up -= view.world_from_camera.rotation * Eigen::Vector3d::UnitY();
  }
  return up.norm() > 1e-6 ? up.normalized() : Eigen::Vector3d(-Eigen::Vector3d::UnitY());
}

}  // namespace

std::vector<MeasuredView> PrepareViews(std::span<const ObjectView> views,
                                       int max_points,
                                       int max_side_px,
                                       double patch_m) {
  std::vector<MeasuredView> measured(views.size());
  ParallelFor(views.size(), [&](std::size_t i) {
    MeasuredView& out = measured[i];
    out.view = views[i].detection;
    out.frame = views[i].frame;
    out.touches_border = views[i].touches_border;
    if (!IsUsable(views[i])) return;
    out.world_from_camera = views[i].world_from_camera;
    AddPoints(views[i], max_points, out);
    const int side = std::max(views[i].depth_crop_m.width(), views[i].depth_crop_m.height());
    AddReducedCrop(views[i], (side + max_side_px - 1) / max_side_px, out);
    AddNormals(out);
    AddNearestObjectPixel(out);
  });
  std::vector<std::vector<bool>> outvoted(measured.size());
  ParallelFor(measured.size(),
              [&](std::size_t i) { outvoted[i] = Outvoted(measured[i], measured); });
  ParallelFor(measured.size(), [&](std::size_t i) {
    RemovePoints(outvoted[i], measured[i]);
    AddStatistics(patch_m, measured[i]);
  });
  const std::optional<Plane> ground = ConsensusGround(views, measured);
  const Eigen::Vector3d up_world = ground ? ground->normal : AssumedUpWorld(measured);
  for (MeasuredView& view : measured) {
    view.ground_world = ground;
    view.up_camera = view.world_from_camera.rotation.conjugate() * up_world;
  }
  return measured;
}

}  // namespace deepslam::registration

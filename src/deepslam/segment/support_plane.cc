#include "deepslam/segment/support_plane.h"

#include <cmath>
#include <cstddef>
#include <utility>

#include "deepslam/core/wide_vectors.h"
#include "deepslam/segment/outline.h"

namespace deepslam::segment {
namespace {

constexpr int kMinTop_px = 150;  // fewer pixels at one height have no certain outline

// Where the rays through a row of the image, every other pixel, meet the height of a top.
struct RowAtHeight {
  explicit RowAtHeight(std::size_t size) : z_m(size), x_ground_m(size), y_ground_m(size) {}

  std::vector<double> z_m;  // not above 0: they do not meet it
  std::vector<double> x_ground_m;
  std::vector<double> y_ground_m;
};

DEEPSLAM_WIDE_VECTORS void MeetHeight(const std::vector<double>& rays_x,
                                      double ray_y,
                                      const Plane& ground_camera,
                                      const GroundAxes& axes,
                                      double height_m,
                                      RowAtHeight& row) {
  const double from_camera_m = height_m - ground_camera.d_m;
  const Plane ground = ground_camera;
  const GroundAxes on_ground = axes;
  const double* const ray_x = rays_x.data();
  double* const z_m = row.z_m.data();
  double* const x_ground_m = row.x_ground_m.data();
  double* const y_ground_m = row.y_ground_m.data();
  const std::size_t count = rays_x.size();
#pragma GCC ivdep
  for (std::size_t n = 0; n < count; ++n) {
    const double fall =
        ground.normal.x() * ray_x[n] + ground.normal.y() * ray_y + ground.normal.z();
    const double z = from_camera_m / fall;
    const double x = z * ray_x[n];
    const double y = z * ray_y;
    x_ground_m[n] = on_ground.Along(0, x, y, z);
    y_ground_m[n] = on_ground.Along(1, x, y, z);
    z_m[n] = fall < 0 ? z : 0.0;
  }
}

// Share of the rays through a supposed top that end on it, of those that end on it or go on below:
// a top hides what is under it. What stands on it or before it, and rays without depth, say
// nothing.
double OpaqueShare(const ImagePieces& pieces,
                   const PinholeCamera& camera,
                   const Plane& ground_camera,
                   const Region& region,
                   const SupportPlane& top) {
  constexpr int kStep_px = 2;  // a quarter of the pixels is enough for a share
  if (ground_camera.d_m <= top.height_m) return 1.0;  // seen from below
  const GroundAxes axes(ground_camera);
  std::vector<double> rays_x;
  for (int u = region.u_min; u <= region.u_max; u += kStep_px)
    rays_x.push_back(camera.Ray(u, 0).x());
  RowAtHeight row(rays_x.size());
  WithinHull within(top.hull_ground_m, 0.0);
  int on = 0;
  int below = 0;
  for (int v = region.v_min; v <= region.v_max; v += kStep_px) {
    MeetHeight(rays_x, camera.Ray(0, v).y(), ground_camera, axes, top.height_m, row);
    for (std::size_t n = 0; n < rays_x.size(); ++n) {
      const int u = region.u_min + kStep_px * static_cast<int>(n);
      const bool beyond = pieces.beyond(u, v) != 0;
      if (!(pieces.points_camera.z_m(u, v) > 0) && !beyond) continue;
      if (!(row.z_m[n] > 0) || !within(row.x_ground_m[n], row.y_ground_m[n])) continue;
      const double over_m = beyond ? -1.0 : pieces.height_m(u, v) - top.height_m;
      const double thickness_m = TopThicknessAt(row.z_m[n]);
      on += std::abs(over_m) <= thickness_m ? 1 : 0;
      below += over_m < -thickness_m ? 1 : 0;
    }
  }
  return on > 0 ? static_cast<double>(on) / (on + below) : 0.0;
}

PlanarPoints OnGround(std::span<const PixelPoint> pixels, const GroundAxes& axes) {
  PlanarPoints on_ground;
  on_ground.x_m.reserve(pixels.size());
  on_ground.y_m.reserve(pixels.size());
  for (const PixelPoint& pixel : pixels) {
    const Eigen::Vector3d p = pixel.p_camera.cast<double>();
    on_ground.x_m.push_back(axes.Along(0, p.x(), p.y(), p.z()));
    on_ground.y_m.push_back(axes.Along(1, p.x(), p.y(), p.z()));
  }
  return on_ground;
}

struct FoundTop {
  SupportPlane top;
  std::vector<PixelPoint> pixels;
};

// The layer with the largest outline that hides what is under it. The outline counts and not the
// pixels, since dark, shiny and glass tops return depth at their rims alone while seats before them
// return all.
std::optional<FoundTop> FindTop(const ImagePieces& pieces,
                                std::span<const PieceHeights> heights,
                                const PinholeCamera& camera,
                                const Plane& ground_camera,
                                const Region& region,
                                const Owners& owners) {
  constexpr double kLeastOpaque = 0.5;  // what is seen through for the most part is no top
  const GroundAxes axes(ground_camera);
  const HeightLayers layers(pieces, heights, region, owners);
  std::optional<FoundTop> best;
  double best_score = 0;
  for (const double height_m : layers.PeakHeights()) {
    FoundTop found;
    found.pixels = layers.At(height_m);
    if (found.pixels.size() < static_cast<std::size_t>(kMinTop_px)) continue;
    found.top = {height_m, ConvexHull(OnGround(found.pixels, axes))};
    if (found.top.hull_ground_m.size() < 3) continue;
    // The share is 1 at most.
    const double double_area_m2 = DoubleArea(found.top.hull_ground_m);
    if (double_area_m2 <= best_score) continue;
    const double opaque = OpaqueShare(pieces, camera, ground_camera, region, found.top);
    const double score = opaque * double_area_m2;
    if (opaque < kLeastOpaque || score <= best_score) continue;
    best_score = score;
    best = std::move(found);
  }
  return best;
}

}  // namespace

std::optional<SupportPlane> ClaimSupportPlane(const ImagePieces& pieces,
                                              std::span<const PieceHeights> heights,
                                              const PinholeCamera& camera,
                                              const Plane& ground_camera,
                                              const Region& region,
                                              int owner,
                                              Owners& owners) {
  std::optional<FoundTop> found = FindTop(pieces, heights, camera, ground_camera, region, owners);
  if (!found) return std::nullopt;
  for (const PixelPoint& p : found->pixels) owners(p.u, p.v) = owner;
  return std::move(found->top);
}

}  // namespace deepslam::segment

#include "deepslam/segment/smooth_links.h"

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <cstddef>
#include <utility>
#include <vector>

#include "deepslam/core/parallel.h"
#include "deepslam/core/wide_vectors.h"

namespace deepslam::segment {
namespace {

// Of one task, which surveys the row above them once more.
constexpr std::size_t kRowsPerChunk = 64;
// Normals are taken over about this length on the surface: twice the depth noise of structured
// light at 3 m, so that a normal is good to about 20 degrees.
constexpr double kNormalBaseline_m = 0.04;
constexpr int kMaxBaseline_px = 12;       // bounds the neighbourhood of what is near
constexpr float kSameSurfaceCos = 0.87F;  // 30 degrees: steps of normals inside one surface
constexpr float kHorizontalCos = 0.82F;   // 35 degrees
constexpr int kPixelLanes = 16;           // pixels side by side
static_assert(kMaxBaseline_px <= PointImage::kMarginRows);
static_assert(kPixelLanes <= PointImage::kMarginColumns &&
              kMaxBaseline_px <= PointImage::kMarginColumns);

// What is known of the pixels of a row, with a pixel of nothing before the first and some behind
// the last.
struct Row {
  explicit Row(int width)
      : x(Size(width)),
        y(Size(width)),
        z(Size(width)),
        step_m(Size(width)),
        reach_m(Size(width)),
        radius(Size(width)),
        level(Size(width)),
        link(Size(width)) {}
  static std::size_t Size(int width) { return static_cast<std::size_t>(width) + kPixelLanes + 1; }

  std::vector<float> x, y, z;        // unit normal towards the camera; zero where there is none
  std::vector<float> step_m;         // smaller steps of depth join neighbours
  std::vector<float> reach_m;        // smaller ones join pixels as far apart as normals reach
  std::vector<std::int32_t> radius;  // of normals; 0 without a point
  std::vector<std::int32_t> level;   // 1: faces up
  std::vector<std::int32_t> link;    // LinkBits
};

struct Steps {
  double fx = 0;
  double jump_m = 0;
  double jump_per_m2 = 0;
};

// The smallest float that is not below x > 0.
inline float RoundedUp(double x) {
  const auto nearest = static_cast<float>(x);
  const std::int32_t below = static_cast<double>(nearest) < x ? 1 : 0;
  return std::bit_cast<float>(std::bit_cast<std::int32_t>(nearest) + below);
}

DEEPSLAM_WIDE_VECTORS void FindReach(const float* z_row, int width, const Steps& steps, Row& row) {
  float* const step_m = row.step_m.data() + 1;
  float* const reach_m = row.reach_m.data() + 1;
  std::int32_t* const radius = row.radius.data() + 1;
  const double radius_m = 0.5 * kNormalBaseline_m * steps.fx;
  for (int u = 0; u < width; ++u) {
    const double z = z_row[u];
    const double jump_m = steps.jump_m + steps.jump_per_m2 * z * z;
    const double in_image = std::min(std::max(radius_m / z, 1.0), 1.0 * kMaxBaseline_px);
    const auto rounded = static_cast<std::int32_t>(in_image + 0.5);
    step_m[u] = RoundedUp(jump_m);
    reach_m[u] = static_cast<float>(jump_m + 2.0 * rounded * z / steps.fx);
    radius[u] = z > 0 ? rounded : 0;
  }
}

// `a` where all bits of `which` are set, `b` where none is. The compiler makes branches of `?:`
// here.
inline float Either(std::int32_t which, float a, float b) {
  return std::bit_cast<float>((std::bit_cast<std::int32_t>(a) & which) |
                              (std::bit_cast<std::int32_t>(b) & ~which));
}

// kPixelLanes pixels of a row side by side, from `u` on.
struct Lanes {
  const float* x_m;
  const float* y_m;
  const float* z_m;
};
inline Lanes LanesAt(const PointImage& points, int u, int v) {
  return {points.x_row(v) + u, points.y_row(v) + u, points.z_row(v) + u};
}

// From the cross of central differences over `radius` pixels, for kPixelLanes pixels from `u` on.
inline void FindNormals(const PointImage& points, int u, int v, int radius, Row& row) {
  const Lanes middle = LanesAt(points, u, v);
  const Lanes right = LanesAt(points, u + radius, v);
  const Lanes left = LanesAt(points, u - radius, v);
  const Lanes below = LanesAt(points, u, v + radius);
  const Lanes above = LanesAt(points, u, v - radius);
  const float* const reach_m = row.reach_m.data() + 1 + u;
  const std::int32_t* const radii = row.radius.data() + 1 + u;
  float* const old_x = row.x.data() + 1 + u;
  float* const old_y = row.y.data() + 1 + u;
  float* const old_z = row.z.data() + 1 + u;
  // Written apart from the row, so that the compiler need not fear for what it reads.
  std::array<float, kPixelLanes> normal_x;
  std::array<float, kPixelLanes> normal_y;
  std::array<float, kPixelLanes> normal_z;
  for (int n = 0; n < kPixelLanes; ++n) {
    const float x = middle.x_m[n];
    const float y = middle.y_m[n];
    const float z = middle.z_m[n];
    // A neighbour that agrees, else the pixel itself.
    const auto step = [&](const Lanes& to, const Lanes& from) {
      const float to_x = to.x_m[n];
      const float to_y = to.y_m[n];
      const float to_z = to.z_m[n];
      const float from_x = from.x_m[n];
      const float from_y = from.y_m[n];
      const float from_z = from.z_m[n];
      const auto agrees = [&](float other) {
        return -static_cast<std::int32_t>((other > 0) & (std::abs(other - z) < reach_m[n]));
      };
      const std::int32_t use_to = agrees(to_z);
      const std::int32_t use_from = agrees(from_z);
      return std::array<float, 3>{Either(use_to, to_x, x) - Either(use_from, from_x, x),
                                  Either(use_to, to_y, y) - Either(use_from, from_y, y),
                                  Either(use_to, to_z, z) - Either(use_from, from_z, z)};
    };
    const std::array<float, 3> along = step(right, left);
    const std::array<float, 3> down = step(below, above);
    const float cross_x = along[1] * down[2] - along[2] * down[1];
    const float cross_y = along[2] * down[0] - along[0] * down[2];
    const float cross_z = along[0] * down[1] - along[1] * down[0];
    const float length = std::sqrt(cross_x * cross_x + (cross_y * cross_y + cross_z * cross_z));
    const float unit_x = cross_x / length;
    const float unit_y = cross_y / length;
    const float unit_z = cross_z / length;
    const std::int32_t away =
        -static_cast<std::int32_t>(unit_x * x + (unit_y * y + unit_z * z) > 0);
    const std::int32_t is_new = -static_cast<std::int32_t>((length > 0) & (radii[n] == radius));
    const auto at = static_cast<std::size_t>(n);
    normal_x[at] = Either(is_new, Either(away, -unit_x, unit_x), old_x[n]);
    normal_y[at] = Either(is_new, Either(away, -unit_y, unit_y), old_y[n]);
    normal_z[at] = Either(is_new, Either(away, -unit_z, unit_z), old_z[n]);
  }
  std::copy(normal_x.begin(), normal_x.end(), old_x);
  std::copy(normal_y.begin(), normal_y.end(), old_y);
  std::copy(normal_z.begin(), normal_z.end(), old_z);
}

DEEPSLAM_WIDE_VECTORS void FindNormalsOfRow(const PointImage& points, int v, Row& row) {
  std::fill(row.x.begin(), row.x.end(), 0.0F);
  std::fill(row.y.begin(), row.y.end(), 0.0F);
  std::fill(row.z.begin(), row.z.end(), 0.0F);
  for (int u = 0; u < points.width(); u += kPixelLanes) {
    std::uint32_t radii = 0;  // bit r: some pixel's
    for (int n = 1; n <= kPixelLanes; ++n) {
      radii |= 1U << static_cast<std::uint32_t>(row.radius[static_cast<std::size_t>(u + n)]);
    }
    for (radii &= ~1U; radii != 0; radii &= radii - 1) {
      FindNormals(points, u, v, std::countr_zero(radii), row);
    }
  }
}

DEEPSLAM_WIDE_VECTORS void FindLevel(const std::array<float, 3>& up, int width, Row& row) {
  const float* const x = row.x.data() + 1;
  const float* const y = row.y.data() + 1;
  const float* const z = row.z.data() + 1;
  std::int32_t* const level = row.level.data() + 1;
  for (int u = 0; u < width; ++u) {
    level[u] = x[u] * up[0] + (y[u] * up[1] + z[u] * up[2]) > kHorizontalCos ? 1 : 0;
  }
}

// Adds what joins the pixels of a row to those that lie `before` them, in it or in the row above.
inline void Link(const float* z,
                 const Row& row,
                 const float* z_before,
                 const Row& before,
                 std::size_t offset,
                 int width,
                 std::int32_t from_bit,
                 std::int32_t to_bit,
                 std::int32_t* link) {
  const float* const ax = row.x.data() + 1;
  const float* const ay = row.y.data() + 1;
  const float* const az = row.z.data() + 1;
  const float* const step_a = row.step_m.data() + 1;
  const std::int32_t* const level_a = row.level.data() + 1;
  const float* const bx = before.x.data() + offset;
  const float* const by = before.y.data() + offset;
  const float* const bz = before.z.data() + offset;
  const float* const step_b = before.step_m.data() + offset;
  const std::int32_t* const level_b = before.level.data() + offset;
  for (int u = 0; u < width; ++u) {
    const float cosine = ax[u] * bx[u] + (ay[u] * by[u] + az[u] * bz[u]);
    const bool smooth = (cosine > kSameSurfaceCos) & (level_a[u] == level_b[u]);
    const float step = std::abs(z[u] - z_before[u]);
    const std::int32_t from = (smooth & (step < step_b[u])) ? from_bit : 0;
    const std::int32_t to = (smooth & (step < step_a[u])) ? to_bit : 0;
    link[u] |= from | to;
  }
}

DEEPSLAM_WIDE_VECTORS void LinkRow(
    const PointImage& points, int v, const Row& above, Row& row, std::uint8_t* bits) {
  const int width = points.width();
  std::int32_t* const link = row.link.data() + 1;
  for (int u = 0; u < width; ++u) {
    const float* const z = row.z.data() + 1;
    const bool is_zero = (row.x[static_cast<std::size_t>(u + 1)] == 0) &
                         (row.y[static_cast<std::size_t>(u + 1)] == 0) & (z[u] == 0);
    link[u] = is_zero ? 0 : kHasNormal;
  }
  const float* const z = points.z_row(v);
  Link(z, row, z - 1, row, 0, width, kFromLeft, kToLeft, link);
  Link(z, row, points.z_row(v - 1), above, 1, width, kFromAbove, kToAbove, link);
  for (int u = 0; u < width; ++u) bits[u] = static_cast<std::uint8_t>(link[u]);
}

}  // namespace

SmoothLinks FindSmoothLinks(const PointImage& points_camera,
                            double fx,
                            const std::optional<Plane>& ground_camera) {
  const int width = points_camera.width();
  SmoothLinks links;
  links.bits = Mask(width, points_camera.height());
  links.horizontal = Mask(width, points_camera.height());
  const Steps steps = {fx, SegmentOptions::kJump_m, SegmentOptions::kJump_per_m2};
  std::array<float, 3> up{};
  if (ground_camera) {
    for (int axis = 0; axis < 3; ++axis) {
      up[static_cast<std::size_t>(axis)] = static_cast<float>(ground_camera->normal[axis]);
    }
  }
  const auto survey = [&](int v, Row& row) {
    FindReach(points_camera.z_row(v), width, steps, row);
    FindNormalsOfRow(points_camera, v, row);
    FindLevel(up, width, row);
  };
  ParallelForChunks(static_cast<std::size_t>(points_camera.height()),
                    kRowsPerChunk,
                    [&](std::size_t begin, std::size_t end) {
                      Row above(width);
                      Row row(width);
                      const int first = static_cast<int>(begin);
                      if (first > 0) survey(first - 1, above);
                      for (int v = first; v < static_cast<int>(end); ++v) {
                        survey(v, row);
                        LinkRow(points_camera, v, above, row, links.bits.row(v));
                        std::copy_n(row.level.begin() + 1, width, links.horizontal.row(v));
                        std::swap(above, row);
                      }
                    });
  return links;
}

}  // namespace deepslam::segment

#include "deepslam/segment/image_pieces.h"

#include <algorithm>
#include <array>
#include <cmath>

#include <Eigen/Geometry>

#include "deepslam/core/parallel.h"

namespace deepslam::segment {
namespace {

constexpr std::size_t kRowsPerChunk = 16;
// Normals are taken over about this length on the surface: twice the depth noise of structured
// light at 3 m, so that a normal is good to about 20 degrees.
constexpr double kNormalBaseline_m = 0.04;
constexpr int kMaxBaseline_px = 12;
constexpr double kFarthest_m = 1000;      // only absurd intrinsics put points farther out
constexpr float kSameSurfaceCos = 0.87F;  // 30 degrees: steps of normals inside one surface
constexpr float kHorizontalCos = 0.82F;   // 35 degrees

using Points = Image<Eigen::Vector3f>;

Points UsablePoints(const DepthImage& depth_m,
                    const PinholeCamera& camera,
                    const std::optional<Plane>& ground_camera,
                    const SegmentOptions& options,
                    Image<float>& height_m,
                    Mask& beyond) {
  Points points(depth_m.width(), depth_m.height(), Eigen::Vector3f::Zero());
  ParallelForChunks(static_cast<std::size_t>(depth_m.height()),
                    kRowsPerChunk,
                    [&](std::size_t begin, std::size_t end) {
                      for (int v = static_cast<int>(begin); v < static_cast<int>(end); ++v) {
                        for (int u = 0; u < depth_m.width(); ++u) {
                          const double z = depth_m(u, v);
                          if (!(z > 0)) continue;
                          beyond(u, v) = 1;
                          if (z > options.max_depth_m) continue;
                          const Eigen::Vector3d p = camera.Unproject(u, v, z);
                          if (!(p.cwiseAbs().maxCoeff() < kFarthest_m)) continue;
                          if (ground_camera) {
                            const double height = ground_camera->SignedDistance(p);
                            height_m(u, v) = static_cast<float>(height);
                            if (height < options.min_height_m + options.height_per_m2 * z * z)
                              continue;
                          }
                          points(u, v) = p.cast<float>();
                          beyond(u, v) = 0;
                        }
                      }
                    });
  return points;
}

// Normal towards the camera from the cross of central differences; zero where the surface is not
// continuous.
Eigen::Vector3f NormalAt(
    const Points& points, int u, int v, double fx, const SegmentOptions& options) {
  const float z = points(u, v).z();
  if (!(z > 0)) return Eigen::Vector3f::Zero();
  const int r = static_cast<int>(
      std::lround(std::clamp(0.5 * kNormalBaseline_m * fx / z, 1.0, 1.0 * kMaxBaseline_px)));
  const auto jump = static_cast<float>(JumpAt(z, options) + 2.0 * r * z / fx);
  const auto difference = [&](int du, int dv) -> Eigen::Vector3f {
    const auto at = [&](int s) -> Eigen::Vector3f {
      if (!points.Contains(u + s * du, v + s * dv)) return Eigen::Vector3f::Zero();
      const Eigen::Vector3f& p = points(u + s * du, v + s * dv);
      return p.z() > 0 && std::abs(p.z() - z) < jump ? p : Eigen::Vector3f::Zero();
    };
    const Eigen::Vector3f a = at(r);
    const Eigen::Vector3f b = at(-r);
    if (a.z() > 0 && b.z() > 0) return a - b;
    if (a.z() > 0) return a - points(u, v);
    if (b.z() > 0) return points(u, v) - b;
    return Eigen::Vector3f::Zero();
  };
  Eigen::Vector3f normal = difference(1, 0).cross(difference(0, 1));
  const float length = normal.norm();
  if (!(length > 0)) return Eigen::Vector3f::Zero();
  normal /= length;
  return normal.dot(points(u, v)) > 0 ? Eigen::Vector3f(-normal) : normal;
}

Image<Eigen::Vector3f> Normals(const Points& points, double fx, const SegmentOptions& options) {
  Image<Eigen::Vector3f> normals(points.width(), points.height(), Eigen::Vector3f::Zero());
  ParallelForChunks(static_cast<std::size_t>(points.height()),
                    kRowsPerChunk,
                    [&](std::size_t begin, std::size_t end) {
                      for (int v = static_cast<int>(begin); v < static_cast<int>(end); ++v) {
                        for (int u = 0; u < points.width(); ++u) {
                          normals(u, v) = NormalAt(points, u, v, fx, options);
                        }
                      }
                    });
  return normals;
}

struct Pixel {
  int u, v;
};

constexpr std::array<Pixel, 4> kSteps = {{{1, 0}, {-1, 0}, {0, 1}, {0, -1}}};

// Grows smooth pieces over pixels with normals, in image order.
void GrowPieces(const Image<Eigen::Vector3f>& normals,
                const SegmentOptions& options,
                ImagePieces& pieces) {
  const Points& points = pieces.points_camera;
  std::vector<Pixel> open;
  for (int v = 0; v < points.height(); ++v) {
    for (int u = 0; u < points.width(); ++u) {
      if (pieces.piece(u, v) >= 0 || normals(u, v).isZero()) continue;
      const auto id = static_cast<std::int32_t>(pieces.num_pixels.size());
      pieces.num_pixels.push_back(0);
      pieces.piece(u, v) = id;
      open.assign(1, {u, v});
      while (!open.empty()) {
        const Pixel at = open.back();
        open.pop_back();
        ++pieces.num_pixels[static_cast<std::size_t>(id)];
        const float z = points(at.u, at.v).z();
        const double jump = JumpAt(z, options);
        const Eigen::Vector3f normal = normals(at.u, at.v);
        for (const Pixel& step : kSteps) {
          const Pixel to = {at.u + step.u, at.v + step.v};
          if (!points.Contains(to.u, to.v) || pieces.piece(to.u, to.v) >= 0) continue;
          if (normals(to.u, to.v).isZero()) continue;
          const bool near = std::abs(points(to.u, to.v).z() - z) < jump;
          const bool smooth = normal.dot(normals(to.u, to.v)) > kSameSurfaceCos &&
                              pieces.horizontal(at.u, at.v) == pieces.horizontal(to.u, to.v);
          if (!near || !smooth) continue;
          pieces.piece(to.u, to.v) = id;
          open.push_back(to);
        }
      }
    }
  }
}

// Gives pixels at edges, and those of crumbs, to the piece next to them in depth; what is left
// becomes pieces.
void AttachRest(const SegmentOptions& options, ImagePieces& pieces) {
  constexpr int kCrumb = 12;
  const Points& points = pieces.points_camera;
  std::vector<Pixel> open;
  for (int v = 0; v < points.height(); ++v) {
    for (int u = 0; u < points.width(); ++u) {
      std::int32_t& piece = pieces.piece(u, v);
      if (piece < 0) continue;
      if (pieces.num_pixels[static_cast<std::size_t>(piece)] < kCrumb) {
        piece = -1;
      } else {
        open.push_back({u, v});
      }
    }
  }
  for (int& count : pieces.num_pixels) count = count < kCrumb ? 0 : count;
  const auto grow = [&](std::size_t head) {
    for (; head < open.size(); ++head) {
      const Pixel at = open[head];
      const float z = points(at.u, at.v).z();
      const double jump = JumpAt(z, options);
      for (const Pixel& step : kSteps) {
        const Pixel to = {at.u + step.u, at.v + step.v};
        if (!points.Contains(to.u, to.v) || pieces.piece(to.u, to.v) >= 0) continue;
        const float z_to = points(to.u, to.v).z();
        if (!(z_to > 0) || std::abs(z_to - z) >= jump) continue;
        const std::int32_t id = pieces.piece(at.u, at.v);
        pieces.piece(to.u, to.v) = id;
        ++pieces.num_pixels[static_cast<std::size_t>(id)];
        open.push_back(to);
      }
    }
  };
  grow(0);
  for (int v = 0; v < points.height(); ++v) {
    for (int u = 0; u < points.width(); ++u) {
      if (pieces.piece(u, v) >= 0 || !(points(u, v).z() > 0)) continue;
      pieces.piece(u, v) = static_cast<std::int32_t>(pieces.num_pixels.size());
      pieces.num_pixels.push_back(1);
      open.assign(1, {u, v});
      grow(0);
      // Specks are mixed pixels between foreground and background.
      if (open.size() >= kCrumb) continue;
      for (const Pixel& pixel : open) pieces.points_camera(pixel.u, pixel.v).setZero();
    }
  }
  for (int v = 0; v < points.height(); ++v) {
    for (int u = 0; u < points.width(); ++u) {
      if (!(points(u, v).z() > 0)) pieces.piece(u, v) = -1;
    }
  }
}

}  // namespace

ImagePieces CutIntoPieces(const DepthImage& depth_m,
                          const PinholeCamera& camera,
                          const std::optional<Plane>& ground_camera,
                          const SegmentOptions& options) {
  ImagePieces pieces;
  const int width = depth_m.width();
  const int height = depth_m.height();
  pieces.has_ground = ground_camera.has_value();
  pieces.height_m = Image<float>(width, height, 0.0F);
  pieces.beyond = Mask(width, height);
  pieces.points_camera =
      UsablePoints(depth_m, camera, ground_camera, options, pieces.height_m, pieces.beyond);
  pieces.horizontal = Mask(width, height);
  pieces.piece = Image<std::int32_t>(width, height, -1);
  const Image<Eigen::Vector3f> normals = Normals(pieces.points_camera, camera.fx, options);
  if (ground_camera) {
    const Eigen::Vector3f up = ground_camera->normal.cast<float>();
    for (int v = 0; v < height; ++v) {
      for (int u = 0; u < width; ++u) {
        pieces.horizontal(u, v) = normals(u, v).dot(up) > kHorizontalCos ? 1 : 0;
      }
    }
  }
  GrowPieces(normals, options, pieces);
  AttachRest(options, pieces);
  return pieces;
}

}  // namespace deepslam::segment

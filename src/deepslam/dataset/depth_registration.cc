#include "deepslam/dataset/depth_registration.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <vector>

#include "deepslam/dataset/surface_depth.h"

namespace deepslam::dataset {
namespace {

constexpr int kMinFrameWidth = 640;    // px; detectors work at this size
constexpr double kLeastDepthM = 1e-3;  // divisions by less would throw points far off the image

// Where a target's column or row lies among those of the source.
struct Sample {
  int first = -1;    // the neighbour before; -1: outside
  double share = 0;  // of the neighbour after
  int nearest = 0;
};

std::vector<Sample> Samples(
    int num_target, double f, double c, int num_source, double fs, double cs) {
  std::vector<Sample> samples(static_cast<std::size_t>(num_target));
  for (int i = 0; i < num_target; ++i) {
    const double at = fs * (i - c) / f + cs;
    if (!(at >= -0.5 && at <= num_source - 0.5)) continue;
    const double inside = std::clamp(at, 0.0, num_source - 1.0);
    Sample& sample = samples[static_cast<std::size_t>(i)];
    sample.first = std::clamp(static_cast<int>(std::floor(inside)), 0, std::max(0, num_source - 2));
    sample.share = inside - sample.first;
    sample.nearest = std::clamp(static_cast<int>(std::lround(inside)), 0, num_source - 1);
  }
  return samples;
}

DepthImage Resample(const DepthImage& depth_m,
                    const PinholeCamera& source,
                    const PinholeCamera& target) {
  const std::vector<Sample> columns =
      Samples(target.width, target.fx, target.cx, source.width, source.fx, source.cx);
  const std::vector<Sample> rows =
      Samples(target.height, target.fy, target.cy, source.height, source.fy, source.cy);
  const float max_ratio = MaxDepthRatio(source);
  DepthImage out(target.width, target.height);
  for (int v = 0; v < target.height; ++v) {
    const Sample& row = rows[static_cast<std::size_t>(v)];
    if (row.first < 0) continue;
    const int next_row = std::min(row.first + 1, source.height - 1);
    for (int u = 0; u < target.width; ++u) {
      const Sample& column = columns[static_cast<std::size_t>(u)];
      if (column.first < 0) continue;
      const int next_column = std::min(column.first + 1, source.width - 1);
      const std::array<float, 4> z = {depth_m(column.first, row.first),
                                      depth_m(next_column, row.first),
                                      depth_m(column.first, next_row),
                                      depth_m(next_column, next_row)};
      if (!OneSurface(z, max_ratio)) {
        out(u, v) = depth_m(column.nearest, row.nearest);
        continue;
      }
      out(u, v) = BetweenOnPlane(z, column.share, row.share);
    }
  }
  return out;
}

// A depth pixel in the target camera. z <= 0: nothing there.
struct Vertex {
  double u = 0;
  double v = 0;
  double inverse_z = 0;
};

std::vector<Vertex> Transform(const DepthImage& depth_m,
                              const PinholeCamera& source,
                              const Pose3& target_from_source,
                              const PinholeCamera& target) {
  const Eigen::Matrix3d rotation = target_from_source.rotation.toRotationMatrix();
  std::vector<Vertex> vertices(depth_m.size());
  std::size_t i = 0;
  for (int v = 0; v < source.height; ++v) {
    for (int u = 0; u < source.width; ++u, ++i) {
      const double z = static_cast<double>(depth_m(u, v));
      if (z <= 0) continue;
      const Eigen::Vector3d p =
          rotation * source.Unproject(u, v, z) + target_from_source.translation_m;
      if (p.z() < kLeastDepthM) continue;
      const double inverse_z = 1.0 / p.z();
      vertices[i] = {target.fx * p.x() * inverse_z + target.cx,
                     target.fy * p.y() * inverse_z + target.cy,
                     inverse_z};
    }
  }
  return vertices;
}

// The image of inverse depths, 0 = nothing, into which surfaces are drawn; the nearest wins.
class DepthBuffer {
 public:
  explicit DepthBuffer(const PinholeCamera& camera)
      : inverse_z_(camera.width, camera.height, 0.0) {}

  void DrawTriangle(const Vertex& a, const Vertex& b, const Vertex& c) {
    const double area = (b.u - a.u) * (c.v - a.v) - (c.u - a.u) * (b.v - a.v);
    if (!(std::abs(area) > 1e-9)) return;
    const auto [low_u, high_u] = std::minmax({a.u, b.u, c.u});
    const auto [low_v, high_v] = std::minmax({a.v, b.v, c.v});
    const int first_u = std::max(0, static_cast<int>(std::ceil(std::max(low_u, -1.0))));
    const int first_v = std::max(0, static_cast<int>(std::ceil(std::max(low_v, -1.0))));
    const int last_u = static_cast<int>(std::floor(std::min(high_u, inverse_z_.width() - 1.0)));
    const int last_v = static_cast<int>(std::floor(std::min(high_v, inverse_z_.height() - 1.0)));
    // A hair outside counts as inside, so that no pixel on a shared edge falls between.
    constexpr double kEdge = -1e-9;
    for (int v = first_v; v <= last_v; ++v) {
      for (int u = first_u; u <= last_u; ++u) {
        const double of_b = ((u - a.u) * (c.v - a.v) - (c.u - a.u) * (v - a.v)) / area;
        const double of_c = ((b.u - a.u) * (v - a.v) - (u - a.u) * (b.v - a.v)) / area;
        const double of_a = 1 - of_b - of_c;
        if (of_a < kEdge || of_b < kEdge || of_c < kEdge) continue;
        Put(u, v, of_a * a.inverse_z + of_b * b.inverse_z + of_c * c.inverse_z);
      }
    }
  }

  void DrawPoint(const Vertex& p) {
    if (!(p.u > -0.5 && p.u < inverse_z_.width() - 0.5 && p.v > -0.5 &&
          p.v < inverse_z_.height() - 0.5)) {
      return;
    }
    Put(static_cast<int>(std::lround(p.u)), static_cast<int>(std::lround(p.v)), p.inverse_z);
  }

  [[nodiscard]] DepthImage Depth() const {
    DepthImage depth_m(inverse_z_.width(), inverse_z_.height());
    std::transform(inverse_z_.begin(), inverse_z_.end(), depth_m.begin(), [](double w) {
      return w > 0 ? static_cast<float>(1.0 / w) : 0.0f;
    });
    return depth_m;
  }

 private:
  void Put(int u, int v, double inverse_z) {
    double& kept = inverse_z_(u, v);
    kept = std::max(kept, inverse_z);
  }

  Image<double> inverse_z_;
};

DepthImage Warp(const DepthImage& depth_m,
                const PinholeCamera& source,
                const Pose3& target_from_source,
                const PinholeCamera& target) {
  const std::vector<Vertex> vertices = Transform(depth_m, source, target_from_source, target);
  const float max_ratio = MaxDepthRatio(source);
  DepthBuffer buffer(target);
  // Pixels that are part of no surface (thin things, noise) are drawn as points.
  Mask drawn(source.width, source.height);
  const auto at = [&](int u, int v) -> const Vertex& {
    return vertices[static_cast<std::size_t>(v) * static_cast<std::size_t>(source.width) +
                    static_cast<std::size_t>(u)];
  };
  for (int v = 0; v + 1 < source.height; ++v) {
    for (int u = 0; u + 1 < source.width; ++u) {
      if (!OneSurface({depth_m(u, v), depth_m(u + 1, v), depth_m(u, v + 1), depth_m(u + 1, v + 1)},
                      max_ratio)) {
        continue;
      }
      const Vertex& a = at(u, v);
      const Vertex& b = at(u + 1, v);
      const Vertex& c = at(u, v + 1);
      const Vertex& d = at(u + 1, v + 1);
      if (!(a.inverse_z > 0 && b.inverse_z > 0 && c.inverse_z > 0 && d.inverse_z > 0)) continue;
      buffer.DrawTriangle(a, b, c);
      buffer.DrawTriangle(b, d, c);
      drawn(u, v) = drawn(u + 1, v) = drawn(u, v + 1) = drawn(u + 1, v + 1) = 1;
    }
  }
  for (int v = 0; v < source.height; ++v) {
    for (int u = 0; u < source.width; ++u) {
      if (drawn(u, v) == 0 && at(u, v).inverse_z > 0) buffer.DrawPoint(at(u, v));
    }
  }
  return buffer.Depth();
}

}  // namespace

int ColourReduction(const CaptureCameras& cameras) {
  const PinholeCamera& colour = cameras.colour;
  const PinholeCamera& depth = cameras.depth;
  if (colour.width == depth.width && colour.height == depth.height) return 1;
  const int by_width = colour.width / std::max(depth.width, kMinFrameWidth);
  const int by_height = colour.height / std::max(1, depth.height);
  return std::max(1, std::min(by_width, by_height));
}

PinholeCamera FrameCamera(const CaptureCameras& cameras) {
  const int factor = ColourReduction(cameras);
  return factor == 1 ? cameras.colour : cameras.colour.Reduced(factor);
}

ColourImage ReduceColour(const ColourImage& colour, int factor) {
  ColourImage out(colour.width() / factor, colour.height() / factor);
  const int count = factor * factor;
  for (int v = 0; v < out.height(); ++v) {
    for (int u = 0; u < out.width(); ++u) {
      int r = count / 2;
      int g = count / 2;
      int b = count / 2;
      for (int y = v * factor; y < (v + 1) * factor; ++y) {
        const Rgb8* pixel = colour.row(y) + static_cast<std::ptrdiff_t>(u) * factor;
        for (int x = 0; x < factor; ++x) {
          r += pixel[x].r;
          g += pixel[x].g;
          b += pixel[x].b;
        }
      }
      out(u, v) = {static_cast<std::uint8_t>(r / count),
                   static_cast<std::uint8_t>(g / count),
                   static_cast<std::uint8_t>(b / count)};
    }
  }
  return out;
}

DepthImage RegisterDepth(const DepthImage& depth_m,
                         const PinholeCamera& depth_camera,
                         const Pose3& target_from_depth,
                         const PinholeCamera& target) {
  if (target_from_depth == Pose3())
    return depth_camera == target ? depth_m : Resample(depth_m, depth_camera, target);
  return Warp(depth_m, depth_camera, target_from_depth, target);
}

}  // namespace deepslam::dataset

#include "deepslam/synth/painted_part.h"

#include <algorithm>
#include <bit>
#include <cmath>
#include <numbers>

#include "deepslam/core/parallel.h"
#include "deepslam/synth/surface_pattern.h"

namespace deepslam::synth {
namespace {

// Surfaces of the room are painted as finely as a pixel sees them from here.
constexpr double kPaintedFromM = 1.5;
// Large rooms are painted more coarsely.
constexpr double kMaxTexels = 16e6;

Eigen::Vector3f Paint(const RoomPart& part,
                      const SceneDescription& scene,
                      const Eigen::Vector2d& p_m) {
  const std::uint64_t seed = scene.seed * 64 + static_cast<std::uint64_t>(part.number);
  switch (part.surface) {
    case RoomSurface::kFloor:
      return FloorColour(scene.floor, p_m, seed);
    case RoomSurface::kWall:
      return WallColour(scene.wall_colour, p_m, seed);
    case RoomSurface::kPoster:
      return PosterColour(part.number, p_m, part.extent_m, scene.seed);
    case RoomSurface::kCeiling:
      break;
  }
  return Eigen::Vector3f::Constant(0.75f);
}

Image<Eigen::Vector3f> Halved(const Image<Eigen::Vector3f>& from) {
  Image<Eigen::Vector3f> to(from.width() / 2, from.height() / 2, Eigen::Vector3f::Zero());
  for (int v = 0; v < to.height(); ++v) {
    for (int u = 0; u < to.width(); ++u) {
      to(u, v) = 0.25f * (from(2 * u, 2 * v) + from(2 * u + 1, 2 * v) + from(2 * u, 2 * v + 1) +
                          from(2 * u + 1, 2 * v + 1));
    }
  }
  return to;
}

}  // namespace

PaintedPart::PaintedPart(const RoomPart& part, const SceneDescription& scene) : part_(&part) {
  pixel_m_ =
      std::max(kPaintedFromM / scene.camera.fx, std::sqrt(part.extent_m.prod() / kMaxTexels));
  const Eigen::Vector2i size = (part.extent_m / pixel_m_).array().ceil().cast<int>().max(1);
  Image<Eigen::Vector3f> image(size.x(), size.y(), Eigen::Vector3f::Zero());
  ParallelFor(static_cast<std::size_t>(size.y()), [&](std::size_t row) {
    for (int u = 0; u < size.x(); ++u) {
      const Eigen::Vector2d p_m =
          pixel_m_ * Eigen::Vector2d(u + 0.5, static_cast<double>(row) + 0.5);
      image(u, static_cast<int>(row)) = Paint(part, scene, p_m);
    }
  });
  levels_.push_back(std::move(image));
  while (levels_.back().width() > 1 && levels_.back().height() > 1)
    levels_.push_back(Halved(levels_.back()));
}

Eigen::Vector3f PaintedPart::At(const Eigen::Vector3d& p_world, double footprint_m) const {
  const Eigen::Vector3d d = p_world - part_->origin;
  // The nearest power of two of the ratio.
  const double ratio = std::clamp(std::numbers::sqrt2 * footprint_m / pixel_m_, 1.0, 1e6);
  const std::size_t l = std::min(
      static_cast<std::size_t>(std::bit_width(static_cast<unsigned>(ratio))) - 1,
      levels_.size() - 1);
  const Image<Eigen::Vector3f>& image = levels_[l];
  const double pixel_m = pixel_m_ * static_cast<double>(std::size_t{1} << l);
  const double x = std::clamp(d.dot(part_->u_axis) / pixel_m - 0.5, 0.0, image.width() - 1.0);
  const double y = std::clamp(d.dot(part_->v_axis) / pixel_m - 0.5, 0.0, image.height() - 1.0);
  const int u = std::min(static_cast<int>(x), std::max(0, image.width() - 2));
  const int v = std::min(static_cast<int>(y), std::max(0, image.height() - 2));
  const int u1 = std::min(u + 1, image.width() - 1);
  const int v1 = std::min(v + 1, image.height() - 1);
  const auto s = static_cast<float>(x - u);
  const auto t = static_cast<float>(y - v);
  return (1 - t) * ((1 - s) * image(u, v) + s * image(u1, v)) +
         t * ((1 - s) * image(u, v1) + s * image(u1, v1));
}

}  // namespace deepslam::synth

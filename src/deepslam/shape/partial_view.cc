#include "deepslam/shape/partial_view.h"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <utility>

namespace deepslam::shape {
namespace {

constexpr auto kVoxel = static_cast<float>(kVoxelSize);

constexpr float kGrid = kGridSize;

// Whether solid lies between a place just above the surface and a camera far away.
bool Occluded(const SolidBits& solid, const Eigen::Vector3f& start, const ViewRay& ray) {
  constexpr float kBlind = 1.2F;  // voxels: the stairs of a slanted face do not hide one another
  // Voxel units, the grid's corner being 0.
  Eigen::Vector3f at =
      start / kVoxel + Eigen::Vector3f::Constant(0.5F * kGrid) + kBlind * ray.direction;
  const auto is_inside = [&] { return (at.array() >= 0).all() && (at.array() < kGrid).all(); };
  const auto is_solid = [&] {
    return solid.At(static_cast<int>(at.x()), static_cast<int>(at.y()), static_cast<int>(at.z()));
  };
  if (!is_inside()) return false;
  const int num_within = ray.StepsTo(ray.before_exit, at);
  for (int n = 0; n < num_within; ++n) {
    if (is_solid()) return true;
    at += ray.step;
  }
  const int num_to_beyond = ray.StepsTo(ray.behind_exit, at) + 2;
  for (int n = 0; n < num_to_beyond && is_inside(); ++n) {
    if (is_solid()) return true;
    at += ray.step;
  }
  return false;
}

// Whether the camera sees one of the free faces of the surface point's voxel. The voxel's own faces
// decide, not the normal, which is smoothed over a few voxels and leans at rims.
bool IsSeen(const SolidBits& solid,
            const Eigen::Vector3f& point,
            const Eigen::Vector3f& normal,
            const ViewRay& ray) {
  constexpr float kGrazing = 0.02F;  // cosine; about 1 degree
  // Starting in the free layer above the face keeps a flat face from hiding itself at grazing
  // angles.
  constexpr float kLift = 0.8F * kVoxel;
  const Eigen::Vector3f& direction = ray.direction;
  if (normal.dot(direction) < -kGrazing) return false;
  const Eigen::Vector3f center = point - 0.5F * kVoxel * normal;
  const Eigen::Array3i voxel = (center.array() / kVoxel + 0.5F * kGridSize).floor().cast<int>();
  for (int axis = 0; axis < 3; ++axis) {
    if (std::abs(direction[axis]) < kGrazing) continue;
    const int side = direction[axis] > 0 ? 1 : -1;
    Eigen::Array3i next = voxel;
    next[axis] += side;
    const bool inside = VoxelGrid::Contains(next.x(), next.y(), next.z());
    if (inside && solid.At(next.x(), next.y(), next.z())) continue;
    Eigen::Vector3f start = center;
    start[axis] += static_cast<float>(side) * kLift;
    if (!Occluded(solid, start, ray)) return true;
  }
  return false;
}

ViewRay RayTowards(const ShapeModel& model, const Eigen::Vector3f& direction) {
  constexpr float kStep = 0.5F;    // voxels
  constexpr float kSlack = 0.01F;  // voxels, far more than rounding adds up to
  constexpr float kAlmostZero = 1e-12F;  // stands for a step of 0: the exit is far but finite
  ViewRay ray;
  ray.direction = direction;
  ray.step = kStep * direction;
  for (int axis = 0; axis < 3; ++axis) {
    const bool is_back = ray.step[axis] < 0;
    const float exit = (is_back ? model.box_min() : model.box_max())[axis] / kVoxel + 0.5F * kGrid;
    const float slack = is_back ? -kSlack : kSlack;
    ray.before_exit[axis] = exit - slack;
    ray.behind_exit[axis] = exit + slack;
    ray.per_step[axis] = 1.0F / (ray.step[axis] == 0 ? kAlmostZero : ray.step[axis]);
  }
  return ray;
}

}  // namespace

PartialView::PartialView(const ShapeModel& model, double azimuth_rad, double elevation_rad)
    : PartialView(
          model, std::make_shared<const SolidBits>(model.grid()), azimuth_rad, elevation_rad) {}

PartialView::PartialView(const ShapeModel& model,
                         std::shared_ptr<const SolidBits> solid,
                         double azimuth_rad,
                         double elevation_rad)
    : model_(model),
      solid_(std::move(solid)),
      ray_(RayTowards(model,
                      Eigen::Vector3d(std::cos(elevation_rad) * std::cos(azimuth_rad),
                                      std::cos(elevation_rad) * std::sin(azimuth_rad),
                                      std::sin(elevation_rad))
                          .cast<float>())) {}

bool PartialView::Shows(std::size_t n) const {
  return IsSeen(*solid_, model_.surface_points()[n], model_.surface_normals()[n], ray_);
}

}  // namespace deepslam::shape

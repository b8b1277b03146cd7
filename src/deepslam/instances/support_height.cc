#include "deepslam/instances/support_height.h"

#include <algorithm>
#include <cstddef>

#include "deepslam/geometry/top_layer.h"

namespace deepslam::instances {
namespace {

constexpr float kFacesUp = 0.8F;     // z of a normal 37 degrees off the vertical
constexpr double kLayerM = 0.05;     // a top and the scatter of the surface's voxels about it
constexpr double kLeastTopM2 = 0.1;  // of surface: a bedside table

}  // namespace

std::vector<double> HeightsFacingUp(std::span<const int> own, const SurfaceElements& elements) {
  std::vector<double> heights_m;
  for (const int i : own) {
    const auto n = static_cast<std::size_t>(i);
    if (elements.normals()[n].z() >= kFacesUp) heights_m.push_back(elements.points()[n].z());
  }
  std::ranges::sort(heights_m);
  return heights_m;
}

std::optional<double> SupportHeight(std::span<const int> own, const SurfaceElements& elements) {
  const std::vector<double> heights_m = HeightsFacingUp(own, elements);
  const std::span<const double> top_m = TopLayer(heights_m, kLayerM);
  const double element_m2 = elements.voxel_m() * elements.voxel_m();
  if (static_cast<double>(top_m.size()) * element_m2 < kLeastTopM2) return std::nullopt;
  return top_m[top_m.size() / 2];
}

}  // namespace deepslam::instances

#include "deepslam/instances/surface_elements.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numeric>

#include "deepslam/core/check.h"
#include "deepslam/core/parallel.h"

namespace deepslam::instances {
namespace {

bool IsUsable(const Eigen::Vector3f& point, const Eigen::Vector3f& normal) {
  return point.allFinite() && normal.allFinite() && point.cwiseAbs().maxCoeff() < kMaxCoordinateM;
}

bool IsBefore(const Eigen::Vector3i& a, const Eigen::Vector3i& b) {
  return std::lexicographical_compare(a.data(), a.data() + 3, b.data(), b.data() + 3);
}

}  // namespace

std::size_t SurfaceElements::Hash::operator()(const Voxel& voxel) const {
  // Large primes of Teschner et al. 2003.
  return static_cast<std::size_t>(voxel.x()) * 73856093U ^
         static_cast<std::size_t>(voxel.y()) * 19349663U ^
         static_cast<std::size_t>(voxel.z()) * 83492791U;
}

SurfaceElements::Voxel SurfaceElements::VoxelOf(const Eigen::Vector3f& point) const {
  return (point.cast<double>() / voxel_m_).array().floor().cast<int>();
}

SurfaceElements::SurfaceElements(std::span<const Eigen::Vector3f> vertices,
                                 std::span<const Eigen::Vector3f> normals,
                                 double voxel_m)
    : voxel_m_(voxel_m), of_vertex_(vertices.size(), -1) {
  DEEPSLAM_CHECK(voxel_m > 0, "voxel size");
  DEEPSLAM_CHECK(vertices.size() == normals.size(), "one normal per vertex");
  std::vector<std::pair<Voxel, int>> order;
  for (std::size_t i = 0; i < vertices.size(); ++i) {
    if (IsUsable(vertices[i], normals[i]))
      order.emplace_back(VoxelOf(vertices[i]), static_cast<int>(i));
  }
  std::ranges::stable_sort(order, IsBefore, &std::pair<Voxel, int>::first);
  for (std::size_t begin = 0, end = 0; begin < order.size(); begin = end) {
    Eigen::Vector3f point = Eigen::Vector3f::Zero();
    Eigen::Vector3f normal = Eigen::Vector3f::Zero();
    for (end = begin; end < order.size() && order[end].first == order[begin].first; ++end) {
      point += vertices[static_cast<std::size_t>(order[end].second)];
      normal += normals[static_cast<std::size_t>(order[end].second)];
    }
    if (normal.norm() < std::numeric_limits<float>::epsilon()) continue;
    for (std::size_t i = begin; i < end; ++i)
      of_vertex_[static_cast<std::size_t>(order[i].second)] = static_cast<int>(points_.size());
    element_at_.emplace(order[begin].first, static_cast<int>(points_.size()));
    voxels_.push_back(order[begin].first);
    points_.emplace_back(point / static_cast<float>(end - begin));
    normals_.push_back(normal.normalized());
  }
}

std::vector<ElementPair> SurfaceElements::PairsWithin(double reach_m) const {
  DEEPSLAM_CHECK(reach_m <= 2 * voxel_m_, "reach beyond the neighbours looked at");
  const auto reach_squared_m2 = static_cast<float>(reach_m * reach_m);
  std::vector<std::vector<ElementPair>> pairs(size());
  ParallelFor(size(), [&](std::size_t i) {
    for (int x = -2; x <= 2; ++x) {
      for (int y = -2; y <= 2; ++y) {
        for (int z = -2; z <= 2; ++z) {
          const auto found = element_at_.find(voxels_[i] + Voxel(x, y, z));
          if (found == element_at_.end() || found->second <= static_cast<int>(i)) continue;
          const Eigen::Vector3f& other = points_[static_cast<std::size_t>(found->second)];
          if ((other - points_[i]).squaredNorm() <= reach_squared_m2)
            pairs[i].emplace_back(static_cast<int>(i), found->second);
        }
      }
    }
  });
  std::vector<ElementPair> all;
  for (std::vector<ElementPair>& own : pairs) {
    std::ranges::sort(own);
    all.insert(all.end(), own.begin(), own.end());
  }
  return all;
}

}  // namespace deepslam::instances

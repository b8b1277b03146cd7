#include "deepslam/eval/nearest_points.h"

#include <cmath>
#include <limits>

#include <nanoflann.hpp>

#include "deepslam/core/parallel.h"

namespace deepslam::eval {
namespace {

constexpr std::size_t kLeafSize = 12;  // points: nanoflann's advice is 10 to 50
// Points a thread takes at a time; the result does not depend on it.
constexpr std::size_t kPointsPerChunk = 1024;

struct PointList {
  std::span<const Eigen::Vector3d> points;

  [[nodiscard]] std::size_t kdtree_get_point_count() const { return points.size(); }
  [[nodiscard]] double kdtree_get_pt(std::size_t i, std::size_t axis) const {
    return points[i][static_cast<Eigen::Index>(axis)];
  }
  template <typename Box>
  bool kdtree_get_bbox(Box& /*box*/) const {
    return false;
  }
};

using Tree = nanoflann::
    KDTreeSingleIndexAdaptor<nanoflann::L2_Simple_Adaptor<double, PointList>, PointList, 3>;

}  // namespace

std::vector<double> NearestDistances(std::span<const Eigen::Vector3d> from,
                                     std::span<const Eigen::Vector3d> to) {
  std::vector<double> distances(from.size(), std::numeric_limits<double>::infinity());
  if (to.empty()) return distances;
  const PointList list{to};
  Tree tree(3, list, kLeafSize);
  tree.buildIndex();
  ParallelForChunks(from.size(), kPointsPerChunk, [&](std::size_t begin, std::size_t end) {
    for (std::size_t i = begin; i < end; ++i) {
      std::size_t index = 0;
      double squared = 0;
      nanoflann::KNNResultSet<double> nearest(1);
      nearest.init(&index, &squared);
      tree.findNeighbors(nearest, from[i].data(), nanoflann::SearchParams());
      distances[i] = std::sqrt(squared);
    }
  });
  return distances;
}

}  // namespace deepslam::eval

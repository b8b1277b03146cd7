#include "deepslam/loop/point_agreement.h"

#include <array>
#include <cmath>
#include <cstdint>
#include <limits>
#include <set>

#include <nanoflann.hpp>

#include "deepslam/core/order_statistics.h"

namespace deepslam::loop {
namespace {

constexpr double kFeet_m = 0.1;  // above an object's lowest points
// Beyond, cell numbers would overflow; no room is that large.
constexpr float kFarthestPoint_m = 1e5F;

struct Cloud {
  const std::vector<Eigen::Vector3f>* points;

  [[nodiscard]] std::size_t kdtree_get_point_count() const { return points->size(); }
  [[nodiscard]] float kdtree_get_pt(std::size_t k, std::size_t axis) const {
    return (*points)[k][static_cast<Eigen::Index>(axis)];
  }
  template <typename Box>
  bool kdtree_get_bbox(Box&) const {
    return false;
  }
};

using KdTree =
    nanoflann::KDTreeSingleIndexAdaptor<nanoflann::L2_Simple_Adaptor<float, Cloud>, Cloud, 3>;

}  // namespace

struct PointIndex::Tree {
  explicit Tree(const std::vector<Eigen::Vector3f>& points)
      : cloud{&points}, index(3, cloud, nanoflann::KDTreeSingleIndexAdaptorParams(16)) {
    index.buildIndex();
  }
  Cloud cloud;
  KdTree index;
};

PointIndex::PointIndex(std::vector<Eigen::Vector3f> points) : points_(std::move(points)) {
  if (!points_.empty()) tree_ = std::make_unique<Tree>(points_);
}
PointIndex::~PointIndex() = default;

PointIndex::PointIndex(PointIndex&& other) noexcept : PointIndex(std::move(other.points_)) {
  other.tree_.reset();
}
PointIndex& PointIndex::operator=(PointIndex&& other) noexcept {
  points_ = std::move(other.points_);
  other.tree_.reset();
  tree_ = points_.empty() ? nullptr : std::make_unique<Tree>(points_);
  return *this;
}

const Eigen::Vector3f* PointIndex::Nearest(const Eigen::Vector3f& p, double radius_m) const {
  if (tree_ == nullptr || !p.allFinite()) return nullptr;
  std::size_t index = 0;
  float squared = 0;
  nanoflann::KNNResultSet<float> result(1);
  result.init(&index, &squared);
  tree_->index.findNeighbors(result, p.data(), nanoflann::SearchParams());
  return squared <= static_cast<float>(radius_m * radius_m) ? &points_[index] : nullptr;
}

std::vector<Eigen::Vector3f> Thinned(std::span<const Eigen::Vector3f> points, double cell_m) {
  std::set<std::array<std::int32_t, 3>> taken;
  std::vector<Eigen::Vector3f> thinned;
  for (const Eigen::Vector3f& p : points) {
    if (!p.allFinite() || p.cwiseAbs().maxCoeff() > kFarthestPoint_m) continue;
    std::array<std::int32_t, 3> cell{};
    for (std::size_t k = 0; k < 3; ++k) {
      const double value = p[static_cast<Eigen::Index>(k)];
      cell[k] = static_cast<std::int32_t>(std::floor(value / cell_m));
    }
    if (taken.insert(cell).second) thinned.push_back(p);
  }
  return thinned;
}

double GroundTop_m(std::span<const Eigen::Vector3f> object_world, const Eigen::Vector3d& up_world) {
  std::vector<double> heights_m;
  for (const Eigen::Vector3f& p : object_world) {
    if (p.allFinite()) heights_m.push_back(up_world.dot(p.cast<double>()));
  }
  if (heights_m.empty()) return -std::numeric_limits<double>::infinity();
  return OrderStatistic(heights_m, heights_m.size() / 50) + kFeet_m;
}

double AgreeingShare(std::span<const Eigen::Vector3f> points_a,
                     const Pose3& b_from_a,
                     const PointIndex& points_b,
                     double radius_m) {
  if (points_a.empty()) return 0;
  std::size_t agreeing = 0;
  for (const Eigen::Vector3f& p : points_a) {
    const Eigen::Vector3f moved = (b_from_a * p.cast<double>()).cast<float>();
    if (points_b.Nearest(moved, radius_m) != nullptr) ++agreeing;
  }
  return static_cast<double>(agreeing) / static_cast<double>(points_a.size());
}

}  // namespace deepslam::loop

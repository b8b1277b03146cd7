#include "deepslam/associate/point_cloud.h"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <limits>
#include <set>
#include <utility>
#include <vector>

#include <Eigen/Geometry>
#include <nanoflann.hpp>

#include "deepslam/frames/set_pixels.h"

namespace deepslam::associate {
namespace {

constexpr std::size_t kLeafSize = 12;  // points: nanoflann's advice is 10 to 50
constexpr float kLargest = std::numeric_limits<float>::max();

struct PointList {
  std::vector<Eigen::Vector3f> points;

  [[nodiscard]] std::size_t kdtree_get_point_count() const { return points.size(); }
  [[nodiscard]] float kdtree_get_pt(std::size_t i, std::size_t axis) const {
    return points[i][static_cast<Eigen::Index>(axis)];
  }
  template <typename Box>
  bool kdtree_get_bbox(Box& /*box*/) const {
    return false;
  }
};

using Tree = nanoflann::
    KDTreeSingleIndexAdaptor<nanoflann::L2_Simple_Adaptor<float, PointList>, PointList, 3>;

}  // namespace

struct PointCloud::Impl {
  explicit Impl(std::vector<Eigen::Vector3f> from)
      : list{std::move(from)}, tree(3, list, kLeafSize) {
    tree.buildIndex();
    for (const Eigen::Vector3f& p : list.points) box.extend(p);
  }
  PointList list;
  Tree tree;
  Eigen::AlignedBox3f box;
};

PointCloud::PointCloud(std::vector<Eigen::Vector3f> points)
    : impl_(points.empty() ? nullptr : std::make_unique<Impl>(std::move(points))) {}
PointCloud::~PointCloud() = default;
PointCloud::PointCloud(PointCloud&&) noexcept = default;
PointCloud& PointCloud::operator=(PointCloud&&) noexcept = default;

const std::vector<Eigen::Vector3f>& PointCloud::points() const {
  static const std::vector<Eigen::Vector3f> kNone;
  return impl_ ? impl_->list.points : kNone;
}

double PointCloud::Distance(const Eigen::Vector3f& p, double max_m) const {
  constexpr double kInfinite = std::numeric_limits<double>::infinity();
  if (!impl_) return kInfinite;
  // A little more than asked for, so that rounding leaves out nothing within.
  const auto max_squared =
      static_cast<float>(std::min(1.001 * max_m * max_m, static_cast<double>(kLargest)));
  if (impl_->box.squaredExteriorDistance(p) > max_squared) return kInfinite;
  std::size_t index = 0;
  float squared = 0;
  nanoflann::KNNResultSet<float> nearest(1);
  nearest.init(&index, &squared);
  squared = max_squared;  // nearer ones alone are looked for
  impl_->tree.findNeighbors(nearest, p.data(), nanoflann::SearchParams());
  if (nearest.size() == 0) return kInfinite;
  return std::sqrt(static_cast<double>(squared));
}

double MeanDistance(const std::vector<Eigen::Vector3f>& from,
                    const PointCloud& to,
                    double truncation_m,
                    const std::vector<bool>& counted) {
  double sum = 0;
  std::size_t count = 0;
  for (std::size_t i = 0; i < from.size(); ++i) {
    if (!counted.empty() && !counted[i]) continue;
    sum += std::min(truncation_m, to.Distance(from[i], truncation_m));
    ++count;
  }
  return count > 0 ? sum / static_cast<double>(count) : truncation_m;
}

double ShareNear(const PointCloud& from, const PointCloud& to, double reach_m) {
  if (from.points().empty()) return 0.0;
  const auto near =
      std::count_if(from.points().begin(), from.points().end(), [&](const Eigen::Vector3f& p) {
        return to.Distance(p, reach_m) <= reach_m;
      });
  return static_cast<double>(near) / static_cast<double>(from.points().size());
}

std::vector<Eigen::Vector3f> MaskPoints(const Mask& mask,
                                        const DepthImage& depth_m,
                                        const PinholeCamera& camera,
                                        const Pose3& world_from_camera,
                                        int max_points) {
  struct Pixel {
    int u, v;
  };
  std::vector<Pixel> measured;
  for (int v = 0; v < mask.height(); ++v) {
    const std::uint8_t* const row = mask.row(v);
    const std::uint8_t* const end = row + mask.width();
    const float* const depth_row_m = depth_m.row(v);
    for (const std::uint8_t* pixel = FirstSet(row, end); pixel < end;
         pixel = FirstSet(pixel + 1, end)) {
      const auto u = static_cast<int>(pixel - row);
      if (depth_row_m[u] > 0) measured.push_back({u, v});
    }
  }
  const std::size_t step =
      std::max<std::size_t>(1, measured.size() / static_cast<std::size_t>(max_points));
  std::vector<Eigen::Vector3f> points;
  points.reserve((measured.size() + step - 1) / step);
  for (std::size_t n = 0; n < measured.size(); n += step) {
    const auto [u, v] = measured[n];
    const Eigen::Vector3d p = world_from_camera * camera.Unproject(u, v, depth_m(u, v));
    if (p.allFinite()) points.emplace_back(p.cast<float>());
  }
  return points;
}

void GrowingCloud::Add(std::span<const Eigen::Vector3f> points, double cell_m) {
  const auto num_known = static_cast<std::ptrdiff_t>(cells_.size());
  std::set<Cell> added;
  for (const Eigen::Vector3f& p : points) {
    const Cell cell = {
        std::lround(p.x() / cell_m), std::lround(p.y() / cell_m), std::lround(p.z() / cell_m)};
    if (std::binary_search(cells_.begin(), cells_.begin() + num_known, cell)) continue;
    if (added.insert(cell).second) points_.push_back(p);
  }
  cells_.insert(cells_.end(), added.begin(), added.end());
  std::inplace_merge(cells_.begin(), cells_.begin() + num_known, cells_.end());
}

const PointCloud& GrowingCloud::cloud() const {
  if (cloud_.points().size() != points_.size()) cloud_ = PointCloud(points_);
  return cloud_;
}

}  // namespace deepslam::associate

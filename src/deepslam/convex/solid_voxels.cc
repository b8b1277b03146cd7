#include "deepslam/convex/solid_voxels.h"

#include <algorithm>
#include <cmath>
#include <cstddef>

namespace deepslam::convex {
namespace {

// Lines run beside the middles of cells by shares that no coordinate is likely to have: through an
// edge a line would be counted twice or not at all.
constexpr double kRayAside = 0.00137;

struct Crossing {
  double z = 0;
  bool enters = false;
};

class Columns {
 public:
  Columns(const TriangleMesh& mesh, int num_cells) {
    Eigen::Vector3d low = Eigen::Vector3d::Constant(INFINITY);
    Eigen::Vector3d high = -low;
    for (const Eigen::Vector3f& p : mesh.vertices) {
      low = low.cwiseMin(p.cast<double>());
      high = high.cwiseMax(p.cast<double>());
    }
    origin_ = low;
    cell_m_ = (high - low).maxCoeff() / num_cells;
    if (!(cell_m_ > 0)) return;
    size_ = ((high - low) / cell_m_).array().ceil().cast<int>().max(1);
    crossings_.resize(static_cast<std::size_t>(size_.x()) * static_cast<std::size_t>(size_.y()));
    for (const auto& face : mesh.faces) {
      Add(mesh.vertices[face[0]].cast<double>(),
          mesh.vertices[face[1]].cast<double>(),
          mesh.vertices[face[2]].cast<double>());
    }
  }

  [[nodiscard]] SolidVoxels Fill() {
    SolidVoxels voxels;
    voxels.cell_m = static_cast<float>(cell_m_);
    for (int i = 0; i < size_.x(); ++i) {
      for (int j = 0; j < size_.y(); ++j) FillColumn(i, j, voxels);
    }
    return voxels;
  }

 private:
  [[nodiscard]] double Middle(int axis, int n) const {
    return origin_[axis] + (n + 0.5 + kRayAside * (axis + 1)) * cell_m_;
  }

  void Add(const Eigen::Vector3d& a, const Eigen::Vector3d& b, const Eigen::Vector3d& c) {
    const auto cross = [](const Eigen::Vector3d& p, const Eigen::Vector3d& q, double x, double y) {
      return (p.x() - x) * (q.y() - y) - (p.y() - y) * (q.x() - x);
    };
    const double twice_area = cross(b, c, a.x(), a.y());
    if (twice_area == 0) return;
    const Eigen::Vector3d low = a.cwiseMin(b).cwiseMin(c);
    const Eigen::Vector3d high = a.cwiseMax(b).cwiseMax(c);
    const auto first = [&](int axis) {
      return std::max(0, static_cast<int>((low[axis] - origin_[axis]) / cell_m_ - 1));
    };
    const auto last = [&](int axis) {
      return std::min(size_[axis] - 1, static_cast<int>((high[axis] - origin_[axis]) / cell_m_));
    };
    for (int i = first(0); i <= last(0); ++i) {
      for (int j = first(1); j <= last(1); ++j) {
        const double x = Middle(0, i);
        const double y = Middle(1, j);
        const double u = cross(b, c, x, y) / twice_area;
        const double v = cross(c, a, x, y) / twice_area;
        const double w = 1 - u - v;
        if (u < 0 || v < 0 || w < 0) continue;
        crossings_[static_cast<std::size_t>(i) * static_cast<std::size_t>(size_.y()) +
                   static_cast<std::size_t>(j)]
            .push_back({u * a.z() + v * b.z() + w * c.z(), twice_area < 0});
      }
    }
  }

  void FillColumn(int i, int j, SolidVoxels& voxels) {
    std::vector<Crossing>& column =
        crossings_[static_cast<std::size_t>(i) * static_cast<std::size_t>(size_.y()) +
                   static_cast<std::size_t>(j)];
    std::sort(column.begin(), column.end(), [](const Crossing& a, const Crossing& b) {
      return a.z < b.z;
    });
    std::size_t next = 0;
    int depth = 0;
    for (int k = 0; k < size_.z(); ++k) {
      const double z = origin_.z() + (k + 0.5) * cell_m_;
      for (; next < column.size() && column[next].z < z; ++next)
        depth += column[next].enters ? 1 : -1;
      if (depth <= 0) continue;
      voxels.centres.emplace_back(static_cast<float>(origin_.x() + (i + 0.5) * cell_m_),
                                  static_cast<float>(origin_.y() + (j + 0.5) * cell_m_),
                                  static_cast<float>(z));
    }
  }

  Eigen::Vector3d origin_ = Eigen::Vector3d::Zero();
  double cell_m_ = 0;
  Eigen::Array3i size_ = Eigen::Array3i::Zero();
  std::vector<std::vector<Crossing>> crossings_;
};

}  // namespace

SolidVoxels SolidVoxelsOf(const TriangleMesh& closed, int num_cells) {
  if (closed.empty()) return {};
  return Columns(closed, num_cells).Fill();
}

}  // namespace deepslam::convex

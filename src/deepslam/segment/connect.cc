#include "deepslam/segment/connect.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <map>

namespace deepslam::segment {
namespace {

using Cell = std::array<int, 3>;

Cell CellOf(const Eigen::Vector3f& p, double size_m) {
  Cell cell{};
  for (int axis = 0; axis < 3; ++axis) {
    cell[static_cast<std::size_t>(axis)] = static_cast<int>(std::floor(p[axis] / size_m));
  }
  return cell;
}

}  // namespace

int Groups::Heaviest(const std::function<double(std::size_t)>& weight) const {
  std::vector<double> sums(static_cast<std::size_t>(count), 0.0);
  for (std::size_t i = 0; i < of_point.size(); ++i) {
    sums[static_cast<std::size_t>(of_point[i])] += weight(i);
  }
  if (sums.empty()) return -1;
  return static_cast<int>(std::max_element(sums.begin(), sums.end()) - sums.begin());
}

Groups ConnectPoints(std::span<const PixelPoint> points, double gap_m) {
  const double size_m = 0.7 * gap_m;
  std::map<Cell, int> group_of_cell;
  std::vector<Cell> cells;
  for (const PixelPoint& point : points) {
    cells.push_back(CellOf(point.p_camera, size_m));
    group_of_cell.emplace(cells.back(), -1);
  }
  Groups groups;
  std::vector<Cell> open;
  for (const Cell& seed : cells) {
    int& seed_group = group_of_cell.at(seed);
    if (seed_group < 0) {
      seed_group = groups.count++;
      open.assign(1, seed);
    }
    const int group = seed_group;
    while (!open.empty()) {
      const Cell cell = open.back();
      open.pop_back();
      for (int neighbour = 0; neighbour < 27; ++neighbour) {
        const Cell next = {cell[0] + neighbour / 9 - 1,
                           cell[1] + neighbour / 3 % 3 - 1,
                           cell[2] + neighbour % 3 - 1};
        const auto found = group_of_cell.find(next);
        if (found == group_of_cell.end() || found->second >= 0) continue;
        found->second = group;
        open.push_back(next);
      }
    }
    groups.of_point.push_back(group);
  }
  return groups;
}

}  // namespace deepslam::segment

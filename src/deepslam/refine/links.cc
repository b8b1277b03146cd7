#include "deepslam/refine/links.h"

#include <algorithm>
#include <cstddef>
#include <functional>
#include <limits>
#include <queue>
#include <utility>
#include <vector>

#include "deepslam/core/check.h"
#include "deepslam/shape/small_components.h"

namespace deepslam::refine {
namespace {

constexpr int kUnreached = std::numeric_limits<int>::max();
constexpr std::size_t kNowhere = std::numeric_limits<std::size_t>::max();
constexpr int kNoPart = -1;  // of free voxels

Eigen::Array3i PlaceOf(std::size_t n) {
  const int at = static_cast<int>(n);
  return {at / (kGridSize * kGridSize), at / kGridSize % kGridSize, at % kGridSize};
}

// Calls visit(neighbour) for the voxels that share a face with voxel n.
template <typename Visitor>
void ForFaceNeighbours(std::size_t n, const Visitor& visit) {
  const Eigen::Array3i at = PlaceOf(n);
  for (int axis = 0; axis < 3; ++axis) {
    for (const int step : {-1, 1}) {
      Eigen::Array3i next = at;
      next[axis] += step;
      if (VoxelGrid::Contains(next.x(), next.y(), next.z()))
        visit(VoxelGrid::Index(next.x(), next.y(), next.z()));
    }
  }
}

// Dijkstra from the largest part; a part that is reached becomes a source itself.
class Linking {
 public:
  Linking(const VoxelGrid& grid, LinkCosts costs, int most)
      : costs_(costs),
        most_(most),
        parts_(shape::PartsOf(grid, 1)),
        part_of_(grid.occupied.size(), kNoPart),
        cost_(grid.occupied.size(), kUnreached),
        from_(grid.occupied.size(), kNowhere) {
    for (std::size_t p = 0; p < parts_.size(); ++p) {
      for (const std::size_t n : parts_[p]) part_of_[n] = static_cast<int>(p);
    }
  }

  // The voxels of all links.
  std::vector<std::size_t> Find() {
    if (parts_.size() < 2) return {};
    const auto largest =
        std::max_element(parts_.begin(), parts_.end(), [](const auto& a, const auto& b) {
          return a.size() < b.size();
        });
    Start(*largest);
    std::vector<std::size_t> links;
    while (!reached_.empty()) {
      const int cost = reached_.top().first;
      const std::size_t n = reached_.top().second;
      reached_.pop();
      if (cost > cost_[n]) continue;
      if (part_of_[n] != kNoPart && cost > 0) {
        for (std::size_t back = from_[n]; part_of_[back] == kNoPart; back = from_[back])
          links.push_back(back);
        Start(parts_[static_cast<std::size_t>(part_of_[n])]);
        continue;
      }
      ForFaceNeighbours(n, [&](std::size_t next) { Reach(next, n, cost); });
    }
    return links;
  }

 private:
  void Start(const std::vector<std::size_t>& part) {
    for (const std::size_t n : part) {
      cost_[n] = 0;
      reached_.emplace(0, n);
    }
  }

  void Reach(std::size_t next, std::size_t from, int cost) {
    const bool is_part = part_of_[next] != kNoPart;
    if (!is_part && costs_[next] == 0) return;
    // A step into another part is the last one of a link and must not look like a source's.
    const int there = cost + (is_part ? 1 : costs_[next]);
    if (there > most_ || there >= cost_[next]) return;
    cost_[next] = there;
    from_[next] = from;
    reached_.emplace(there, next);
  }

  using Entry = std::pair<int, std::size_t>;
  LinkCosts costs_;
  int most_;
  std::vector<std::vector<std::size_t>> parts_;
  std::vector<int> part_of_;
  std::vector<int> cost_;
  std::vector<std::size_t> from_;
  std::priority_queue<Entry, std::vector<Entry>, std::greater<>> reached_;
};

}  // namespace

VoxelGrid WithLinks(const VoxelGrid& grid, const VoxelGrid& model, LinkCosts costs, int most) {
  DEEPSLAM_CHECK(costs.size() == grid.occupied.size(), "one cost per voxel");
  VoxelGrid linked = grid;
  for (const std::size_t n : Linking(grid, costs, most).Find()) {
    linked.occupied[n] = 1;
    const Eigen::Array3i at = PlaceOf(n);
    for (int i = -1; i <= 1; ++i) {
      for (int j = -1; j <= 1; ++j) {
        for (int k = -1; k <= 1; ++k) {
          const Eigen::Array3i around = at + Eigen::Array3i(i, j, k);
          if (!VoxelGrid::Contains(around.x(), around.y(), around.z())) continue;
          const std::size_t there = VoxelGrid::Index(around.x(), around.y(), around.z());
          if (model.occupied[there] != 0) linked.occupied[there] = 1;
        }
      }
    }
  }
  return linked;
}

}  // namespace deepslam::refine

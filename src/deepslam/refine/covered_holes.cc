#include "deepslam/refine/covered_holes.h"

#include <algorithm>
#include <array>
#include <cstdint>
#include <optional>
#include <vector>

namespace deepslam::refine {
namespace {

constexpr double kWideShare = 0.5;  // of the grid's outline from above: tops, seats, boards
// Of a layer's solid voxels: what lies inside a frame of rails is larger, and hollow.
constexpr double kHoleShare = 0.1;

// The voxels of a layer of the grid; index i * kGridSize + j.
class Layer {
 public:
  Layer(const VoxelGrid& grid, int k) : k_(k), is_done_(kCells) {
    for (int i = 0; i < kGridSize; ++i) {
      for (int j = 0; j < kGridSize; ++j) is_done_[Cell(i, j)] = grid.At(i, j, k) ? 1 : 0;
    }
    num_solid_ = static_cast<std::size_t>(std::count(is_done_.begin(), is_done_.end(), 1));
  }

  [[nodiscard]] std::size_t num_solid() const { return num_solid_; }

  // Connected parts that are not solid and do not reach the border; indices of VoxelGrid.
  [[nodiscard]] std::vector<std::vector<std::size_t>> Holes() {
    std::vector<std::vector<std::size_t>> holes;
    for (int i = 0; i < kGridSize; ++i) {
      for (int j = 0; j < kGridSize; ++j) {
        if (is_done_[Cell(i, j)] != 0) continue;
        std::vector<std::size_t> part;
        if (!Grow(i, j, part)) holes.push_back(std::move(part));
      }
    }
    return holes;
  }

 private:
  static constexpr std::size_t kCells = std::size_t{kGridSize} * kGridSize;

  static std::size_t Cell(int i, int j) {
    return static_cast<std::size_t>(i) * kGridSize + static_cast<std::size_t>(j);
  }

  // The part that holds (i, j); true where it reaches the border.
  bool Grow(int i, int j, std::vector<std::size_t>& part) {
    bool is_open = false;
    std::vector<std::array<int, 2>> waiting = {{i, j}};
    is_done_[Cell(i, j)] = 1;
    while (!waiting.empty()) {
      const auto [x, y] = waiting.back();
      waiting.pop_back();
      part.push_back(VoxelGrid::Index(x, y, k_));
      is_open |= x == 0 || y == 0 || x == kGridSize - 1 || y == kGridSize - 1;
      for (const auto& [dx, dy] : {std::array{1, 0}, {-1, 0}, {0, 1}, {0, -1}}) {
        if (!VoxelGrid::Contains(x + dx, y + dy, k_) || is_done_[Cell(x + dx, y + dy)] != 0)
          continue;
        is_done_[Cell(x + dx, y + dy)] = 1;
        waiting.push_back({x + dx, y + dy});
      }
    }
    return is_open;
  }

  int k_;
  std::vector<std::uint8_t> is_done_;
  std::size_t num_solid_ = 0;
};

}  // namespace

void FillCoveredHoles(const std::function<bool(std::size_t)>& is_free, VoxelGrid& grid) {
  const std::optional<VoxelBox> box = OccupiedBox(grid);
  if (!box) return;
  const Eigen::Array3d sides = box->sides().cast<double>();
  for (int k = box->low.z(); k <= box->high.z(); ++k) {
    Layer layer(grid, k);
    const auto num_solid = static_cast<double>(layer.num_solid());
    if (num_solid < kWideShare * sides.x() * sides.y()) continue;
    for (const std::vector<std::size_t>& hole : layer.Holes()) {
      if (static_cast<double>(hole.size()) > kHoleShare * num_solid ||
          std::any_of(hole.begin(), hole.end(), is_free))
        continue;
      for (const std::size_t n : hole) grid.occupied[n] = 1;
    }
  }
}

}  // namespace deepslam::refine

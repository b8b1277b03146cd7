#include "deepslam/segment/connect.h"

#include <cstdint>

namespace deepslam::segment {
namespace {

constexpr int kAxisBits = 21;  // three axes in 64 bits
// Keeps the coordinates of cells positive.
constexpr std::int64_t kCellOffset = std::int64_t{1} << (kAxisBits - 1);

std::int64_t Floor(double x) {
  const auto towards_zero = static_cast<std::int64_t>(x);
  return towards_zero - (static_cast<double>(towards_zero) > x ? 1 : 0);
}

// Three coordinates of a cell, each of kAxisBits.
std::uint64_t KeyOf(const Eigen::Vector3f& p, double size_m) {
  std::uint64_t key = 0;
  for (int axis = 0; axis < 3; ++axis) {
    const std::int64_t cell = Floor(p[axis] / size_m) + kCellOffset;
    key = (key << kAxisBits) | static_cast<std::uint64_t>(cell);
  }
  return key;
}

// Occupied cells of a grid, numbered in the order in which they are met.
class Cells {
 public:
  static constexpr std::uint32_t kNone = 0xFFFFFFFFU;  // an empty slot

  Cells() : slots_(kFewestSlots, kNone) {}

  std::uint32_t Add(std::uint64_t key) {
    if (2 * keys_.size() >= slots_.size()) Grow();
    std::uint32_t& slot = slots_[SlotOf(key)];
    if (slot == kNone) {
      slot = static_cast<std::uint32_t>(keys_.size());
      keys_.push_back(key);
    }
    return slot;
  }
  [[nodiscard]] std::uint32_t Find(std::uint64_t key) const { return slots_[SlotOf(key)]; }
  [[nodiscard]] const std::vector<std::uint64_t>& keys() const { return keys_; }

 private:
  static constexpr std::size_t kFewestSlots = 1024;  // a power of two, as are all sizes of `slots_`

  // Where the key is or would be.
  [[nodiscard]] std::size_t SlotOf(std::uint64_t key) const {
    const std::size_t last = slots_.size() - 1;
    std::size_t at = (key * 0x9E3779B97F4A7C15ULL >> 32U) & last;
    while (slots_[at] != kNone && keys_[slots_[at]] != key) at = (at + 1) & last;
    return at;
  }
  void Grow() {
    slots_.assign(2 * slots_.size(), kNone);
    for (std::size_t n = 0; n < keys_.size(); ++n) {
      slots_[SlotOf(keys_[n])] = static_cast<std::uint32_t>(n);
    }
  }

  std::vector<std::uint32_t> slots_;
  std::vector<std::uint64_t> keys_;
};

// Groups of cells that touch, counted in the order of first cells.
std::vector<int> GroupCells(const Cells& cells, int& count) {
  std::vector<int> group_of(cells.keys().size(), -1);
  std::vector<std::uint32_t> open;
  for (std::uint32_t seed = 0; seed < group_of.size(); ++seed) {
    if (group_of[seed] >= 0) continue;
    const int group = count++;
    group_of[seed] = group;
    open.assign(1, seed);
    while (!open.empty()) {
      const std::uint64_t key = cells.keys()[open.back()];
      open.pop_back();
      for (std::int64_t n = 0; n < 27; ++n) {
        const std::int64_t step =
            ((n / 9 - 1) << 2 * kAxisBits) + ((n / 3 % 3 - 1) << kAxisBits) + n % 3 - 1;
        const std::uint32_t next = cells.Find(key + static_cast<std::uint64_t>(step));
        if (next == Cells::kNone || group_of[next] >= 0) continue;
        group_of[next] = group;
        open.push_back(next);
      }
    }
  }
  return group_of;
}

}  // namespace

Groups ConnectPoints(std::span<const PixelPoint> points, double gap_m) {
  const double size_m = 0.7 * gap_m;
  Groups groups;
  if (points.empty()) return groups;
  Cells cells;
  groups.of_point.reserve(points.size());
  std::uint64_t last_key = KeyOf(points[0].p_camera, size_m);
  std::uint32_t cell = cells.Add(last_key);
  for (const PixelPoint& point : points) {
    // Most pixels fall into the cell of the one beside them.
    const std::uint64_t key = KeyOf(point.p_camera, size_m);
    if (key != last_key) cell = cells.Add(key);
    last_key = key;
    groups.of_point.push_back(static_cast<int>(cell));
  }
  const std::vector<int> group_of = GroupCells(cells, groups.count);
  for (int& of_point : groups.of_point) of_point = group_of[static_cast<std::size_t>(of_point)];
  return groups;
}

}  // namespace deepslam::segment

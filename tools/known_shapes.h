// Shapes that others are compared with: which products are one for the split, what is like a
// withheld one.
#pragma once

#include <cstddef>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "deepslam/library/alike.h"
#include "deepslam/scene/voxel_grid.h"

namespace deepslam::tools {

// Canonical shapes, each made ready to be compared once.
class KnownShapes {
 public:
  void Add(const VoxelGrid& shape);
  // The number of the first that is like `shape`. Thread-safe.
  [[nodiscard]] std::optional<std::size_t> FindAlike(const VoxelGrid& shape) const;

 private:
  struct Known {
    explicit Known(const VoxelGrid& shape) : grid(shape), comparable(grid) {}
    VoxelGrid grid;
    library::ComparableShape comparable;  // refers to `grid`
  };
  std::vector<std::unique_ptr<Known>> shapes_;
};

// "train", or, of one design in twelve, "validate"; designs that are alike are one for the split:
// whichever comes first decides.
class ShapeGroups {
 public:
  [[nodiscard]] std::string SplitFor(const std::string& id, const VoxelGrid& shape);

 private:
  KnownShapes shapes_;
  std::vector<std::string> splits_;
};

// By a hash of the name alone.
[[nodiscard]] std::string SplitOf(const std::string& id);

}  // namespace deepslam::tools

// Edges for the tests of this folder, and stores of edges on disk.
#pragma once

#include <filesystem>
#include <memory>
#include <vector>

#include <gtest/gtest.h>

#include "deepslam/core/random.h"
#include "deepslam/stages/disk_edge_store.h"

namespace deepslam::testing_support {

// From each keyframe to the next, every field another one each time.
inline std::vector<RelativePose> SampleEdges(int count) {
  Random random(3, "edges", 0);
  const auto number = [&] { return random.Uniform(-3, 3); };
  std::vector<RelativePose> edges;
  for (int k = 0; k < count; ++k) {
    Matrix6d information;
    for (int row = 0; row < 6; ++row) {
      for (int col = row; col < 6; ++col) information(row, col) = information(col, row) = number();
    }
    const Pose3 i_from_j{RotationFromVector({number(), number(), number()}),
                         {number(), number(), number()}};
    edges.push_back({FrameIdx{k}, FrameIdx{k + 1}, i_from_j, information, k % 3 == 0});
  }
  return edges;
}

inline std::shared_ptr<const EdgeStore> StoreOf(const std::vector<RelativePose>& edges,
                                                const std::filesystem::path& folder) {
  const auto store =
      std::make_shared<stages::DiskEdgeStore>(std::make_shared<storage::ScratchFile>(folder));
  EXPECT_TRUE(AddAll(edges, *store).ok());
  return store;
}

}  // namespace deepslam::testing_support

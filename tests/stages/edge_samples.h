// Edges for the tests of this folder, and shelves of edges.
#pragma once

#include <filesystem>
#include <memory>
#include <vector>

#include <gtest/gtest.h>

#include "deepslam/core/random.h"
#include "deepslam/stages/shelf_of_edges.h"

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

inline std::shared_ptr<const ShelvedEdges> ShelfOf(const std::vector<RelativePose>& edges,
                                                   const std::filesystem::path& folder) {
  const auto shelf =
      std::make_shared<stages::ShelfOfEdges>(std::make_shared<storage::ScratchFile>(folder));
  EXPECT_TRUE(shelf->Add(edges).ok());
  return shelf;
}

}  // namespace deepslam::testing_support

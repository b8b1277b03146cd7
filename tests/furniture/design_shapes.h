// Generated designs as meshes and solids, for tests of what is made of them.
#pragma once

#include <cstdint>
#include <string>

#include <gtest/gtest.h>

#include "deepslam/furniture/design.h"
#include "deepslam/shape/voxelize.h"

namespace deepslam::furniture {

// The `number`-th of this kind, of a seed of each test's own.
inline TriangleMesh MakeMesh(Kind kind, std::uint64_t number, const std::string& test) {
  return MakeDesign(kind, Random(7, test, number)).mesh;
}

inline VoxelGrid ShapeOf(const TriangleMesh& mesh) {
  const Result<VoxelGrid> shape = shape::Voxelize(mesh);
  EXPECT_TRUE(shape);
  return shape ? *shape : VoxelGrid{};
}

}  // namespace deepslam::furniture

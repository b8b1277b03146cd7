#include "deepslam/priors/exchanged_back.h"

#include <algorithm>
#include <array>

#include <gtest/gtest.h>
#include <Eigen/Geometry>

#include "deepslam/core/result.h"
#include "deepslam/scene/voxel_grid.h"
#include "deepslam/shape/voxelize.h"

namespace deepslam::priors {
namespace {

void AddBox(const Eigen::Vector3f& low, const Eigen::Vector3f& high, TriangleMesh& mesh) {
  const auto first = static_cast<std::uint32_t>(mesh.vertices.size());
  for (int n = 0; n < 8; ++n) {
    mesh.vertices.emplace_back((n & 1) != 0 ? high.x() : low.x(),
                               (n & 2) != 0 ? high.y() : low.y(),
                               (n & 4) != 0 ? high.z() : low.z());
    mesh.colours.push_back({90, 60, 30});
  }
  constexpr std::array<std::array<std::uint32_t, 4>, 6> kSides = {
      {{0, 4, 6, 2}, {1, 3, 7, 5}, {0, 1, 5, 4}, {2, 6, 7, 3}, {0, 2, 3, 1}, {4, 5, 7, 6}}};
  for (const auto& side : kSides) {
    mesh.faces.push_back({first + side[0], first + side[1], first + side[2]});
    mesh.faces.push_back({first + side[0], first + side[2], first + side[3]});
  }
}

// A seat 0.45 m high on four legs, with a board behind that begins at `board_m` and ends at 1 m.
TriangleMesh Chair(float board_m) {
  TriangleMesh mesh;
  AddBox({-0.25F, -0.25F, 0.38F}, {0.25F, 0.25F, 0.45F}, mesh);
  for (const float x : {-0.2F, 0.2F}) {
    for (const float y : {-0.2F, 0.2F})
      AddBox({x - 0.03F, y - 0.03F, 0}, {x + 0.03F, y + 0.03F, 0.4F}, mesh);
  }
  AddBox({-0.25F, -0.25F, board_m}, {-0.19F, 0.25F, 1}, mesh);
  return mesh;
}

// The same with an open back: two posts and a bar.
TriangleMesh OpenChair() {
  TriangleMesh mesh = Chair(0.92F);
  for (const float y : {-0.2F, 0.2F})
    AddBox({-0.25F, y - 0.03F, 0.4F}, {-0.19F, y + 0.03F, 0.95F}, mesh);
  return mesh;
}

bool Same(const TriangleMesh& a, const TriangleMesh& b) {
  return a.vertices == b.vertices && a.faces == b.faces;
}

// Of the faces, those that cross the middle of the open back.
int FacesAcross(const TriangleMesh& mesh) {
  return static_cast<int>(std::count_if(mesh.faces.begin(), mesh.faces.end(), [&](const auto& f) {
    Eigen::AlignedBox3f box;
    for (const std::uint32_t corner : f) box.extend(mesh.vertices[corner]);
    return box.contains(Eigen::Vector3f(box.center().x(), 0, 0.7F));
  }));
}

TEST(WithBackOf, HasTheBackOfTheOther) {
  const TriangleMesh open = OpenChair();
  const TriangleMesh closed = Chair(0.4F);
  ASSERT_EQ(FacesAcross(open), 0);
  ASSERT_GT(FacesAcross(closed), 0);
  EXPECT_GT(FacesAcross(WithBackOf(open, closed)), 0);
  EXPECT_EQ(FacesAcross(WithBackOf(closed, open)), 0);
}

TEST(WithBackOf, KeepsItsOwnWhereThereIsNoSeat) {
  TriangleMesh post;
  AddBox({-0.02F, -0.02F, 0}, {0.02F, 0.02F, 1}, post);
  AddBox({-0.3F, -0.3F, 0}, {0.3F, 0.3F, 0.05F}, post);
  const TriangleMesh chair = Chair(0.4F);
  EXPECT_TRUE(Same(WithBackOf(chair, post), chair));
  EXPECT_TRUE(Same(WithBackOf(post, chair), post));
  EXPECT_TRUE(Same(WithBackOf(chair, TriangleMesh{}), chair));
  EXPECT_TRUE(WithBackOf(TriangleMesh{}, chair).empty());
}

// A board that hovers above its seat would hover above any other.
TEST(WithBackOf, KeepsItsOwnWhereTheOtherWouldHover) {
  const TriangleMesh chair = Chair(0.4F);
  EXPECT_TRUE(Same(WithBackOf(chair, Chair(0.6F)), chair));
}

// The deep back stood on its own seat; now most of it stands behind the other's, and stays solid.
TEST(WithBackOf, ClosesWhatTheCutOpens) {
  TriangleMesh deep = Chair(0.4F);
  AddBox({-0.25F, -0.25F, 0.4F}, {0.1F, 0.25F, 1}, deep);
  TriangleMesh on_sledges = Chair(0.4F);
  for (const float y : {-0.2F, 0.2F})
    AddBox({-0.9F, y - 0.03F, 0}, {0.2F, y + 0.03F, 0.06F}, on_sledges);
  const Result<VoxelGrid> joined = shape::Voxelize(WithBackOf(on_sledges, deep));
  ASSERT_TRUE(joined);
  // The box is 1.15 m long, 62 voxels; the block is 0.8 m of it, and 0.55 m high on the seat.
  EXPECT_FALSE(joined->At(10, 32, 20));
  EXPECT_TRUE(joined->At(10, 32, 45));
  EXPECT_TRUE(joined->At(24, 32, 50));
}

}  // namespace
}  // namespace deepslam::priors

#include "deepslam/mesh/floor_surface.h"

#include <algorithm>
#include <cmath>
#include <set>
#include <vector>

#include <gtest/gtest.h>

#include "deepslam/core/random.h"
#include "deepslam/mesh/ground_polygon.h"
#include "deepslam/mesh/surface_distance.h"

namespace deepslam::mesh {
namespace {

constexpr double kBandM = 0.04;
constexpr double kCellM = 0.02;

// A patch of surface over [x0, x1] x [0, 2] in the plane that `lift` tells.
template <typename Lift>
void AddPatch(double x0, double x1, Rgb8 colour, Lift lift, TriangleMesh& mesh) {
  const auto first = static_cast<std::uint32_t>(mesh.vertices.size());
  const int nx = static_cast<int>(std::lround((x1 - x0) / kCellM));
  const int ny = static_cast<int>(std::lround(2.0 / kCellM));
  for (int i = 0; i <= nx; ++i) {
    for (int j = 0; j <= ny; ++j) {
      mesh.vertices.push_back(lift(x0 + kCellM * i, kCellM * j).template cast<float>());
      mesh.colours.push_back(colour);
    }
  }
  for (int i = 0; i < nx; ++i) {
    for (int j = 0; j < ny; ++j) {
      const auto v = first + static_cast<std::uint32_t>(i * (ny + 1) + j);
      const auto w = v + static_cast<std::uint32_t>(ny + 1);
      mesh.faces.push_back({v, w, w + 1});
      mesh.faces.push_back({v, w + 1, v + 1});
    }
  }
}

// Floor of two colours over [0, 3], noisy as fused depth is; a gap in it; more floor apart; a wall
// that begins on the floor; a box's top at 20 cm.
TriangleMesh Room() {
  Random random(3);
  TriangleMesh room;
  const auto floor = [&](double x, double y) {
    return Eigen::Vector3d(x, y, 0.008 * random.Normal());
  };
  AddPatch(0, 1.2, {200, 0, 0}, floor, room);
  AddPatch(1.4, 3, {0, 0, 200}, floor, room);
  AddPatch(5, 6, {0, 200, 0}, floor, room);
  AddPatch(
      0, 1, {9, 9, 9}, [](double h, double y) { return Eigen::Vector3d(3, y, h); }, room);
  AddPatch(
      1, 1.4, {7, 7, 7}, [](double x, double y) { return Eigen::Vector3d(x, y, 0.2); }, room);
  return room;
}

TriangleMesh Ground(const TriangleMesh& room) {
  std::vector<Eigen::Vector2d> points;
  for (const Eigen::Vector3f& p : room.vertices) {
    if (std::abs(p.z()) < kBandM) points.emplace_back(p.x(), p.y());
  }
  return *GroundPolygon(points);
}

int CountFaces(const TriangleMesh& mesh, Rgb8 colour) {
  return static_cast<int>(std::count_if(mesh.faces.begin(), mesh.faces.end(), [&](const auto& f) {
    return mesh.colours[f[0]] == colour && mesh.colours[f[1]] == colour;
  }));
}

TEST(WithoutFloor, TakesTheFloorOverThePolygonAndNothingElse) {
  const TriangleMesh room = Room();
  const TriangleMesh rest = WithoutFloor(room, Ground(room), kBandM);
  // The outline is a simplified one, and leaves slivers beside it.
  for (const Rgb8 taken : {Rgb8{200, 0, 0}, Rgb8{0, 0, 200}})
    EXPECT_LT(CountFaces(rest, taken), CountFaces(room, taken) / 100);
  for (const Rgb8 kept : {Rgb8{0, 200, 0}, Rgb8{9, 9, 9}, Rgb8{7, 7, 7}})
    EXPECT_EQ(CountFaces(rest, kept), CountFaces(room, kept)) << int(kept.r) << ' ' << int(kept.g);
}

// No point of the polygon has a level face of the room in its plane above or below it.
TEST(WithoutFloor, LeavesNothingInThePlaneOfThePolygon) {
  const TriangleMesh room = Room();
  const TriangleMesh ground = Ground(room);
  const TriangleMesh rest = WithoutFloor(room, ground, kBandM);
  Random random(1);
  const auto covers = [](const TriangleMesh& mesh, const Eigen::Vector2f& p, float band) {
    return std::any_of(mesh.faces.begin(), mesh.faces.end(), [&](const auto& f) {
      for (std::size_t n = 0; n < 3; ++n) {
        const Eigen::Vector3f& a = mesh.vertices[f[n]];
        const Eigen::Vector2f along =
            mesh.vertices[f[(n + 1) % 3]].template head<2>() - a.head<2>();
        const Eigen::Vector2f to = p - a.head<2>();
        if (std::abs(a.z()) > band || along.x() * to.y() - along.y() * to.x() <= 0) return false;
      }
      return true;
    });
  };
  int num_on_ground = 0;
  for (int n = 0; n < 400; ++n) {
    const Eigen::Vector2f p(random.Uniform(-0.1, 3.1), random.Uniform(-0.1, 2.1));
    if (!covers(ground, p, 1.0F)) continue;
    ++num_on_ground;
    EXPECT_FALSE(covers(rest, p, static_cast<float>(kBandM))) << p.transpose();
  }
  EXPECT_GT(num_on_ground, 300);
}

TEST(WithoutObjects, TakesWhatLiesOnAnObjectAndLeavesItsSurroundings) {
  const TriangleMesh room = Room();
  TriangleMesh object;  // just over the box's top, and beyond it on one side
  object.vertices = {{1.0F, 0, 0.22F}, {1.4F, 0, 0.22F}, {1.4F, 3, 0.22F}, {1.0F, 3, 0.22F}};
  object.faces = {{0, 1, 2}, {0, 2, 3}};
  const std::vector<TriangleMesh> objects = {TriangleMesh(), object};
  const TriangleMesh rest = WithoutObjects(room, objects, 0.05, kBandM);
  EXPECT_EQ(CountFaces(rest, {7, 7, 7}), 0);
  EXPECT_EQ(room.faces.size() - rest.faces.size(),
            static_cast<std::size_t>(CountFaces(room, {7, 7, 7})));
  EXPECT_EQ(WithoutObjects(room, objects, 0.01, kBandM).faces.size(), room.faces.size());
}

TEST(WithoutObjects, LeavesTheFloorUnderAnObject) {
  const TriangleMesh room = Room();
  TriangleMesh foot;  // a steep board on the red floor
  foot.vertices = {{0.5F, 0, 0}, {0.5F, 2, 0}, {0.5F, 2, 0.5F}, {0.5F, 0, 0.5F}};
  foot.faces = {{0, 1, 2}, {0, 2, 3}};
  const TriangleMesh rest = WithoutObjects(room, std::vector<TriangleMesh>{foot}, 0.05, kBandM);
  EXPECT_GT(CountFaces(rest, {200, 0, 0}), CountFaces(room, {200, 0, 0}) * 99 / 100);
  // Where the floor is not told apart it goes.
  EXPECT_LT(WithoutObjects(room, std::vector<TriangleMesh>{foot}, 0.05, 0).faces.size(),
            rest.faces.size() - 500);
}

TEST(SurfaceDistance, BoundsAgreeWithTheDistanceItself) {
  const TriangleMesh room = Room();
  TriangleMesh moved = room;
  for (Eigen::Vector3f& p : moved.vertices) p.z() += 0.003F;
  const double distance = SurfaceDistance(room, moved);
  EXPECT_GT(distance, 0.001);
  EXPECT_TRUE(WithinDistance(room, moved, distance * 1.0001));
  EXPECT_FALSE(WithinDistance(room, moved, distance * 0.9999));
  moved.faces.erase(moved.faces.begin(), moved.faces.begin() + 400);  // one way alone
  EXPECT_FALSE(WithinDistance(room, moved, distance * 1.0001));
  EXPECT_FALSE(WithinDistance(moved, room, distance * 1.0001));
}

TEST(ColouredGround, HasTheFloorsColoursAndTheSameOutline) {
  const TriangleMesh room = Room();
  const TriangleMesh ground = Ground(room);
  const TriangleMesh coloured = ColouredGround(ground, room, kBandM, 0.05);
  EXPECT_EQ(OutlineOf(coloured), OutlineOf(ground));
  ASSERT_EQ(coloured.colours.size(), coloured.vertices.size());
  EXPECT_GT(coloured.vertices.size(), 3 * 2 / (0.05 * 0.05) * 0.8);
  for (std::size_t v = 0; v < coloured.vertices.size(); ++v) {
    const Eigen::Vector3f& p = coloured.vertices[v];
    EXPECT_EQ(p.z(), 0.0F);
    const Rgb8 colour = coloured.colours[v];
    EXPECT_TRUE(p.x() > 1.1F || colour == (Rgb8{200, 0, 0})) << p.transpose();
    EXPECT_TRUE(p.x() < 1.5F || p.x() > 2.9F || colour == (Rgb8{0, 0, 200})) << p.transpose();
    EXPECT_TRUE(colour.g < 10 && colour.r + colour.b > 50) << p.transpose();  // never the box's
  }
}

// A ring of grey floor about a middle that nobody saw, with a small green patch at its rim.
TEST(ColouredGround, WhatNobodySawIsAsWhatLiesAroundItAsAWhole) {
  const Rgb8 grey{120, 118, 116};
  TriangleMesh room;
  for (double x = 0; x < 4; x += 0.02) {
    for (double y = 0; y < 4; y += 0.02) {
      if (std::hypot(x - 2, y - 2) < 1.5) continue;
      const bool in_patch = std::hypot(x - 3.6, y - 2) < 0.12;
      room.vertices.emplace_back(static_cast<float>(x), static_cast<float>(y), 0.0F);
      room.colours.push_back(in_patch ? Rgb8{20, 200, 20} : grey);
    }
  }
  TriangleMesh ground;
  ground.vertices = {{0, 0, 0}, {4, 0, 0}, {4, 4, 0}, {0, 4, 0}};
  ground.faces = {{0, 1, 2}, {0, 2, 3}};
  const TriangleMesh coloured = ColouredGround(ground, room, kBandM, 0.05);
  ASSERT_EQ(coloured.colours.size(), coloured.vertices.size());
  int num_unseen = 0;
  int most_green = 0;
  for (std::size_t v = 0; v < coloured.vertices.size(); ++v) {
    const Eigen::Vector3f& p = coloured.vertices[v];
    const double from_middle = std::hypot(p.x() - 2, p.y() - 2);
    const int green = coloured.colours[v].g - coloured.colours[v].r;
    if (from_middle > 1.3) {
      most_green = std::max(most_green, green);
      continue;
    }
    ++num_unseen;
    // The patch lies half a metre away at the nearest point: it colours no strip towards the
    // middle.
    const double from_patch = std::hypot(p.x() - 3.6, p.y() - 2);
    EXPECT_LT(green, 180 * 0.1 / from_patch) << p.transpose();
  }
  EXPECT_GT(num_unseen, 1500);
  EXPECT_EQ(most_green, 180) << "what was seen keeps its colour";
}

TEST(ColouredGround, StaysAsItIsWithoutColours) {
  TriangleMesh room = Room();
  const TriangleMesh ground = Ground(room);
  EXPECT_EQ(ColouredGround(ground, room, kBandM, 0).vertices, ground.vertices);
  room.colours.clear();
  EXPECT_TRUE(ColouredGround(ground, room, kBandM, 0.05).colours.empty());
  EXPECT_TRUE(ColouredGround({}, room, kBandM, 0.05).empty());
  EXPECT_EQ(WithoutFloor(room, {}, kBandM).faces.size(), room.faces.size());
}

}  // namespace
}  // namespace deepslam::mesh

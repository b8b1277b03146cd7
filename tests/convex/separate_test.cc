#include "deepslam/convex/separate.h"

#include <gtest/gtest.h>

#include "convex/convex_samples.h"
#include "deepslam/convex/mass_properties.h"

namespace deepslam::convex {
namespace {

using testing_support::BoxMesh;

double HighestX(const TriangleMesh& mesh) {
  double x = -1e9;
  for (const Eigen::Vector3f& p : mesh.vertices) x = std::max(x, static_cast<double>(p.x()));
  return x;
}
double LowestX(const TriangleMesh& mesh) {
  double x = 1e9;
  for (const Eigen::Vector3f& p : mesh.vertices) x = std::min(x, static_cast<double>(p.x()));
  return x;
}

TEST(Separate, CutsInTheMiddleOfTheOverlap) {
  std::vector<PiecedThing> things = {{{BoxMesh({0, 0, 0}, {1, 1, 1})}},
                                     {{BoxMesh({0.9F, 0, 0}, {2, 1, 1})}}};
  Separate(things, 0.01);
  EXPECT_NEAR(HighestX(things[0].pieces[0]), 0.945, 1e-5);
  EXPECT_NEAR(LowestX(things[1].pieces[0]), 0.955, 1e-5);
}

TEST(Separate, FixedThingsGiveWayToNone) {
  for (const bool first : {true, false}) {
    std::vector<PiecedThing> things = {{{BoxMesh({0, 0, 0}, {1, 1, 1})}, first},
                                       {{BoxMesh({0.9F, 0, 0}, {2, 1, 1})}, !first}};
    Separate(things, 0.01);
    EXPECT_NEAR(HighestX(things[0].pieces[0]), first ? 1 : 0.89, 1e-5);
    EXPECT_NEAR(LowestX(things[1].pieces[0]), first ? 1.01 : 0.9, 1e-5);
  }
  std::vector<PiecedThing> both = {{{BoxMesh({0, 0, 0}, {1, 1, 1})}, true},
                                   {{BoxMesh({0.9F, 0, 0}, {2, 1, 1})}, true}};
  Separate(both, 0.01);
  EXPECT_NEAR(HighestX(both[0].pieces[0]), 1, 1e-6);
}

TEST(Separate, LeavesWhatDoesNotOverlap) {
  std::vector<PiecedThing> things = {
      {{BoxMesh({0, 0, 0}, {1, 1, 1}), BoxMesh({0, 0, 1}, {1, 1, 2})}},
      {{BoxMesh({1.1F, 0, 0}, {2, 1, 1})}},
      {}};
  Separate(things, 0.01);
  EXPECT_EQ(things[0].pieces.size(), 2U) << "pieces of one thing may touch";
  EXPECT_NEAR(VolumeOf(things[0].pieces[0]) + VolumeOf(things[1].pieces[0]), 1.9, 1e-5);
}

TEST(Separate, TakesOutOfWhichNothingIsLeft) {
  std::vector<PiecedThing> things = {{{BoxMesh({0, 0, 0}, {1, 1, 1})}, true},
                                     {{BoxMesh({0.4F, 0.4F, 0.9F}, {0.5F, 0.5F, 0.99F})}}};
  Separate(things, 0.02);
  EXPECT_TRUE(things[1].pieces.empty());
}

}  // namespace
}  // namespace deepslam::convex

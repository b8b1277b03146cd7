// Matching, placement, surfaces and intervals: what `eval objects` and `eval map` add up.
#include <cmath>
#include <limits>
#include <numbers>
#include <vector>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "deepslam/eval/bootstrap.h"
#include "deepslam/eval/placed_iou.h"
#include "deepslam/eval/placement.h"
#include "deepslam/eval/shape_similarity.h"
#include "deepslam/eval/surface_comparison.h"
#include "deepslam/shape/stretch.h"
#include "deepslam/shape/symmetry.h"
#include "deepslam/shape/voxelize.h"
#include "support/box_meshes.h"

namespace deepslam::eval {
namespace {

using shape::Symmetry;
using shape::TurnGrid;
using testing_support::AddBox;

Pose3 At(double x, double y, double yaw_deg) {
  return {Eigen::Quaterniond(
              Eigen::AngleAxisd(yaw_deg * std::numbers::pi / 180, Eigen::Vector3d::UnitZ())),
          {x, y, 0.4}};
}

TriangleMesh Table(float length, float width) {
  return testing_support::TableMesh(length, width, 0.75F, 0.08F);
}

VoxelGrid Grid(const TriangleMesh& mesh) { return shape::Voxelize(mesh).value(); }

TEST(ShapeIou, ATurnedShapeScoresTheSame) {
  const VoxelGrid table = Grid(Table(1.4F, 0.8F));
  const VoxelGrid other = Grid(testing_support::BoxMesh({0.8F, 0.6F, 0.5F}));
  const auto iou = [](const VoxelGrid& a, const VoxelGrid& b) {
    return IouPerThreshold(NormaliseForIou(Volume(a)).value(), NormaliseForIou(Volume(b)).value());
  };
  EXPECT_THAT(iou(TurnGrid(table, 2), table), testing::Each(1.0));
  EXPECT_EQ(iou(TurnGrid(other, 2), table), iou(other, table));
  EXPECT_THAT(iou(TurnGrid(table, 1), table), testing::Each(testing::Lt(0.8)));
}

TEST(Placement, OfTheTruthItselfIsExact) {
  const PlacedBox table{"table", At(1, 2, 30), {1.4, 0.8, 0.75}};
  const PlacementError error = ComparePlacement(table, table, Symmetry::kHalf, {});
  EXPECT_EQ(error.translation_m, 0);
  EXPECT_NEAR(error.rotation_deg, 0, 1e-5);
  EXPECT_EQ(error.scale_percent, 0);
  EXPECT_TRUE(error.correct);
}

TEST(Placement, RotationIsCountedByTheSymmetry) {
  const PlacedBox truth{"table", At(0, 0, 10), {0.9, 0.9, 0.75}};
  const auto rotation = [&](double yaw_deg, Symmetry symmetry) {
    return ComparePlacement({"table", At(0, 0, yaw_deg), truth.size_m}, truth, symmetry, {})
        .rotation_deg;
  };
  EXPECT_NEAR(rotation(195, Symmetry::kNone), 175, 1e-6);
  EXPECT_NEAR(rotation(195, Symmetry::kHalf), 5, 1e-6);
  EXPECT_NEAR(rotation(105, Symmetry::kHalf), 85, 1e-6);
  EXPECT_NEAR(rotation(105, Symmetry::kQuarter), 5, 1e-6);
  EXPECT_NEAR(rotation(57, Symmetry::kAny), 0, 1e-5);
}

TEST(Placement, EachLimitDecidesAlone) {
  const PlacedBox truth{"chair", At(0, 0, 0), {0.5, 0.5, 0.9}};
  const auto correct = [&](double x, double yaw_deg, double scale) {
    return ComparePlacement(
               {"chair", At(x, 0, yaw_deg), scale * truth.size_m}, truth, Symmetry::kNone, {})
        .correct;
  };
  EXPECT_TRUE(correct(0.19, 19, 1.19));
  EXPECT_FALSE(correct(0.21, 0, 1));
  EXPECT_FALSE(correct(0, 21, 1));
  EXPECT_FALSE(correct(0, 0, 1.21));
  EXPECT_FALSE(correct(0, 0, 0.79));
}

TEST(Placement, SidesAreComparedAsTheyStand) {
  // A table whose model has its length along y, turned so that it lies along the true one.
  const PlacedBox truth{"table", At(0, 0, 0), {1.4, 0.8, 0.75}};
  const PlacedBox estimated{"table", At(0, 0, 90), {0.8, 1.4, 0.75}};
  EXPECT_EQ(QuarterTurnsAsPlaced(estimated.world_from_object, truth.world_from_object), 1);
  EXPECT_NEAR(ComparePlacement(estimated, truth, Symmetry::kHalf, {}).scale_percent, 0, 1e-9);
}

TEST(Placement, ABoxAloneHasNoFront) {
  // A bed's front is at its foot; the box drawn round it may have its x axis across.
  const PlacedBox truth{"bed", At(0, 0, 0), {1.1, 1.9, 0.6}};
  const PlacedBox along{"bed", At(0, 0, 90), {1.8, 1.0, 0.6}};
  const PlacedBox across{"bed", At(0, 0, 0), {1.8, 1.0, 0.6}};
  const auto rotation_deg = [&](const PlacedBox& bed) {
    return ComparePlacement(WithAxesAlongLikeSides(bed, truth), truth, Symmetry::kHalf, {})
        .rotation_deg;
  };
  EXPECT_NEAR(ComparePlacement(along, truth, Symmetry::kHalf, {}).rotation_deg, 90, 1e-5);
  EXPECT_NEAR(rotation_deg(along), 0, 1e-5);
  EXPECT_NEAR(rotation_deg(across), 90, 1e-5) << "it lies across the true one";
  EXPECT_EQ(WithAxesAlongLikeSides(truth, truth).size_m, truth.size_m);
}

TEST(Matching, TruthAgainstItselfFindsAll) {
  const std::vector<PlacedBox> objects = {{"chair", At(0, 0, 0), {0.5, 0.5, 0.9}},
                                          {"chair", At(0.3, 0, 0), {0.5, 0.5, 0.9}},
                                          {"table", At(0.1, 0.1, 0), {1.4, 0.8, 0.75}}};
  const std::vector<Match> matches = MatchObjects(objects, objects, {});
  ASSERT_EQ(matches.size(), 3U);
  for (std::size_t n = 0; n < 3; ++n) {
    EXPECT_EQ(matches[n].estimated, n);
    EXPECT_EQ(matches[n].truth, n);
  }
  for (const ClassCounts& counts : CountByClass(objects, objects, matches)) {
    EXPECT_EQ(counts.precision(), 1);
    EXPECT_EQ(counts.recall(), 1);
  }
}

TEST(Matching, ClassComesBeforeDistanceAndNothingIsUsedTwice) {
  const std::vector<PlacedBox> truth = {{"chair", At(0, 0, 0), {0.5, 0.5, 0.9}},
                                        {"sofa", At(3, 0, 0), {0.9, 2, 0.9}}};
  const std::vector<PlacedBox> estimated = {{"table", At(0.05, 0, 0), {1, 1, 1}},
                                            {"chair", At(0.3, 0, 0), {0.5, 0.5, 0.9}},
                                            {"bed", At(3.2, 0, 0), {2, 2, 0.9}},
                                            {"chair", At(0.35, 0, 0), {0.5, 0.5, 0.9}}};
  const std::vector<Match> matches = MatchObjects(estimated, truth, {});
  ASSERT_EQ(matches.size(), 2U);
  EXPECT_EQ(matches[0].estimated, 1U);
  EXPECT_TRUE(matches[0].same_class);
  EXPECT_EQ(matches[1].estimated, 2U);
  EXPECT_FALSE(matches[1].same_class);
  for (const ClassCounts& counts : CountByClass(estimated, truth, matches)) {
    if (counts.class_name == "chair") {
      EXPECT_EQ(counts.precision(), 0.5);
      EXPECT_EQ(counts.recall(), 1);
    }
    if (counts.class_name == "sofa") {
      EXPECT_EQ(counts.recall(), 0);
    }
    if (counts.class_name == "bed") {
      EXPECT_EQ(counts.precision(), 0);
    }
  }
}

TEST(Surfaces, TruthAgainstItselfIsWhole) {
  const TriangleMesh mesh = Table(1.4F, 0.8F);
  const auto points = SampleSurface(mesh, At(1, 2, 30), 25e-6, 7);
  const auto again = SampleSurface(mesh, At(1, 2, 30), 25e-6, 7);
  const SurfaceComparison result = CompareSurfaces(points, again, 0.05);
  EXPECT_EQ(result.accuracy, 1);
  EXPECT_EQ(result.completeness, 1);
  EXPECT_EQ(result.f_score, 1);
  EXPECT_EQ(result.accuracy_m, 0);
  EXPECT_EQ(result.completeness_m, 0);
}

TEST(Surfaces, HalfATableIsHalfComplete) {
  TriangleMesh whole;
  AddBox({-1, -0.5F, 0}, {1, 0.5F, 0.02F}, whole);
  TriangleMesh half;
  AddBox({-1, -0.5F, 0}, {0, 0.5F, 0.02F}, half);
  const SurfaceComparison result =
      CompareSurfaces(SampleSurface(half, {}, 1e-4, 1), SampleSurface(whole, {}, 1e-4, 2), 0.05);
  EXPECT_NEAR(result.accuracy, 1, 1e-9);
  EXPECT_NEAR(result.completeness, 0.525, 0.01);  // up to 5 cm past the cut counts
  EXPECT_NEAR(result.f_score, 2 * 0.525 / 1.525, 0.01);
}

TEST(Surfaces, NearestDistancesAreThoseOfBruteForce) {
  const auto a = SampleSurface(Table(1.4F, 0.8F), {}, 4e-3, 1);
  const auto b = SampleSurface(testing_support::BoxMesh({1, 1, 1}), {}, 4e-3, 2);
  double near = 0;
  for (const Eigen::Vector3d& p : a) {
    double least = 1e300;
    for (const Eigen::Vector3d& q : b) least = std::min(least, (p - q).norm());
    near += least <= 0.15 ? 1.0 / static_cast<double>(a.size()) : 0;
  }
  EXPECT_NEAR(CompareSurfaces(a, b, 0.15).accuracy, near, 1e-9);
  EXPECT_GT(near, 0.05);
  EXPECT_LT(near, 0.95);
}

TEST(Surfaces, PointsFollowTheArea) {
  const TriangleMesh box = testing_support::BoxMesh({1, 2, 3});
  EXPECT_NEAR(static_cast<double>(SampleSurface(box, {}, 1e-3, 5).size()), 22 / 1e-3, 2);
}

TEST(Surfaces, InnerWallsAreLeftOut) {
  TriangleMesh mesh = testing_support::BoxMesh({1, 1, 1});
  AddBox({-0.2F, -0.2F, -0.2F}, {0.2F, 0.2F, 0.2F}, mesh);
  const auto points = SampleSurface(mesh, {}, 1e-3, 5);
  const auto outer = OuterPoints(mesh, points);
  EXPECT_NEAR(static_cast<double>(outer.size()) / static_cast<double>(points.size()),
              6.0 / (6.0 + 6 * 0.16),
              0.01);
  for (const Eigen::Vector3d& p : outer) EXPECT_GT(p.cwiseAbs().maxCoeff(), 0.4);
}

TEST(Surfaces, UnusableMeshesAreNamed) {
  EXPECT_THAT(CheckTriangles({}, "a.ply").error().message, testing::HasSubstr("a.ply"));
  TriangleMesh mesh = testing_support::BoxMesh({1, 1, 1});
  mesh.faces.push_back({0, 1, 99});
  EXPECT_THAT(CheckTriangles(mesh, "b.ply").error().message, testing::HasSubstr("99"));
  mesh = testing_support::BoxMesh({1, 1, 1});
  mesh.vertices[3].x() = std::numeric_limits<float>::quiet_NaN();
  EXPECT_THAT(CheckTriangles(mesh, "c.ply").error().message, testing::HasSubstr("finite"));
  EXPECT_FALSE(CheckTriangles(testing_support::BoxMesh({0, 0, 0}), "d.ply").ok());
  EXPECT_TRUE(SampleSurface({}, {}, 1e-4, 1).empty());
  const SurfaceComparison nothing = CompareSurfaces({}, {}, 0.05);
  EXPECT_EQ(nothing.f_score, 0);
}

TEST(PlacedIou, IsThatOfTheBoxesInTheWorld) {
  const TriangleMesh mesh = testing_support::BoxMesh({1, 0.5F, 0.5F});
  const VoxelGrid grid = Grid(mesh);
  const Similarity3 here = At(1, 2, 30) * MeshFromGrid(mesh);
  EXPECT_EQ(PlacedIou(grid, here, grid, here), 1);
  // Moved by half its length along itself: a third. Twice the size about its middle: an eighth.
  Similarity3 moved = here;
  moved.translation_m += here.rotation * Eigen::Vector3d(0.5, 0, 0);
  EXPECT_NEAR(PlacedIou(grid, here, grid, moved), 1.0 / 3, 0.02);
  Similarity3 twice = here;
  twice.scale *= 2;
  EXPECT_NEAR(PlacedIou(grid, here, grid, twice), 1.0 / 8, 0.01);
  EXPECT_EQ(PlacedIou(VoxelGrid(), here, grid, here), 0);
  EXPECT_EQ(PlacedIou(VoxelGrid(), here, VoxelGrid(), here), 0);
}

TEST(Bootstrap, CoversTheMeanAndShrinksWithTheCount) {
  std::vector<double> few;
  std::vector<double> many;
  for (int n = 0; n < 400; ++n) {
    const double value = n % 2 == 0 ? 0.0 : 1.0;
    if (n < 16) few.push_back(value);
    many.push_back(value);
  }
  const Interval a = BootstrapMean(few, 1);
  const Interval b = BootstrapMean(many, 1);
  EXPECT_EQ(a.mean, 0.5);
  EXPECT_LT(a.low, 0.5);
  EXPECT_GT(a.high, 0.5);
  // 1.96 standard errors of a fair coin.
  EXPECT_NEAR(b.high - b.low, 2 * 1.96 * 0.5 / 20, 0.01);
  EXPECT_GT(a.high - a.low, 3 * (b.high - b.low));
  const std::vector<double> single = {0.3};
  EXPECT_EQ(BootstrapMean(single, 1).low, 0.3);
  EXPECT_EQ(BootstrapMean({}, 1).high, 0);
}

}  // namespace
}  // namespace deepslam::eval

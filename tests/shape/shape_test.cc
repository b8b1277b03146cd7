#include <array>
#include <cmath>
#include <limits>
#include <numbers>
#include <optional>
#include <string>
#include <vector>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "deepslam/core/random.h"
#include "deepslam/geometry/point_columns.h"
#include "deepslam/shape/binvox.h"
#include "deepslam/shape/distance_transform.h"
#include "deepslam/shape/front.h"
#include "deepslam/shape/partial_view.h"
#include "deepslam/shape/render_voxels.h"
#include "deepslam/shape/shape_model.h"
#include "deepslam/shape/stretch.h"
#include "deepslam/shape/view_points.h"
#include "deepslam/shape/voxelize.h"
#include "support/box_meshes.h"

namespace deepslam::shape {
namespace {

using testing_support::AddBox;
using testing_support::BoxMesh;
using testing_support::ChairMesh;
using testing_support::SphereMesh;

constexpr float kVoxel = static_cast<float>(kVoxelSize);

template <typename Inside>
VoxelGrid GridWhere(const Inside& inside) {
  VoxelGrid grid;
  for (int i = 0; i < kGridSize; ++i) {
    for (int j = 0; j < kGridSize; ++j) {
      for (int k = 0; k < kGridSize; ++k) {
        grid.occupied[VoxelGrid::Index(i, j, k)] = inside(VoxelGrid::Center(i, j, k)) ? 1 : 0;
      }
    }
  }
  return grid;
}

VoxelGrid BoxGrid(const Eigen::Vector3d& size) {
  return GridWhere(
      [&](const Eigen::Vector3d& p) { return (p.cwiseAbs().array() < 0.5 * size.array()).all(); });
}

int NumParts(const VoxelGrid& grid) {
  std::vector<std::uint8_t> left = grid.occupied;
  int parts = 0;
  for (std::size_t seed = 0; seed < left.size(); ++seed) {
    if (left[seed] == 0) continue;
    ++parts;
    std::vector<std::size_t> stack = {seed};
    left[seed] = 0;
    while (!stack.empty()) {
      const int n = static_cast<int>(stack.back());
      stack.pop_back();
      for (int d = 0; d < 27; ++d) {
        const int i = n / 4096 + d / 9 - 1;
        const int j = n / 64 % 64 + d / 3 % 3 - 1;
        const int k = n % 64 + d % 3 - 1;
        if (!VoxelGrid::Contains(i, j, k) || left[VoxelGrid::Index(i, j, k)] == 0) continue;
        left[VoxelGrid::Index(i, j, k)] = 0;
        stack.push_back(VoxelGrid::Index(i, j, k));
      }
    }
  }
  return parts;
}

TEST(DistanceTransform, EqualsBruteForce) {
  Random random(3);
  VoxelGrid grid;
  std::vector<std::array<int, 3>> solids;
  for (int n = 0; n < 12; ++n) {
    const std::array<int, 3> at = {static_cast<int>(random.Index(64)),
                                   static_cast<int>(random.Index(64)),
                                   static_cast<int>(random.Index(64))};
    grid.occupied[VoxelGrid::Index(at[0], at[1], at[2])] = 1;
    solids.push_back(at);
  }
  const std::vector<float> squared = SquaredDistanceTo(grid, true);
  for (int n = 0; n < 3000; ++n) {
    const auto i = static_cast<int>(random.Index(64));
    const auto j = static_cast<int>(random.Index(64));
    const auto k = static_cast<int>(random.Index(64));
    int best = std::numeric_limits<int>::max();
    for (const auto& s : solids) {
      best = std::min(best,
                      (i - s[0]) * (i - s[0]) + (j - s[1]) * (j - s[1]) + (k - s[2]) * (k - s[2]));
    }
    ASSERT_EQ(squared[VoxelGrid::Index(i, j, k)], static_cast<float>(best));
  }
}

TEST(DistanceTransform, NothingToMeasureToIsFarEverywhere) {
  const std::vector<float> squared = SquaredDistanceTo(VoxelGrid(), true);
  EXPECT_GT(*std::min_element(squared.begin(), squared.end()), 1e9F);
}

TEST(ShapeModel, DistanceOfABoxIsThatOfItsFaces) {
  const ShapeModel model(BoxGrid({0.5, 0.25, 0.75}));
  EXPECT_NEAR(model.Distance({0.25F + 0.1F, 0, 0}), 0.1F, 1e-4F);
  EXPECT_NEAR(model.Distance({0, -0.125F - 0.2F, 0}), 0.2F, 1e-4F);
  EXPECT_NEAR(model.Distance({0, 0.125F - 0.05F, 0}), -0.05F, 1e-4F);
  // Beyond the cube, where no voxel lies.
  EXPECT_NEAR(model.Distance({0, 0, 2.0F}), 2.0F - 0.375F, 1e-3F);
  EXPECT_NEAR(model.Distance({1.25F, 1.125F, 0}), std::sqrt(2.0F), 0.02F);
  EXPECT_NEAR(model.bottom(), -0.375F, 1e-6F);
  EXPECT_EQ(BottomOf(model.grid()), model.bottom());
  EXPECT_TRUE(model.extent().isApprox(Eigen::Vector3f(0.5F, 0.25F, 0.75F), 1e-5F));
}

TEST(ShapeModel, GradientIsTheSlopeOfDistance) {
  const ShapeModel model(BoxGrid({0.5, 0.3, 0.7}));
  Random random(5);
  for (int n = 0; n < 200; ++n) {
    const Eigen::Vector3f p =
        Eigen::Vector3d(
            random.Uniform(-0.45, 0.45), random.Uniform(-0.45, 0.45), random.Uniform(-0.45, 0.45))
            .cast<float>();
    const Eigen::Vector3f gradient = model.Gradient(p);
    const float step = 1e-4F;
    const Eigen::Vector3f cell = (p.array() + 0.5F) * 64.0F - 0.5F;
    // Slopes break at cell borders.
    const Eigen::Array3f part = cell.array() - cell.array().floor();
    if ((part < 0.02F).any() || (part > 0.98F).any()) continue;
    for (int axis = 0; axis < 3; ++axis) {
      const Eigen::Vector3f d = step * Eigen::Vector3f::Unit(axis);
      EXPECT_NEAR(
          gradient[axis], (model.Distance(p + d) - model.Distance(p - d)) / (2 * step), 5e-3F);
    }
  }
}

TEST(ShapeModel, SurfacePointsLieOnTheSurfaceWithOutwardNormals) {
  const ShapeModel model(GridWhere([](const Eigen::Vector3d& p) { return p.norm() < 0.4; }));
  ASSERT_GT(model.surface_points().size(), 1000U);
  double worst = 1;
  double sum = 0;
  for (std::size_t n = 0; n < model.surface_points().size(); ++n) {
    const Eigen::Vector3f& p = model.surface_points()[n];
    EXPECT_NEAR(p.norm(), 0.4F, 1.0F * kVoxel);
    const double cosine = model.surface_normals()[n].dot(p.normalized());
    worst = std::min(worst, cosine);
    sum += cosine;
  }
  EXPECT_GT(worst, 0.9);
  EXPECT_GT(sum / static_cast<double>(model.surface_points().size()), 0.99);
}

TEST(ShapeModel, APlateOneVoxelThinHasTwoSides) {
  VoxelGrid grid;
  for (int i = 10; i < 50; ++i) {
    for (int j = 10; j < 50; ++j) grid.occupied[VoxelGrid::Index(i, j, 32)] = 1;
  }
  const ShapeModel model(grid);
  int up = 0;
  int down = 0;
  for (const Eigen::Vector3f& normal : model.surface_normals()) {
    up += normal.z() > 0.99F ? 1 : 0;
    down += normal.z() < -0.99F ? 1 : 0;
  }
  EXPECT_GT(up, 1400);
  EXPECT_EQ(up, down);
}

TEST(ShapeModel, AnEmptyModelIsFarFromEverything) {
  const ShapeModel model{VoxelGrid()};
  EXPECT_TRUE(model.empty());
  EXPECT_GT(model.Distance({0, 0, 0}), 5.0F);
  EXPECT_EQ(model.Gradient({0, 0, 0}), Eigen::Vector3f::Zero());
  EXPECT_GT(model.Distance(Eigen::Vector3f::Constant(std::nanf(""))), 5.0F);
}

TEST(ShapeModel, ABatchIsSampledAsEachOfItsPoints) {
  const ShapeModel model(BoxGrid({0.5, 0.3, 0.8}));
  VectorColumns points{};
  const auto point = [](std::size_t k) {
    const float n = static_cast<float>(k) - 0.5F * kPointBatch;
    return Eigen::Vector3f(0.012F * n, 0.4F * std::sin(n), 0.7F * std::cos(2 * n));  // some beyond
  };
  for (std::size_t k = 0; k < kPointBatch; ++k)
    points.Set(k, point(k).x(), point(k).y(), point(k).z());
  FieldSampleColumns samples;
  model.At(points, kPointBatch, samples);
  for (std::size_t k = 0; k < kPointBatch; ++k) {
    const auto [distance, gradient] = model.At(point(k));
    EXPECT_FLOAT_EQ(samples.distance[k], distance);
    const Eigen::Vector3f of_batch(
        samples.gradient.x[k], samples.gradient.y[k], samples.gradient.z[k]);
    EXPECT_LE((of_batch - gradient).norm(), 1e-5F) << "point " << k;
  }
}

std::vector<Eigen::Vector3f> ShownPoints(const ShapeModel& model,
                                         double azimuth_rad,
                                         double elevation_rad = 0) {
  const PartialView camera(model, azimuth_rad, elevation_rad);
  std::vector<Eigen::Vector3f> shown;
  for (std::size_t n = 0; n < model.surface_points().size(); ++n) {
    if (camera.Shows(n)) shown.push_back(model.surface_points()[n]);
  }
  return shown;
}

TEST(PartialView, OfABoxFromTheFrontIsItsFrontFace) {
  const ShapeModel model(BoxGrid({0.5, 0.25, 0.75}));
  const std::vector<Eigen::Vector3f> front = ShownPoints(model, 0.0);
  EXPECT_EQ(front.size(), 16U * 48U);
  for (const Eigen::Vector3f& p : front) EXPECT_GT(p.x(), 0.25F - kVoxel);
}

TEST(PartialView, SeesTwoFacesFromACornerAndTheTopFromAbove) {
  const ShapeModel model(BoxGrid({0.5, 0.5, 0.5}));
  const std::vector<Eigen::Vector3f> corner = ShownPoints(model, 0.25 * std::numbers::pi);
  // Two faces that share a column.
  EXPECT_EQ(corner.size(), 2U * 32U * 32U - 32U);
  EXPECT_EQ(ShownPoints(model, 0.0, 0.5 * std::numbers::pi).size(), 32U * 32U);
}

TEST(PartialView, HidesWhatStandsBehind) {
  VoxelGrid grid = GridWhere([](const Eigen::Vector3d& p) {
    return std::abs(p.y()) < 0.2 && std::abs(p.z()) < 0.2 && (p.x() > 0.2 || p.x() < -0.2) &&
           std::abs(p.x()) < 0.3;
  });
  for (const Eigen::Vector3f& p : ShownPoints(ShapeModel(grid), 0.0)) ASSERT_GT(p.x(), 0.0F);
  for (const Eigen::Vector3f& p : ShownPoints(ShapeModel(grid), std::numbers::pi))
    EXPECT_LT(p.x(), 0.0F);
}

TEST(RenderDepth, AgreesWithTheRaysOfABox) {
  const Eigen::Vector3d size(0.5, 0.25, 0.75);
  const ShapeModel model(BoxGrid(size));
  const PinholeCamera camera = {160, 120, 130, 130, 79.5, 59.5};
  Similarity3 camera_from_object;
  camera_from_object.scale = 1.3;
  camera_from_object.rotation =
      Eigen::Quaterniond(Eigen::AngleAxisd(2.1, Eigen::Vector3d(0.6, -0.5, 0.3).normalized()));
  camera_from_object.translation_m = {0.1, -0.05, 1.9};
  const DepthImage depth_m = RenderDepth(model, camera_from_object, camera);
  const Similarity3 object_from_camera = camera_from_object.Inverse();
  int hits = 0;
  int rim = 0;
  for (int v = 0; v < camera.height; ++v) {
    for (int u = 0; u < camera.width; ++u) {
      const Eigen::Vector3d start = object_from_camera.translation_m;
      const Eigen::Vector3d direction = object_from_camera * camera.Ray(u, v) - start;
      double near = 0;
      double far = 1e9;
      for (int axis = 0; axis < 3; ++axis) {
        const double a = (-0.5 * size[axis] - start[axis]) / direction[axis];
        const double b = (0.5 * size[axis] - start[axis]) / direction[axis];
        near = std::max(near, std::min(a, b));
        far = std::min(far, std::max(a, b));
      }
      if ((near < far) != (depth_m(u, v) > 0)) {
        ++rim;
      } else if (near < far) {
        ++hits;
        EXPECT_NEAR(depth_m(u, v), near, 1.3 * kVoxelSize);
      }
    }
  }
  EXPECT_GT(hits, 1000);
  EXPECT_LT(rim, hits / 50);
}

// Far from the camera a voxel's face is less than the last digit of a float beyond the point that
// lies on it.
TEST(RenderDepth, EndsHoweverFarAndSmall) {
  const ShapeModel model(BoxGrid({0.5, 0.25, 0.75}));
  for (const double distance_m : {2.0, 8.0, 20.0, 60.0, 1000.0}) {
    for (int turn = 0; turn < 60; ++turn) {
      Similarity3 camera_from_object;
      camera_from_object.scale = 0.1;
      camera_from_object.rotation = Eigen::Quaterniond(
          Eigen::AngleAxisd(0.1 * turn, Eigen::Vector3d(0.6, -0.5, 0.3).normalized()));
      camera_from_object.translation_m.z() = distance_m;
      const double focal = 300 * distance_m;
      const PinholeCamera camera = {32, 32, focal, focal, 15.5, 15.5};
      const float depth_m = RenderDepth(model, camera_from_object, camera)(16, 16);
      if (distance_m > 60) continue;
      EXPECT_NEAR(depth_m, distance_m, 0.05) << distance_m << ", " << turn;
    }
  }
}

TEST(RenderDepth, OfNothingOrBehindTheCameraIsInvalid) {
  const PinholeCamera camera = {32, 24, 30, 30, 15.5, 11.5};
  Similarity3 behind;
  behind.translation_m = {0, 0, -3};
  for (const float depth : RenderDepth(ShapeModel(BoxGrid({0.5, 0.5, 0.5})), behind, camera))
    EXPECT_EQ(depth, 0);
  for (const float depth : RenderDepth(ShapeModel(VoxelGrid()), Similarity3(), camera))
    EXPECT_EQ(depth, 0);
}

TEST(Voxelize, FillsABox) {
  const Result<VoxelGrid> grid = Voxelize(BoxMesh({0.4F, 0.8F, 1.6F}));
  ASSERT_TRUE(grid.ok());
  const Eigen::Vector3d size = Eigen::Vector3d(0.25, 0.5, 1.0) * kModelExtent;
  EXPECT_GT(GridIntersectionOverUnion(*grid, BoxGrid(size)), 0.93);
  EXPECT_FLOAT_EQ(ShapeModel(*grid).extent().z(), static_cast<float>(kModelExtent));
}

TEST(Voxelize, FillsASphereOfAnyUnit) {
  const VoxelGrid truth =
      GridWhere([](const Eigen::Vector3d& p) { return p.norm() < 0.5 * kModelExtent; });
  for (const float radius : {1e-3F, 1.0F, 4000.0F}) {
    const Result<VoxelGrid> grid = Voxelize(SphereMesh(radius));
    ASSERT_TRUE(grid.ok());
    EXPECT_GT(GridIntersectionOverUnion(*grid, truth), 0.95) << radius;
  }
}

TEST(Voxelize, OrderAndTurnOfTrianglesDoNotMatter) {
  TriangleMesh mesh = ChairMesh(0.45F, 0.5F, 0.45F, 0.9F, 0.03F);
  const Result<VoxelGrid> grid = Voxelize(mesh);
  std::reverse(mesh.faces.begin(), mesh.faces.end());
  for (auto& face : mesh.faces) std::swap(face[0], face[1]);
  const Result<VoxelGrid> again = Voxelize(mesh);
  ASSERT_TRUE(grid.ok() && again.ok());
  EXPECT_GT(GridIntersectionOverUnion(*grid, *again), 0.995);
}

TEST(Voxelize, ASmallHoleDoesNotEmptyTheSolid) {
  TriangleMesh mesh = SphereMesh(1.0F);
  mesh.faces.erase(mesh.faces.begin() + 20);  // at the pole
  const Result<VoxelGrid> grid = Voxelize(mesh);
  ASSERT_TRUE(grid.ok());
  EXPECT_TRUE(grid->At(32, 32, 32));
}

TEST(Voxelize, ThinPartsStayAndStayConnected) {
  // Legs of 4 mm on a metre: a quarter of a voxel.
  const Result<VoxelGrid> grid = Voxelize(ChairMesh(0.45F, 0.5F, 0.45F, 1.0F, 0.004F));
  ASSERT_TRUE(grid.ok());
  EXPECT_EQ(NumParts(*grid), 1);
  EXPECT_LT(ShapeModel(*grid).bottom(), -0.5 * kModelExtent + 1.5 * kVoxelSize);
  int feet = 0;
  for (int i = 0; i < 64; ++i) {
    for (int j = 0; j < 64; ++j) feet += grid->At(i, j, 8) ? 1 : 0;
  }
  EXPECT_GE(feet, 4);
  EXPECT_LE(feet, 8);
}

TEST(Voxelize, RefusesWhatIsNoMesh) {
  EXPECT_FALSE(Voxelize(TriangleMesh()).ok());
  TriangleMesh point;
  point.vertices.assign(3, Eigen::Vector3f(1, 2, 3));
  point.faces.push_back({0, 1, 2});
  EXPECT_FALSE(Voxelize(point).ok());
  TriangleMesh broken = BoxMesh({1, 1, 1});
  broken.vertices.emplace_back(std::nanf(""), 0.0F, 0.0F);
  broken.vertices.emplace_back(std::numeric_limits<float>::infinity(), 0.0F, 0.0F);
  broken.faces.push_back({0, 1, 8});
  broken.faces.push_back({0, 1, 9});
  broken.faces.push_back({0, 1, 4000000000U});
  const Result<VoxelGrid> grid = Voxelize(broken);
  ASSERT_TRUE(grid.ok());
  EXPECT_EQ(*grid, *Voxelize(BoxMesh({1, 1, 1})));
}

TEST(StretchGrid, ChangesProportionsAndRefills) {
  const VoxelGrid stretched = StretchGrid(BoxGrid({0.5, 0.5, 0.5}), {1.0, 2.0, 0.5});
  const Eigen::Vector3f extent = ShapeModel(stretched).extent();
  EXPECT_NEAR(extent.y(), kModelExtent, 1e-5);
  EXPECT_NEAR(extent.x(), 0.5 * kModelExtent, 1.1 * kVoxelSize);
  EXPECT_NEAR(extent.z(), 0.25 * kModelExtent, 1.1 * kVoxelSize);
}

TEST(StretchGrid, TellsWhereTheGridLayThatItCentred) {
  VoxelGrid grid;
  for (int i = 4; i < 20; ++i) {
    for (int j = 30; j < 50; ++j) {
      for (int k = 0; k < 31; ++k) grid.occupied[VoxelGrid::Index(i, j, k)] = 1;
    }
  }
  const Similarity3 grid_from_centred = GridFromCentred(*OccupiedBox(grid));
  const VoxelBox centred = *OccupiedBox(StretchGrid(grid, Eigen::Vector3d::Ones()));
  const auto corner = [](const Eigen::Array3i& voxel) {
    return VoxelGrid::Center(voxel.x(), voxel.y(), voxel.z());
  };
  const Eigen::Vector3d low = grid_from_centred * corner(centred.low);
  const Eigen::Vector3d high = grid_from_centred * corner(centred.high);
  EXPECT_LT((low - corner({4, 30, 0})).cwiseAbs().maxCoeff(), kVoxelSize);
  EXPECT_LT((high - corner({19, 49, 30})).cwiseAbs().maxCoeff(), kVoxelSize);
}

TEST(StretchGrid, TellsItToTheVoxelWhereNothingIsResampled) {
  for (const int side : {20, 21}) {  // an odd one cannot stand in the very middle
    VoxelGrid grid;
    for (int i = 1; i < 63; ++i) {
      for (int k = 5; k < 5 + side; ++k) grid.occupied[VoxelGrid::Index(i, 40, k)] = 1;
    }
    const VoxelBox box = *OccupiedBox(grid);
    const VoxelBox centred = *OccupiedBox(StretchGrid(grid, Eigen::Vector3d::Ones()));
    const Similarity3 grid_from_centred = GridFromCentred(box);
    const Eigen::Vector3d low =
        grid_from_centred * VoxelGrid::Center(centred.low.x(), centred.low.y(), centred.low.z());
    EXPECT_LT((low - VoxelGrid::Center(1, 40, 5)).norm(), 1e-9) << side;
    EXPECT_DOUBLE_EQ(grid_from_centred.scale, 1) << side;
  }
}

TEST(StretchGrid, OfAFullModelByOneIsTheModel) {
  const Result<VoxelGrid> chair = Voxelize(ChairMesh(0.45F, 0.5F, 0.45F, 0.9F, 0.03F));
  ASSERT_TRUE(chair.ok());
  EXPECT_GT(GridIntersectionOverUnion(*chair, StretchGrid(*chair, Eigen::Vector3d::Ones())), 0.97);
  const VoxelGrid thinner = StretchGrid(*chair, {0.7, 0.7, 1.0});
  EXPECT_EQ(NumParts(thinner), 1);
  EXPECT_EQ(StretchGrid(VoxelGrid(), {1, 2, 3}), VoxelGrid());
}

TEST(TurnGrid, TurnsFrontToLeft) {
  VoxelGrid grid;
  grid.occupied[VoxelGrid::Index(60, 30, 5)] = 1;  // in front, a little to the right
  const VoxelGrid turned = TurnGrid(grid, 1);
  EXPECT_TRUE(turned.At(33, 60, 5));
  EXPECT_EQ(TurnGrid(turned, 3), grid);
}

TEST(QuarterTurnsToFront, BringTheBackOfAChairBehind) {
  const Result<VoxelGrid> chair = Voxelize(ChairMesh(0.45F, 0.5F, 0.45F, 0.9F, 0.04F));
  ASSERT_TRUE(chair.ok());
  for (int turns = 0; turns < 4; ++turns) {
    const VoxelGrid turned = TurnGrid(*chair, turns);
    EXPECT_EQ(TurnGrid(turned, QuarterTurnsToFront(turned)), *chair) << turns;
  }
  EXPECT_EQ(QuarterTurnsToFront(BoxGrid({0.9, 0.5, 0.5})), 0);
  EXPECT_EQ(QuarterTurnsToFront(VoxelGrid()), 0);
}

TEST(QuarterTurnsFromHighBack, OfAChairAndOfNoFaceThatWasSeenAlone) {
  const Result<VoxelGrid> chair = Voxelize(ChairMesh(0.45F, 0.5F, 0.45F, 0.9F, 0.04F));
  ASSERT_TRUE(chair.ok());
  for (int turns = 0; turns < 4; ++turns) {
    const VoxelGrid turned = TurnGrid(*chair, turns);
    const std::optional<int> back = QuarterTurnsFromHighBack(turned);
    ASSERT_TRUE(back.has_value());
    EXPECT_EQ(TurnGrid(turned, *back), *chair) << turns;
  }
  // Two upright faces of a box: they are as high as what is below them.
  VoxelGrid faces;
  for (int n = 2; n < 62; ++n) {
    for (int k = 2; k < 62; ++k) {
      faces.occupied[VoxelGrid::Index(61, n, k)] = 1;
      faces.occupied[VoxelGrid::Index(n, 61, k)] = 1;
    }
  }
  EXPECT_FALSE(QuarterTurnsFromHighBack(faces).has_value());
  EXPECT_FALSE(QuarterTurnsFromHighBack(BoxGrid({0.9, 0.5, 0.5})).has_value());
  EXPECT_FALSE(QuarterTurnsFromHighBack(VoxelGrid()).has_value());
}

TEST(Binvox, RoundTrip) {
  const Result<VoxelGrid> chair = Voxelize(ChairMesh(0.45F, 0.5F, 0.45F, 0.9F, 0.03F));
  ASSERT_TRUE(chair.ok());
  for (const VoxelGrid& grid : {*chair, VoxelGrid(), BoxGrid({2, 2, 2})}) {
    const Result<VoxelGrid> read = ReadBinvox(WriteBinvox(grid));
    ASSERT_TRUE(read.ok()) << read.error().message;
    EXPECT_EQ(*read, grid);
  }
}

TEST(Binvox, StoresYFastestAndXSlowest) {
  VoxelGrid grid;
  grid.occupied[VoxelGrid::Index(0, 2, 1)] = 1;  // x 0, z 1, y 2 -> place 66
  const std::string bytes = WriteBinvox(grid);
  const std::string data = bytes.substr(bytes.find("data\n") + 5, 4);
  EXPECT_EQ(data, (std::string{'\0', 66, 1, 1}));
}

TEST(Binvox, RefusesDamagedBytes) {
  const std::string good = WriteBinvox(BoxGrid({0.5, 0.5, 0.5}));
  const std::size_t data = good.find("data\n") + 5;
  EXPECT_FALSE(ReadBinvox("").ok());
  EXPECT_FALSE(ReadBinvox("PK\x03\x04").ok());
  EXPECT_FALSE(ReadBinvox("#binvox 1\ndim 64 64 64\n").ok());
  EXPECT_FALSE(ReadBinvox("#binvox 1\ndata\n").ok());
  EXPECT_FALSE(ReadBinvox("#binvox 1\ndim 100000 100000 100000\ndata\n").ok());
  for (std::size_t cut = 0; cut < good.size(); cut += 97) {
    EXPECT_FALSE(ReadBinvox(good.substr(0, cut)).ok()) << cut;
  }
  EXPECT_FALSE(ReadBinvox(good + std::string{'\0', 1}).ok());
  std::string value = good;
  value[data] = 2;
  EXPECT_FALSE(ReadBinvox(value).ok());
  std::string empty_run = good;
  empty_run[data + 1] = 0;
  EXPECT_FALSE(ReadBinvox(empty_run).ok());
}

// A wall at 2 m that leans to the right, with the object's mask in its middle and a nearer pole
// before it.
ObjectView LeaningWall() {
  ObjectView view;
  view.camera = {120, 90, 110, 110, 59.5, 44.5};
  view.depth_crop_m = DepthImage(120, 90, 0.0F);
  view.mask_crop = Mask(120, 90, 0);
  const Eigen::Vector3d normal = Eigen::Vector3d(-0.5, 0, -1).normalized();
  for (int v = 0; v < 90; ++v) {
    for (int u = 0; u < 120; ++u) {
      const double depth = -2.0 / view.camera.Ray(u, v).dot(normal) * std::abs(normal.z());
      view.depth_crop_m(u, v) = u == 60 ? 1.0F : static_cast<float>(depth);
      view.mask_crop(u, v) = u > 20 && u < 100 && v > 10 && v < 80 ? 1 : 0;
    }
  }
  return view;
}

TEST(ExtractViewPoints, GivesTheWallsNormalAndLeavesEdgesOut) {
  const ViewPoints points = ExtractViewPoints(LeaningWall(), 500);
  ASSERT_GT(points.points_camera.size(), 200U);
  ASSERT_EQ(points.points_camera.size(), points.normals_camera.size());
  EXPECT_LE(points.points_camera.size(), 500U);
  const Eigen::Vector3f normal = Eigen::Vector3f(-0.5F, 0, -1).normalized();
  for (std::size_t n = 0; n < points.points_camera.size(); ++n) {
    EXPECT_GT(points.points_camera[n].z(), 1.2F) << "the pole's pixels are edges";
    EXPECT_GT(points.normals_camera[n].dot(normal), 0.999F);
  }
}

TEST(ExtractViewPoints, SpreadsEvenlyInSpace) {
  const ViewPoints points = ExtractViewPoints(LeaningWall(), 300);
  // The wall's far end has fewer pixels per area; halves of equal area must hold similar counts.
  float x_min = 1e9F;
  float x_max = -1e9F;
  for (const Eigen::Vector3f& p : points.points_camera) {
    x_min = std::min(x_min, p.x());
    x_max = std::max(x_max, p.x());
  }
  int left = 0;
  int right = 0;
  for (const Eigen::Vector3f& p : points.points_camera) {
    // The seen height grows with the distance: compare per height.
    if (std::abs(p.y()) > 0.4F) continue;
    (p.x() < 0.5F * (x_min + x_max) ? left : right) += 1;
  }
  EXPECT_NEAR(static_cast<double>(left) / right, 1.0, 0.4);
}

TEST(ExtractViewPoints, BadViewsGiveNothing) {
  ObjectView view = LeaningWall();
  EXPECT_TRUE(ExtractViewPoints(view, 0).points_camera.empty());
  EXPECT_TRUE(ExtractViewPoints(view, -5).points_camera.empty());
  EXPECT_TRUE(ExtractViewPoints(ObjectView(), 100).points_camera.empty());
  EXPECT_LE(ExtractViewPoints(view, 1).points_camera.size(), 1U);
  view.mask_crop = Mask(3, 3, 1);
  EXPECT_TRUE(ExtractViewPoints(view, 100).points_camera.empty());
  view = LeaningWall();
  for (float& depth : view.depth_crop_m) depth = std::nanf("");
  EXPECT_TRUE(ExtractViewPoints(view, 100).points_camera.empty());
}

}  // namespace
}  // namespace deepslam::shape

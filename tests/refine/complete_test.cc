#include "deepslam/refine/complete.h"

#include <cmath>
#include <functional>
#include <limits>
#include <numbers>
#include <optional>
#include <set>
#include <vector>

#include <gtest/gtest.h>

#include "deepslam/scene/voxel_grid.h"
#include "deepslam/shape/small_components.h"
#include "deepslam/shape/stretch.h"
#include "support/staged_views.h"
#include "support/voxel_shapes.h"

namespace deepslam::refine {
namespace {

// Voxel coordinates count from the grid's centre, as in support/voxel_shapes.h.
class CompleteModelTest : public testing::Test {
 protected:
  using Shape = std::function<bool(double, double, double)>;

  static bool SeatAndBack(double x, double y, double z) {
    const bool seat = std::abs(x) < 16 && std::abs(y) < 16 && std::abs(z) < 2;
    return seat || (x > -16 && x < -12 && std::abs(y) < 16 && z > 0 && z < 31);
  }
  static bool OnLegs(double x, double y, double z) {
    const bool leg = std::abs(std::abs(x) - 14) < 2 && std::abs(std::abs(y) - 14) < 2;
    return SeatAndBack(x, y, z) || (leg && z < 0 && z > -31);
  }
  static bool OnPedestal(double x, double y, double z) {
    return SeatAndBack(x, y, z) || (std::abs(x) < 8 && std::abs(y) < 8 && z < 0 && z > -31);
  }

  // Completes `model` by views of `thing`, from all round or the front alone.
  std::optional<CompletedModel> Complete(const Shape& model, const Shape& thing, int num_views) {
    return CompleteFrom(model, thing, num_views, 0);
  }
  std::optional<CompletedModel> CompleteFrom(const Shape& model,
                                             const Shape& thing,
                                             int num_views,
                                             double elevation_rad) {
    std::vector<double> azimuths_rad;
    for (int n = 0; n < num_views; ++n)
      azimuths_rad.push_back(2 * std::numbers::pi * n / num_views);
    return CompleteFrom(model, thing, azimuths_rad, elevation_rad);
  }
  std::optional<CompletedModel> CompleteFrom(const Shape& model,
                                             const Shape& thing,
                                             const std::vector<double>& azimuths_rad,
                                             double elevation_rad) {
    const shape::ShapeModel seen(testing_support::FillGrid(thing));
    std::vector<testing_support::Staged> staged;
    for (const double azimuth_rad : azimuths_rad)
      staged.push_back(testing_support::LookAt(seen, azimuth_rad, elevation_rad));
    std::vector<PlacedView> placed;
    for (const auto& view : staged) placed.push_back({&view.view, view.camera_from_grid});
    return CompleteModel(
        shape::ShapeModel(testing_support::FillGrid(model)), placed, options_, limits_);
  }

  static bool At(const CompletedModel& model, int x, int y, int z) {
    return model.grid.At(x + kGridSize / 2, y + kGridSize / 2, z + kGridSize / 2);
  }
  // The longest side, in units of the model that was completed.
  static double Extent(const CompletedModel& model) {
    return kModelExtent * model.model_from_grid.scale;
  }
  static double IoU(const CompletedModel& model, const Shape& thing) {
    return shape::GridIntersectionOverUnion(model.grid, testing_support::FillGrid(thing));
  }

  // The grid follows the floor, so that voxels can be compared with those of the things.
  RefineOptions options_{.follow_level_face = false};
  Limits limits_;
};

TEST_F(CompleteModelTest, TheThingItselfStaysAsItIs) {
  const auto completed = Complete(OnLegs, OnLegs, 12);
  ASSERT_TRUE(completed);
  EXPECT_GT(IoU(*completed, OnLegs), 0.9);
  EXPECT_NEAR(Extent(*completed), kModelExtent, 1.01 * kVoxelSize);
}

TEST_F(CompleteModelTest, AnotherDesignBecomesTheThingThatWasSeen) {
  const auto completed = Complete(OnPedestal, OnLegs, 12);
  ASSERT_TRUE(completed);
  EXPECT_FALSE(At(*completed, 0, 0, -20)) << "rays go through the pedestal";
  EXPECT_TRUE(At(*completed, 14, 14, -20)) << "and end on a leg";
  EXPECT_GT(IoU(*completed, OnLegs), 0.85);
}

TEST_F(CompleteModelTest, SidesThatNobodySawAreTheModels) {
  const Shape model = [](double x, double y, double z) {
    return std::abs(x) < 10 && std::abs(y) < 10 && std::abs(z) < 31;
  };
  const Shape thing = [](double x, double y, double z) {
    return x > -20 && x < 14 && std::abs(y) < 10 && std::abs(z) < 31;
  };
  const auto completed = Complete(model, thing, 1);
  ASSERT_TRUE(completed);
  EXPECT_TRUE(At(*completed, 11, 0, 0)) << "measured";
  EXPECT_TRUE(At(*completed, -9, 0, 0)) << "the model's";
  EXPECT_FALSE(At(*completed, -14, 0, 0)) << "neither";
  // Measured up to 14 voxels: what is centred in the grid lies 2 voxels beside the model's middle.
  EXPECT_NEAR(completed->model_from_grid.translation_m.x() / kVoxelSize, 2, 1.1);
  EXPECT_NEAR(completed->model_from_grid.translation_m.y() / kVoxelSize, 0, 1.1);
}

TEST_F(CompleteModelTest, WhatWasMeasuredBeyondTheSidesIsOfSomethingElse) {
  const Shape model = [](double x, double y, double z) {
    return std::abs(x) < 10 && std::abs(y) < 10 && std::abs(z) < 31;
  };
  const Shape thing = [&](double x, double y, double z) {
    return model(x, y, z) || (x > 0 && x < 14 && std::abs(y) < 10 && std::abs(z) < 5);
  };
  const auto without = Complete(model, thing, 12);
  limits_.sides = {{-Eigen::Vector3d::UnitX(), 10 * kVoxelSize}};
  const auto completed = Complete(model, thing, 12);
  ASSERT_TRUE(without && completed);
  EXPECT_NEAR(OccupiedBox(without->grid)->sides().x(), 24, 1);
  EXPECT_NEAR(OccupiedBox(completed->grid)->sides().x(), 20, 1);
}

// Nothing was measured below the top, where the model is wider than the top.
TEST_F(CompleteModelTest, WhatCarriesATopDoesNotReachBeyondTheSidesThatWereSeen) {
  const Shape top = [](double x, double y, double z) {
    return std::abs(x) < 14 && std::abs(y) < 14 && z > 25 && z < 31;
  };
  const Shape model = [&](double x, double y, double z) {
    return top(x, y, z) || (std::abs(x) < 24 && std::abs(y) < 10 && z < 26 && z > -31);
  };
  const shape::ShapeModel seen(testing_support::FillGrid(top));
  std::vector<testing_support::Staged> staged;
  for (int n = 0; n < 12; ++n) {
    staged.push_back(testing_support::LookAt(seen, 2 * std::numbers::pi * n / 12, 0.4));
    DepthImage& depth_m = staged.back().view.depth_crop_m;
    for (int v = 95; v < depth_m.height(); ++v) std::fill_n(depth_m.row(v), depth_m.width(), 0.0F);
  }
  std::vector<PlacedView> placed;
  for (const auto& view : staged) placed.push_back({&view.view, view.camera_from_grid});
  for (const double sign : {-1.0, 1.0}) {
    limits_.sides.push_back({sign * Eigen::Vector3d::UnitX(), 14 * kVoxelSize});
    limits_.sides.push_back({sign * Eigen::Vector3d::UnitY(), 14 * kVoxelSize});
  }
  const shape::ShapeModel wide(testing_support::FillGrid(model));
  const auto without = CompleteModel(wide, placed, options_, limits_);
  limits_.top = Plane{-Eigen::Vector3d::UnitZ(), 31 * kVoxelSize};
  const auto completed = CompleteModel(wide, placed, options_, limits_);
  ASSERT_TRUE(without && completed);
  EXPECT_NEAR(OccupiedBox(without->grid)->sides().x(), 48, 2);
  EXPECT_NEAR(OccupiedBox(completed->grid)->sides().x(), 30, 3);
}

// A cupboard at a wall, seen from the front: the model is deeper than the room behind it.
TEST_F(CompleteModelTest, NothingReachesThroughAWall) {
  const Shape model = [](double x, double y, double z) {
    return std::abs(x) < 28 && std::abs(y) < 10 && std::abs(z) < 31;
  };
  const std::vector<double> front = {-0.4, 0.0, 0.4};
  const auto without = CompleteFrom(model, model, front, 0);
  ASSERT_TRUE(without);
  EXPECT_TRUE(At(*without, -20, 0, 0)) << "the model's";
  limits_.walls = {{Eigen::Vector3d::UnitX(), 10 * kVoxelSize}};
  const auto completed = CompleteFrom(model, model, front, 0);
  ASSERT_TRUE(completed);
  // Centred anew: 38 of 56 voxels are left.
  EXPECT_NEAR(OccupiedBox(completed->grid)->sides().x() / 62.0, 38.0 / 62.0, 0.05);
  EXPECT_NEAR(Extent(*completed), Extent(*without), 0.03) << "it is as high as it was";
}

TEST_F(CompleteModelTest, AWallThatTheThingWasMeasuredBehindIsNoneOfIts) {
  const Shape thing = [](double x, double y, double z) {
    return std::abs(x) < 28 && std::abs(y) < 10 && std::abs(z) < 31;
  };
  const auto without = Complete(thing, thing, 12);
  limits_.walls = {{Eigen::Vector3d::UnitX(), 10 * kVoxelSize}};
  const auto completed = Complete(thing, thing, 12);
  ASSERT_TRUE(without && completed);
  EXPECT_EQ(completed->grid.occupied, without->grid.occupied);
}

TEST_F(CompleteModelTest, AWallThatMostOfTheModelIsBehindIsNoneOfIts) {
  const Shape thing = [](double x, double y, double z) {
    return std::abs(x) < 28 && std::abs(y) < 10 && std::abs(z) < 31;
  };
  const std::vector<double> front = {-0.4, 0.0, 0.4};
  const auto without = CompleteFrom(thing, thing, front, 0);
  limits_.walls = {{Eigen::Vector3d::UnitX(), -10 * kVoxelSize}};
  const auto completed = CompleteFrom(thing, thing, front, 0);
  ASSERT_TRUE(without && completed);
  EXPECT_EQ(completed->grid.occupied, without->grid.occupied);
}

TEST_F(CompleteModelTest, LegsTooThinToBeMeasuredAreTheModels) {
  const Shape top = [](double x, double y, double z) {
    return std::abs(x) < 20 && std::abs(y) < 20 && z > 25 && z < 31;
  };
  const Shape table = [&](double x, double y, double z) {
    const bool leg = std::abs(std::abs(x) - 18) < 1.1 && std::abs(std::abs(y) - 18) < 1.1;
    return top(x, y, z) || (leg && z < 26 && z > -31);
  };
  const auto completed = Complete(table, top, 12);
  ASSERT_TRUE(completed);
  EXPECT_GT(IoU(*completed, table), 0.9);
}

TEST_F(CompleteModelTest, LegsThatSegmentationMissedAreNotCarvedAway) {
  const Shape table = [](double x, double y, double z) {
    const bool leg = std::abs(std::abs(x) - 18) < 1.1 && std::abs(std::abs(y) - 18) < 1.1;
    return (std::abs(x) < 20 && std::abs(y) < 20 && z > 25 && z < 31) || (leg && z < 26 && z > -31);
  };
  const shape::ShapeModel thing(testing_support::FillGrid(table));
  std::vector<testing_support::Staged> staged;
  for (int n = 0; n < 12; ++n)
    staged.push_back(testing_support::LookAt(thing, 2 * std::numbers::pi * n / 12));
  std::vector<PlacedView> placed;
  for (std::size_t n = 0; n < staged.size(); ++n) {
    ObjectView& view = staged[n].view;
    const Similarity3 grid_from_camera = staged[n].camera_from_grid.Inverse();
    for (int v = 0; v < view.mask_crop.height(); ++v) {
      for (int u = 0; u < view.mask_crop.width(); ++u) {
        const double depth_m = view.depth_crop_m(u, v);
        const Eigen::Vector3d p = grid_from_camera * (depth_m * view.camera.Ray(u, v));
        if (p.x() > 0 && p.z() < 0.35) view.mask_crop(u, v) = 0;
      }
    }
    placed.push_back({&view, staged[n].camera_from_grid});
    // A few views see past the legs, for being out of place.
    if (n % 4 == 1)
      placed.back().camera_from_grid.translation_m.x() += 0.06 * testing_support::kStagedSizeM;
  }
  const auto completed = CompleteModel(thing, placed, options_);
  ASSERT_TRUE(completed);
  EXPECT_GT(IoU(*completed, table), 0.92);
}

TEST_F(CompleteModelTest, LegsOfWhichRaysMissAPieceHangOnTheThingAgain) {
  // Rings of chrome round the legs, whose depth is that of what is behind.
  const Shape without_rings = [](double x, double y, double z) {
    return OnLegs(x, y, z) && !(z > -12 && z < -4);
  };
  const auto completed = Complete(OnLegs, without_rings, 12);
  ASSERT_TRUE(completed);
  for (const int x : {-15, 14}) {
    for (const int y : {-15, 14}) EXPECT_TRUE(At(*completed, x, y, -20)) << x << " " << y;
  }
  EXPECT_EQ(shape::PartsOf(completed->grid, 1).size(), 1U);
  EXPECT_GT(IoU(*completed, OnLegs), 0.85);
}

// Heights of the grid's topmost voxels, but for those near the rim.
std::set<int> HeightsOfTop(const VoxelGrid& grid) {
  constexpr int kRim = 5;
  const std::optional<VoxelBox> box = OccupiedBox(grid);
  std::set<int> heights;
  for (int i = box->low.x() + kRim; i <= box->high.x() - kRim; ++i) {
    for (int j = box->low.y() + kRim; j <= box->high.y() - kRim; ++j) {
      int k = kGridSize - 1;
      while (k >= 0 && !grid.At(i, j, k)) --k;
      heights.insert(k);
    }
  }
  return heights;
}

// Views of a board that lies a degree tilted in the model's axes: its face passes from one layer of
// a grid that follows the floor into the next.
TEST_F(CompleteModelTest, ALevelFaceIsOneLayerOfVoxelsWithoutAStep) {
  const shape::ShapeModel board(testing_support::FillGrid([](double x, double y, double z) {
    return std::abs(x) < 31 && std::abs(y) < 20 && std::abs(z) < 3;
  }));
  const Similarity3 board_from_model{
      1, Eigen::Quaterniond(Eigen::AngleAxisd(0.015, Eigen::Vector3d::UnitY())), {0, 0, -0.004}};
  std::vector<testing_support::Staged> staged;
  for (int n = 0; n < 8; ++n)
    staged.push_back(testing_support::LookAt(board, 2 * std::numbers::pi * n / 8, 0.6));
  std::vector<PlacedView> placed;
  for (const auto& view : staged)
    placed.push_back({&view.view, view.camera_from_grid * board_from_model});
  const auto on_floor = CompleteModel(board, placed, options_);
  options_.follow_level_face = true;
  const auto on_face = CompleteModel(board, placed, options_);
  ASSERT_TRUE(on_floor && on_face);
  EXPECT_GT(HeightsOfTop(on_floor->grid).size(), 1U);
  EXPECT_EQ(HeightsOfTop(on_face->grid).size(), 1U);
}

TEST_F(CompleteModelTest, WhatLiesFarFromTheModelIsOfSomethingElse) {
  const Shape model = [](double x, double y, double z) {
    return std::abs(x) < 6 && std::abs(y) < 6 && std::abs(z) < 31;
  };
  const Shape with_another = [&](double x, double y, double z) {
    return model(x, y, z) || (std::abs(x) < 6 && y > 23 && y < 29 && std::abs(z) < 31);
  };
  const double voxel_m = testing_support::kStagedSizeM * kVoxelSize;
  options_.reach_m = 12 * voxel_m;  // the other begins 17 voxels off
  const auto alone = Complete(model, with_another, 12);
  options_.reach_m = 30 * voxel_m;
  const auto both = Complete(model, with_another, 12);
  ASSERT_TRUE(alone && both);
  EXPECT_FALSE(At(*alone, 0, 26, 0));
  EXPECT_NEAR(IoU(*alone, model), IoU(*Complete(model, model, 12), model), 0.02);
  EXPECT_GT(testing_support::CountOccupied(both->grid),
            1.3 * testing_support::CountOccupied(alone->grid));
}

TEST_F(CompleteModelTest, LargerThingsMakeLargerModels) {
  const Shape model = [](double x, double y, double z) {
    return std::abs(x) < 12 && std::abs(y) < 31 && std::abs(z) < 20;
  };
  const Shape longer = [](double x, double y, double z) {
    return std::abs(x) < 12 && std::abs(y) < 38 && std::abs(z) < 20;
  };
  // Longer than a grid: the thing is staged by half its size and the model twice as near.
  const Shape half = [&](double x, double y, double z) { return longer(2 * x, 2 * y, 2 * z); };
  const shape::ShapeModel seen(testing_support::FillGrid(half));
  std::vector<testing_support::Staged> staged;
  for (int n = 0; n < 12; ++n)
    staged.push_back(testing_support::LookAt(seen, 2 * std::numbers::pi * n / 12));
  std::vector<PlacedView> placed;
  for (auto& view : staged) {
    view.camera_from_grid.scale *= 0.5;
    placed.push_back({&view.view, view.camera_from_grid});
  }
  const auto completed =
      CompleteModel(shape::ShapeModel(testing_support::FillGrid(model)), placed, options_);
  ASSERT_TRUE(completed);
  EXPECT_NEAR(Extent(*completed) / kVoxelSize, 76, 4);
}

TEST_F(CompleteModelTest, ThingsALittleLargerComeInAGridOfTheirOwn) {
  const Shape board = [](double x, double y, double z) {
    return std::abs(x) < 15 && std::abs(y) < 30 && z > 0 && z < 2;
  };
  const shape::ShapeModel thing(testing_support::FillGrid(board));
  for (const double factor : {0.97, 1.01, 1.03, 1.06}) {
    std::vector<testing_support::Staged> staged;
    for (int n = 0; n < 12; ++n)
      staged.push_back(testing_support::LookAt(thing, 2 * std::numbers::pi * n / 12));
    std::vector<PlacedView> placed;
    for (auto& view : staged) {
      view.camera_from_grid.scale /= factor;  // the model is that much smaller than the thing
      placed.push_back({&view.view, view.camera_from_grid});
    }
    const auto completed = CompleteModel(thing, placed, options_);
    ASSERT_TRUE(completed);
    EXPECT_EQ(OccupiedBox(completed->grid)->sides().maxCoeff(), 62);
    EXPECT_NEAR(Extent(*completed) / kVoxelSize, 60 * factor, 1.6) << "half a voxel at either end";
  }
}

TEST_F(CompleteModelTest, AThickTopBecomesAsThinAsItsEdgeShows) {
  const auto table = [](double thickness) {
    return [=](double x, double y, double z) {
      const bool leg = std::abs(std::abs(x) - 28) < 2 && std::abs(std::abs(y) - 18) < 2;
      const bool top = std::abs(x) < 30 && std::abs(y) < 20 && z > 15 - thickness && z < 15;
      return top || (leg && z < 15 && z > -15);
    };
  };
  // No view from below: nobody sees the underside.
  const auto completed = CompleteFrom(table(10), table(3), 12, 0.5);
  ASSERT_TRUE(completed);
  EXPECT_TRUE(At(*completed, 0, 0, 13));
  EXPECT_FALSE(At(*completed, 0, 0, 8)) << "the model's, which rays passed below";
  EXPECT_GT(IoU(*completed, table(3)), 0.65) << "a layer of voxels is a third of it";
}

TEST_F(CompleteModelTest, ABodyThatIsTooWideIsNoHollowOne) {
  const auto chest = [](double half_width) {
    return [=](double x, double y, double z) {
      return std::abs(x) < 14 && std::abs(y) < half_width && std::abs(z) < 31;
    };
  };
  const auto completed = CompleteFrom(chest(26), chest(20), 12, 0.5);
  ASSERT_TRUE(completed);
  for (const int z : {-25, -10, 0, 10, 25}) EXPECT_TRUE(At(*completed, 0, 0, z)) << z;
  EXPECT_GT(IoU(*completed, chest(20)), 0.85);
}

TEST_F(CompleteModelTest, ASideThatNobodySawIsLikeTheOtherOne) {
  // A bench; the views show its front, its top and one end, of which the model has no arm rest.
  const auto bench = [](bool has_arms) {
    return [=](double x, double y, double z) {
      const bool seat = std::abs(x) < 12 && std::abs(y) < 31 && z > -15 && z < 0;
      const bool back = x > -12 && x < -8 && std::abs(y) < 31 && z > -15 && z < 15;
      const bool arm = std::abs(x) < 12 && std::abs(y) > 26 && std::abs(y) < 31 && z > -15 && z < 8;
      return seat || back || (has_arms && arm);
    };
  };
  const std::vector<double> from_front_right = {-0.2, 0, 0.2, 0.5, 0.8, 1.1};
  const auto completed = CompleteFrom(bench(false), bench(true), from_front_right, 0.5);
  ASSERT_TRUE(completed);
  // The arm's inner side shows, its outer one is hidden.
  EXPECT_TRUE(At(*completed, 0, 28, 4));
  EXPECT_TRUE(At(*completed, 0, -28, 4));
}

// A design whose top is a frame; the thing has a whole top, and a crate that is none of it on its
// middle.
TEST_F(CompleteModelTest, WhatStandsOnATopMakesNoHoleInIt) {
  constexpr double kTopZ = 14;
  const auto is_middle = [](double x, double y) { return std::abs(x) < 5 && std::abs(y) < 5; };
  const Shape top = [](double x, double y, double z) {
    return std::abs(x) < 31 && std::abs(y) < 22 && z > 10 && z < kTopZ;
  };
  const Shape frame = [&](double x, double y, double z) {
    return top(x, y, z) && !is_middle(x, y);
  };
  const Shape loaded = [&](double x, double y, double z) {
    return top(x, y, z) || (is_middle(x, y) && z >= kTopZ && z < 22);
  };
  const shape::ShapeModel seen(testing_support::FillGrid(loaded));
  std::vector<testing_support::Staged> staged;
  for (int n = 0; n < 8; ++n)
    staged.push_back(testing_support::LookAt(seen, 2 * std::numbers::pi * n / 8, 0.6));
  std::vector<PlacedView> placed;
  for (auto& [view, camera_from_grid] : staged) {
    const Similarity3 grid_from_camera = camera_from_grid.Inverse();
    for (int v = 0; v < view.mask_crop.height(); ++v) {
      for (int u = 0; u < view.mask_crop.width(); ++u) {
        const double depth_m = view.depth_crop_m(u, v);
        const Eigen::Vector3d p = grid_from_camera * (depth_m * view.camera.Ray(u, v));
        if (p.z() > (kTopZ + 1) * kVoxelSize) view.mask_crop(u, v) = 0;
      }
    }
    placed.push_back({&view, camera_from_grid});
  }
  const auto completed =
      CompleteModel(shape::ShapeModel(testing_support::FillGrid(frame)), placed, options_);
  ASSERT_TRUE(completed);
  const std::optional<VoxelBox> box = OccupiedBox(completed->grid);
  const Eigen::Array3i middle = (box->low + box->high) / 2;
  bool is_filled = false;
  for (int k = box->low.z(); k <= box->high.z(); ++k)
    is_filled |= completed->grid.At(middle.x(), middle.y(), k);
  EXPECT_TRUE(is_filled);
}

TEST_F(CompleteModelTest, NothingWithoutModelOrViews) {
  const Shape nothing = [](double, double, double) { return false; };
  EXPECT_FALSE(Complete(nothing, OnLegs, 4));
  EXPECT_FALSE(Complete(OnLegs, OnLegs, 0));
  auto staged = testing_support::LookAt(shape::ShapeModel(testing_support::FillGrid(OnLegs)), 0);
  const shape::ShapeModel model(testing_support::FillGrid(OnLegs));
  std::vector<PlacedView> placed = {{&staged.view, staged.camera_from_grid}};
  placed[0].camera_from_grid.scale = std::numeric_limits<double>::quiet_NaN();
  EXPECT_FALSE(CompleteModel(model, placed, options_));
  placed[0].camera_from_grid = staged.camera_from_grid;
  staged.view.mask_crop = Mask(3, 3);
  EXPECT_FALSE(CompleteModel(model, placed, options_));
}

}  // namespace
}  // namespace deepslam::refine

#include "deepslam/refine/grid_around.h"

#include <cmath>
#include <numbers>
#include <vector>

#include <gtest/gtest.h>

#include "support/staged_views.h"
#include "support/voxel_shapes.h"

namespace deepslam::refine {
namespace {

constexpr double kReach = 0.2;

shape::ShapeModel Box(double half_x, double half_y, double half_z) {
  return shape::ShapeModel(testing_support::FillGrid([=](double x, double y, double z) {
    return std::abs(x) < half_x && std::abs(y) < half_y && std::abs(z) < half_z;
  }));
}

// Voxels from the lower border of layer 0 to the height `z`.
double LayersBelow(const Similarity3& object_from_grid, double z) {
  return (z - object_from_grid.translation_m.z()) / (object_from_grid.scale * kVoxelSize) +
         0.5 * kGridSize;
}

bool IsWhole(double value) { return std::abs(value - std::round(value)) < 1e-6; }

TEST(GridAroundTest, ModelsOwnGridWhereNothingLiesOutside) {
  const shape::ShapeModel model = Box(10, 20, 31);
  const auto staged = testing_support::LookAt(model, 0.3);
  const std::vector<PlacedView> views = {{&staged.view, staged.camera_from_grid}};
  const Similarity3 grid = GridAround({model, views, kReach});
  EXPECT_EQ(grid.scale, 1);
  EXPECT_LT(grid.translation_m.norm(), 1e-9);
}

TEST(GridAroundTest, HoldsWhatWasMeasuredBesideTheModel) {
  const shape::ShapeModel thing = Box(10, 31, 20);
  std::vector<testing_support::Staged> staged;
  for (int n = 0; n < 8; ++n)
    staged.push_back(testing_support::LookAt(thing, 2 * std::numbers::pi * n / 8));
  std::vector<PlacedView> views;
  for (auto& view : staged) {
    view.camera_from_grid.scale /= 1.2;  // the model is that much smaller than the thing
    views.push_back({&view.view, view.camera_from_grid});
  }
  const Similarity3 grid = GridAround({thing, views, kReach});
  EXPECT_GT(grid.scale, 1.15);
  EXPECT_LT(grid.scale, 1.25);
  EXPECT_TRUE(IsWhole(LayersBelow(grid, thing.bottom())));
}

TEST(GridOverTest, LongestSideIsTheModelsAndALayerBeginsAtTheFloor) {
  const Similarity3 grid{1.07, Eigen::Quaterniond::Identity(), {0.02, -0.01, 0.013}};
  const shape::ShapeModel thing = Box(10, 20, 20);
  const double floor = thing.bottom();
  for (const int longest : {40, 61, 63, 64}) {
    const VoxelBox box = {{20, 0, 10}, {30, longest - 1, 29}};
    EXPECT_FALSE(IsOfModelSize(box));
    const Similarity3 over = GridOver(box, grid, {thing, {}, kReach});
    // The outermost voxels of `box` may be nearly empty.
    EXPECT_NEAR(over.scale / grid.scale * 62, longest, 0.51);
    EXPECT_TRUE(IsWhole(LayersBelow(over, floor)));
    const Eigen::Vector3d middle =
        over.Inverse() *
        (grid * (0.5 * (VoxelGrid::Center(20, 0, 10) + VoxelGrid::Center(30, longest - 1, 29))));
    EXPECT_LT(middle.cwiseAbs().maxCoeff(), 0.51 * kVoxelSize);
  }
  EXPECT_TRUE(IsOfModelSize({{0, 1, 0}, {9, 62, 9}}));
}

// Views of a board, moved and tilted against the model's axes: the end of a layer follows the
// board.
TEST(GridAroundTest, ALayerEndsAtALevelFace) {
  const shape::ShapeModel board = Box(31, 20, 3);
  for (const double tilt_rad : {0.0, 0.01}) {
    const Similarity3 model_from_board{
        1,
        Eigen::Quaterniond(Eigen::AngleAxisd(tilt_rad, Eigen::Vector3d::UnitY())),
        {0, 0, 0.004}};
    std::vector<testing_support::Staged> staged;
    for (int n = 0; n < 6; ++n)
      staged.push_back(testing_support::LookAt(board, 2 * std::numbers::pi * n / 6, 0.6));
    std::vector<PlacedView> views;
    for (const auto& view : staged)
      views.push_back({&view.view, view.camera_from_grid * model_from_board.Inverse()});
    const Similarity3 grid = GridAround({board, views, kReach, true});
    for (const double x : {-0.4, 0.0, 0.4}) {
      const Eigen::Vector3d on_face(x, 0, 3 * kVoxelSize);
      const double layers =
          (grid.Inverse() * (model_from_board * on_face)).z() / kVoxelSize + 0.5 * kGridSize;
      EXPECT_NEAR(layers, std::round(layers), 0.2) << tilt_rad << " " << x;
    }
  }
}

}  // namespace
}  // namespace deepslam::refine

#include "deepslam/priors/training_view.h"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <vector>

#include <gtest/gtest.h>
#include <Eigen/Geometry>

#include "deepslam/furniture/design.h"
#include "deepslam/priors/contact_sheet.h"
#include "deepslam/shape/voxelize.h"

namespace deepslam::priors {
namespace {

FurnitureMesh Chair(std::uint64_t number) {
  furniture::Design design =
      furniture::MakeDesign(furniture::Kind::kChair, Random(3, "view test", number));
  return {std::move(design.mesh), std::move(design.material_of_face)};
}

FurnitureMesh SignedBox() {
  FurnitureMesh box;
  for (int n = 0; n < 8; ++n)
    box.mesh.vertices.emplace_back(
        n & 1 ? 0.4F : -0.4F, n & 2 ? 0.3F : -0.3F, n & 4 ? 0.5F : -0.5F);
  box.mesh.faces = {{1, 3, 7},
                    {1, 7, 5},
                    {0, 4, 6},
                    {0, 6, 2},
                    {2, 6, 7},
                    {2, 7, 3},
                    {0, 1, 5},
                    {0, 5, 4},
                    {4, 5, 7},
                    {4, 7, 6},
                    {0, 2, 3},
                    {0, 3, 1}};
  return box;
}

bool Same(const TrainingView& a, const TrainingView& b) {
  return a.crop.colour == b.crop.colour && a.crop.depth == b.crop.depth &&
         a.crop.silhouette == b.crop.silhouette && a.crop.height == b.crop.height &&
         a.sketch.depth == b.sketch.depth && a.sketch.normal == b.sketch.normal &&
         a.azimuth_rad == b.azimuth_rad;
}

TEST(TrainingViewTest, SeedMakesTheView) {
  const Result<ViewRenderer> renderer = ViewRenderer::Make(Chair(1));
  ASSERT_TRUE(renderer);
  const TrainingView a = renderer->Render(Random(1, "a", 0), {});
  EXPECT_TRUE(Same(a, renderer->Render(Random(1, "a", 0), {})));
  EXPECT_FALSE(Same(a, renderer->Render(Random(1, "a", 1), {})));
}

// The normals of the side that the camera stands on point at the camera: by them the azimuth that
// is said is the one that is seen.
TEST(TrainingViewTest, AzimuthIsThatOfTheCamera) {
  const Result<ViewRenderer> renderer = ViewRenderer::Make(SignedBox());
  ASSERT_TRUE(renderer);
  int told = 0;
  for (std::uint64_t n = 0; n < 40; ++n) {
    const TrainingView view = renderer->Render(Random(5, "azimuth", n), {false});
    EXPECT_GT(view.azimuth_rad, -std::numbers::pi - 1e-9);
    EXPECT_LE(view.azimuth_rad, std::numbers::pi + 1e-9);
    const double quarter = std::numbers::pi / 2;
    const double turn = view.azimuth_rad - quarter * std::round(view.azimuth_rad / quarter);
    if (std::abs(turn) < 0.3 || std::abs(turn) > 0.6) continue;
    // Standing before a side and then going counter-clockwise one comes to see the next side, on
    // the right: of the two its normal points more to the side.
    double farthest = 0;
    for (const Rgb8& normal : view.sketch.normal) {
      const double x = (normal.r - 128.0) / 127.0;
      const double y = (normal.g - 128.0) / 127.0;
      if (std::abs(y) < 0.75 && std::abs(x) > std::abs(farthest)) farthest = x;
    }
    EXPECT_EQ(farthest > 0, turn > 0) << n << " " << view.azimuth_rad;
    ++told;
  }
  EXPECT_GE(told, 8);
}

TEST(TrainingViewTest, CleanViewsShowTheWholeObject) {
  const Result<ViewRenderer> renderer = ViewRenderer::Make(Chair(2));
  ASSERT_TRUE(renderer);
  for (std::uint64_t n = 0; n < 10; ++n) {
    const TrainingView view = renderer->Render(Random(2, "clean", n), {false});
    EXPECT_DOUBLE_EQ(view.visible, 1.0);
    int differ = 0;
    int object = 0;
    for (int y = 0; y < kSketchSide; ++y) {
      for (int x = 0; x < kSketchSide; ++x) {
        const bool truth = view.sketch.silhouette(x, y) != 0;
        const int share =
            view.crop.silhouette(2 * x, 2 * y) + view.crop.silhouette(2 * x + 1, 2 * y) +
            view.crop.silhouette(2 * x, 2 * y + 1) + view.crop.silhouette(2 * x + 1, 2 * y + 1);
        const bool crop = share > 2 * 255;
        object += truth ? 1 : 0;
        differ += truth != crop ? 1 : 0;
      }
    }
    EXPECT_GT(object, 200);
    EXPECT_LT(differ, object / 5) << "crop and truth lie in one square";
  }
}

TEST(TrainingViewTest, DepthAgreesWithTheTruthBehindIt) {
  const Result<ViewRenderer> renderer = ViewRenderer::Make(Chair(3));
  ASSERT_TRUE(renderer);
  double worst_median = 0;
  for (std::uint64_t n = 0; n < 20; ++n) {
    const TrainingView view = renderer->Render(Random(4, "depth", n), {true});
    std::vector<double> apart;
    for (int y = 0; y < kSketchSide; ++y) {
      for (int x = 0; x < kSketchSide; ++x) {
        const int measured = view.crop.depth(2 * x, 2 * y);
        const int truth = view.sketch.depth(x, y);
        if (measured != 0 && truth != 0) apart.push_back(std::abs(measured - truth));
      }
    }
    ASSERT_FALSE(apart.empty()) << n;
    std::nth_element(
        apart.begin(), apart.begin() + static_cast<std::ptrdiff_t>(apart.size() / 2), apart.end());
    worst_median = std::max(worst_median, apart[apart.size() / 2]);
  }
  EXPECT_LE(worst_median, 8) << "of 127 steps for the crop's side";
}

TEST(TrainingViewTest, FaultsHideAndEnoughStays) {
  const Result<ViewRenderer> renderer = ViewRenderer::Make(Chair(4));
  ASSERT_TRUE(renderer);
  int spoilt = 0;
  for (std::uint64_t n = 0; n < 30; ++n) {
    const TrainingView view = renderer->Render(Random(6, "faults", n), {});
    EXPECT_GE(view.visible, 0.12);
    spoilt += view.visible < 0.95 ? 1 : 0;
    for (std::size_t p = 0; p < view.crop.colour.size(); ++p) {
      if (view.crop.silhouette.data()[p] == 0) {
        ASSERT_EQ(view.crop.colour.data()[p], (Rgb8{255, 255, 255})) << "white outside";
      }
    }
  }
  EXPECT_GE(spoilt, 10);
}

TEST(TrainingViewTest, TopsShowWhatLiesAboveSomeHeight) {
  const Result<ViewRenderer> renderer = ViewRenderer::Make(Chair(4));
  ASSERT_TRUE(renderer);
  const auto lowest = [](const TrainingView& view) {
    int least = 255;
    for (std::size_t p = 0; p < view.crop.depth.size(); ++p) {
      if (view.crop.depth.data()[p] != 0)
        least = std::min(least, static_cast<int>(view.crop.height.data()[p]));
    }
    return least;  // 10 for the ground, a step for each centimetre
  };
  constexpr int kViews = 20;
  int low = 0;
  for (std::uint64_t n = 0; n < kViews; ++n) {
    const TrainingView top = renderer->Render(Random(8, "tops", n), {true, 1.0});
    EXPECT_GE(lowest(top), 10 + 25) << n << ": half of a chair's height is more than that";
    EXPECT_LT(top.visible, 0.9) << n;
    low += lowest(renderer->Render(Random(8, "tops", n), {})) < 10 + 25 ? 1 : 0;
  }
  EXPECT_GT(low, kViews / 2) << "others reach down";
}

TEST(TrainingViewTest, RefusesWhatIsNoMesh) {
  EXPECT_FALSE(ViewRenderer::Make({}));
  FurnitureMesh wrong = SignedBox();
  wrong.material_of_face = {1};
  EXPECT_FALSE(ViewRenderer::Make(std::move(wrong)));
}

TEST(ContactSheetTest, HasARowPerModel) {
  FurnitureMesh chair = Chair(5);
  const Result<VoxelGrid> shape = shape::Voxelize(chair.mesh);
  const Result<ViewRenderer> renderer = ViewRenderer::Make(std::move(chair));
  ASSERT_TRUE(shape);
  ASSERT_TRUE(renderer);
  const std::vector<SheetRow> rows(2, SheetRow{{renderer->Render(Random(1), {})}, *shape});
  const ColourImage sheet = DrawContactSheet(rows);
  EXPECT_EQ(sheet.height(), 2 * propose::kCropSide);
  EXPECT_EQ(sheet.width(), 8 * propose::kCropSide);
}

}  // namespace
}  // namespace deepslam::priors

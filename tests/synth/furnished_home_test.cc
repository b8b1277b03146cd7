#include "deepslam/synth/furnished_home.h"

#include <algorithm>
#include <cmath>
#include <map>
#include <numbers>
#include <vector>

#include <gmock/gmock.h>

#include "deepslam/geometry/box.h"
#include "deepslam/scene/layout.h"
#include "deepslam/synth/camera_path.h"
#include "deepslam/synth/true_layout.h"
#include "deepslam/synth/world.h"
#include "support/box_meshes.h"
#include "synth/small_world.h"

namespace deepslam::synth {
namespace {

constexpr std::uint64_t kNumSeeds = 16;

// Sizes of each kind as people have them; which piece is which does not matter here.
PieceSizes Sizes() {
  PieceSizes sizes;
  for (const std::string& piece : HomePieces()) {
    Eigen::Vector3d size(0.5, 0.6, 0.9);
    if (piece.find("sofa") != std::string::npos) size = {0.85, 1.8, 0.8};
    if (piece.find("bed") != std::string::npos) size = {2.1, 1.4, 0.9};
    if (piece.find("able") != std::string::npos) size = {0.8, 1.4, 0.74};
    if (piece.find("bedside") != std::string::npos) size = {0.4, 0.45, 0.5};
    if (piece.find("wardrobe") != std::string::npos) size = {0.6, 1.7, 2.0};
    if (piece.find("upper") != std::string::npos) size = {0.35, 0.6, 0.7};
    if (piece.find("tv") != std::string::npos) size = {0.15, 0.5, 0.4};
    sizes[piece] = size;
  }
  return sizes;
}

// Boxes of these sizes.
std::map<std::string, FurnitureModel> Models(const PieceSizes& sizes) {
  std::map<std::string, FurnitureModel> models;
  for (const auto& [piece, size] : sizes) {
    FurnitureModel model;
    model.mesh = testing_support::BoxMesh(size.cast<float>());
    model.mesh.colours.assign(model.mesh.vertices.size(), {150, 100, 60});
    model.size_m = size;
    models.emplace(piece, model);
  }
  return models;
}

// Yaws are multiples of 90 degrees.
Box3 BoxOf(const SceneObject& object, const PieceSizes& sizes) {
  const Eigen::Vector3d& size = sizes.at(object.model);
  const bool turned = std::abs(std::sin(object.yaw_deg * std::numbers::pi / 180)) > 0.5;
  const Eigen::Vector3d half =
      0.5 * Eigen::Vector3d(turned ? size.y() : size.x(), turned ? size.x() : size.y(), size.z());
  const Eigen::Vector3d middle(
      object.position_m.x(), object.position_m.y(), object.bottom_m + half.z());
  return {middle - half, middle + half};
}

bool Overlap(const Box3& a, const Box3& b) {
  return (a.min.array() < b.max.array() - 1e-9).all() &&
         (a.max.array() > b.min.array() + 1e-9).all();
}

// Of the view, from frame to frame.
double FastestTurn_deg(const SceneDescription& home) {
  const std::vector<Pose3> path = CameraPath(home);
  double most = 0;
  for (std::size_t k = 1; k < path.size(); ++k) {
    most = std::max(most, RotationAngle(path[k - 1].rotation.inverse() * path[k].rotation));
  }
  return most * 180 / std::numbers::pi;
}

TEST(FurnishHome, IsFilmedByAViewThatTurnsAsAHandTurnsIt) {
  const PieceSizes sizes = Sizes();
  for (std::uint64_t seed = 1; seed <= kNumSeeds; ++seed) {
    const SceneDescription home = FurnishHome(seed, sizes);
    // 46 degrees in a second, a third more in the middle of the way, and the hand shakes.
    EXPECT_LT(FastestTurn_deg(home), 10) << "seed " << seed;
    EXPECT_LT(home.num_frames, 2500) << "seed " << seed;
  }
}

TEST(FurnishHome, CanBeBuiltAndWalkedThrough) {
  const PieceSizes sizes = Sizes();
  const auto models = Models(sizes);
  for (std::uint64_t seed = 1; seed <= kNumSeeds; ++seed) {
    const SceneDescription home = FurnishHome(seed, sizes);
    // Which checks that nothing stands in a wall and the camera comes into nothing.
    const Result<World> world = BuildWorld(home, models, Classes());
    ASSERT_TRUE(world.ok()) << "seed " << seed << ": " << world.error().message;
    EXPECT_THAT(world->warnings, testing::IsEmpty()) << "seed " << seed;
    EXPECT_GT(home.num_frames, 200) << "seed " << seed;
  }
}

TEST(FurnishHome, PiecesShareNoPlaceButForChairsAtTables) {
  const PieceSizes sizes = Sizes();
  for (std::uint64_t seed = 1; seed <= kNumSeeds; ++seed) {
    const SceneDescription home = FurnishHome(seed, sizes);
    EXPECT_GE(home.objects.size(), 8U) << "seed " << seed;
    for (std::size_t a = 0; a < home.objects.size(); ++a) {
      for (std::size_t b = a + 1; b < home.objects.size(); ++b) {
        const SceneObject &one = home.objects[a], &other = home.objects[b];
        const bool at_table = one.class_name == "table" && other.class_name == "chair";
        const bool both_chairs = one.class_name == "chair" && other.class_name == "chair";
        if (at_table || both_chairs) continue;
        EXPECT_FALSE(Overlap(BoxOf(one, sizes), BoxOf(other, sizes)))
            << "seed " << seed << ": " << one.model << " and " << other.model;
      }
    }
  }
}

TEST(FurnishHome, RoomsHaveDoorsAndAreVisited) {
  const PieceSizes sizes = Sizes();
  std::size_t num_rooms = 0, num_visited = 0;
  for (std::uint64_t seed = 1; seed <= kNumSeeds; ++seed) {
    const SceneDescription home = FurnishHome(seed, sizes);
    const Layout layout = TrueLayout(home);
    ASSERT_GE(layout.rooms.size(), 3U) << "seed " << seed;
    EXPECT_EQ(layout.rooms.size(), home.partitions.size() + 1) << "seed " << seed;
    const auto joins = std::ranges::count_if(
        layout.openings, [](const LayoutOpening& opening) { return opening.rooms.size() == 2; });
    EXPECT_EQ(static_cast<std::size_t>(joins), layout.rooms.size() - 1) << "seed " << seed;
    for (const LayoutRoom& room : layout.rooms) {
      ++num_rooms;
      num_visited += std::ranges::any_of(home.walk.points_m, [&](const Eigen::Vector3d& p) {
        return IsInside(room.polygon_m, p.head<2>());
      });
    }
  }
  EXPECT_GT(num_visited, 0.9 * static_cast<double>(num_rooms));
}

TEST(FurnishHome, GoesByItsSeedAlone) {
  const PieceSizes sizes = Sizes();
  const SceneDescription home = FurnishHome(5, sizes);
  const SceneDescription again = FurnishHome(5, sizes);
  ASSERT_EQ(home.objects.size(), again.objects.size());
  for (std::size_t n = 0; n < home.objects.size(); ++n)
    EXPECT_EQ(home.objects[n].position_m, again.objects[n].position_m);
  EXPECT_EQ(home.walk.points_m, again.walk.points_m);
  EXPECT_NE(home.room_size_m, FurnishHome(6, sizes).room_size_m);
}

TEST(FurnishHome, LeavesOutWhatIsNotThere) {
  EXPECT_THAT(FurnishHome(1, {}).objects, testing::IsEmpty());
  const SceneDescription home = FurnishHome(1, {{"Scopia#chair", {0.5, 0.5, 0.9}}});
  for (const SceneObject& object : home.objects) EXPECT_EQ(object.model, "Scopia#chair");
}

}  // namespace
}  // namespace deepslam::synth

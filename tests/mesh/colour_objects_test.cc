#include "deepslam/mesh/colour_objects.h"

#include <algorithm>

#include <gtest/gtest.h>

#include "support/box_meshes.h"

namespace deepslam::mesh {
namespace {

constexpr Rgb8 kRed{200, 20, 20};
constexpr Rgb8 kClass{1, 2, 3};

// Two boxes of a metre: object 4 at the origin, object 7 three metres along x.
class TwoBoxes : public testing::Test {
 protected:
  TwoBoxes() {
    classes_.classes.emplace_back();
    classes_.classes[0].name = "cabinet";
    classes_.classes[0].colour_rgb = {1, 2, 3};
    map_.map.objects.resize(2);
    for (const std::size_t n : {0, 1}) {
      map_.map.objects[n].class_name = "cabinet";
      meshes_.emplace_back(testing_support::BoxMesh({1, 1, 1}));
    }
    map_.map.objects[0].id = ObjectId{4};
    map_.map.objects[1].id = ObjectId{7};
    map_.map.objects[1].world_from_object.translation_m = {3, 0, 0};
    map_.frames.resize(1);
    map_.frames[0].frame = FrameIdx{0};
    map_.frames[0].world_from_camera.translation_m = {0, 0, -2};
  }

  // The first box from 2 m below: its lower side is red. The tracked pose is far off the final one.
  static ObjectView View() {
    ObjectView view;
    view.frame = FrameIdx{0};
    view.camera = {320, 240, 150, 150, 159.5, 119.5};
    view.world_from_camera.translation_m = {0, 40, 0};
    view.depth_crop_m = DepthImage(320, 240, 1.5F);
    view.colour_crop = ColourImage(320, 240, kRed);
    view.mask_crop = Mask(320, 240, 1);
    return view;
  }

  [[nodiscard]] std::ptrdiff_t NumOf(std::size_t n, Rgb8 colour) const {
    return std::ranges::count(meshes_[n]->colours, colour);
  }

  ClassTable classes_;
  OptimizedMap map_;
  std::vector<Result<TriangleMesh>> meshes_;
};

TEST_F(TwoBoxes, AreColouredByTheFinalPosesAndTheirClass) {
  ObjectColouring colouring(map_, classes_, {}, meshes_);
  std::vector<ObjectView> views = {View()};
  colouring.Colour(ObjectId{4}, views);
  EXPECT_GT(NumOf(0, kRed), 0);
  EXPECT_TRUE(meshes_[1]->colours.empty());
  colouring.ColourRest();
  EXPECT_EQ(NumOf(1, kClass), 8);
  EXPECT_GT(NumOf(0, kRed), 0);  // what was coloured stays
}

TEST_F(TwoBoxes, HaveTracksOfMappedObjectsOnly) {
  const ObjectColouring colouring(map_, classes_, {}, meshes_);
  std::vector<ObjectTrack> tracks(3);
  tracks[0].id = ObjectId{7};
  tracks[1].id = ObjectId{5};
  tracks[2].id = ObjectId{4};
  const std::vector<ObjectTrack> mapped = colouring.TracksToColour(tracks);
  ASSERT_EQ(mapped.size(), 2U);
  EXPECT_EQ(mapped[0].id, ObjectId{7});
  EXPECT_EQ(mapped[1].id, ObjectId{4});
}

TEST_F(TwoBoxes, AnObjectWithoutAMeshGoesWithoutColours) {
  meshes_[0] = InvalidInput("no surface");
  ObjectColouring colouring(map_, classes_, {}, meshes_);
  std::vector<ObjectView> views = {View()};
  colouring.Colour(ObjectId{4}, views);
  colouring.ColourRest();
  EXPECT_EQ(meshes_[0].error().message, "no surface");
  EXPECT_EQ(NumOf(1, kClass), 8);
}

}  // namespace
}  // namespace deepslam::mesh

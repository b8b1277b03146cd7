#include "deepslam/instances/pixel_labels.h"

#include <algorithm>
#include <vector>

#include <gmock/gmock.h>

#include "support/box_world.h"

namespace deepslam::instances {
namespace {

using namespace testing_support;  // NOLINT

constexpr double kVoxelM = 0.04;
constexpr double kReachM = 5;

// A plate 0.5 m above the floor, as the surface of the capture has it, on four legs that the
// surface is too coarse to hold; beside it a block that it holds.
const std::vector<Cuboid> kPlate = {{0, {-0.4, -0.3, 0.45}, {0.4, 0.3, 0.5}}};
const std::vector<Cuboid> kLegs = {{0, {-0.4, -0.3, 0}, {-0.37, -0.27, 0.45}},
                                   {0, {0.37, -0.3, 0}, {0.4, -0.27, 0.45}},
                                   {0, {-0.4, 0.27, 0}, {-0.37, 0.3, 0.45}},
                                   {0, {0.37, 0.27, 0}, {0.4, 0.3, 0.45}}};

struct Fixture {
  SurfaceElements elements{{}, {}, kVoxelM};
  Instances instances;
};

// One instance per cuboid of the surface.
Fixture SurfaceOf(const std::vector<Cuboid>& boxes) {
  std::vector<Eigen::Vector3f> points;
  std::vector<Eigen::Vector3f> normals;
  const auto add = [&](const Cuboid& box, int axis, double sign) {
    const int a = (axis + 1) % 3;
    const int b = (axis + 2) % 3;
    Eigen::Vector3d normal = Eigen::Vector3d::Zero();
    normal[axis] = sign;
    for (double s = box.min_m[a] + 0.01; s < box.max_m[a]; s += 0.02) {
      for (double t = box.min_m[b] + 0.01; t < box.max_m[b]; t += 0.02) {
        Eigen::Vector3d p;
        p[axis] = sign > 0 ? box.max_m[axis] : box.min_m[axis];
        p[a] = s;
        p[b] = t;
        points.push_back(p.cast<float>());
        normals.push_back(normal.cast<float>());
      }
    }
  };
  for (const Cuboid& box : boxes) {
    for (int axis = 0; axis < 3; ++axis) {
      add(box, axis, 1);
      add(box, axis, -1);
    }
  }
  Fixture fixture{SurfaceElements(points, normals, kVoxelM), {}};
  fixture.instances.instances.resize(boxes.size());
  fixture.instances.of_element.assign(fixture.elements.size(), -1);
  for (std::size_t i = 0; i < fixture.elements.size(); ++i) {
    const Eigen::Vector3d p = fixture.elements.points()[i].cast<double>();
    for (std::size_t k = 0; k < boxes.size(); ++k) {
      if ((p.array() < boxes[k].min_m.array() - 1e-3).any() ||
          (p.array() > boxes[k].max_m.array() + 1e-3).any())
        continue;
      fixture.instances.of_element[i] = static_cast<int>(k);
      fixture.instances.instances[k].elements.push_back(static_cast<int>(i));
    }
  }
  for (std::size_t k = 0; k < boxes.size(); ++k) {
    UprightBox& box = fixture.instances.instances[k].box_level;
    box.centre_m = 0.5 * (boxes[k].min_m + boxes[k].max_m).head<2>();
    box.length_m = boxes[k].max_m.x() - boxes[k].min_m.x();
    box.width_m = boxes[k].max_m.y() - boxes[k].min_m.y();
    box.bottom_m = boxes[k].min_m.z();
    box.top_m = boxes[k].max_m.z();
  }
  return fixture;
}

std::vector<Cuboid> Together(std::vector<Cuboid> a, const std::vector<Cuboid>& b) {
  a.insert(a.end(), b.begin(), b.end());
  return a;
}

PixelLabels Labels(const Fixture& fixture, const MeasuredView& view, bool grow) {
  const NearestElements nearest(fixture.elements);
  const DividedSurface surface{fixture.elements, nearest, fixture.instances};
  PixelLabels labels = LabelBySurface(surface, view);
  if (grow) GrowIntoLoose(surface, view, labels);
  return labels;
}

int CountWhere(const PixelLabels& labels, const BoxView& seen, int label, int object) {
  int count = 0;
  for (std::size_t p = 0; p < labels.instance.size(); ++p)
    count += labels.instance.data()[p] == label && seen.object.data()[p] == object ? 1 : 0;
  return count;
}

const Pose3 kBefore = LookAt({0.5, -1.8, 1.1}, {0, 0, 0.3});

TEST(PixelLabels, LegsTooThinForTheSurfaceBelongToTheirThing) {
  const Fixture fixture = SurfaceOf(kPlate);
  const BoxView seen = RenderBoxes(Together(kPlate, kLegs), SmallCamera(), kBefore);
  const MeasuredView view{seen.frame.depth_m, SmallCamera(), kBefore, kReachM};
  const int num_true = static_cast<int>(std::ranges::count(seen.object, 0));
  const int num_by_surface = CountWhere(Labels(fixture, view, false), seen, 0, 0);
  const PixelLabels grown = Labels(fixture, view, true);
  const int num_grown = CountWhere(grown, seen, 0, 0);
  EXPECT_LT(num_by_surface, 0.9 * num_true);
  // All but the 5 cm of legs next to the floor, which are told from it by nothing.
  EXPECT_GT(num_grown, 0.95 * num_true);
  // No more than what lies within 6 cm of the plate, as its outline is a voxel coarse.
  EXPECT_LT(CountWhere(grown, seen, 0, -1), 0.05 * num_true);
}

TEST(PixelLabels, NothingGrowsOverADepthEdgeNorFarOutOfTheBox) {
  const Fixture fixture = SurfaceOf(kPlate);
  // Unknown to the surface: a box half a metre behind the plate, and one that goes on beside it.
  const std::vector<Cuboid> behind = {{5, {-0.5, 0.8, 0}, {0.5, 1.0, 0.8}}};
  const std::vector<Cuboid> beside = {{6, {0.4, -0.3, 0.45}, {1.6, 0.3, 0.5}}};
  for (const std::vector<Cuboid>& other : {behind, beside}) {
    const int object = other.front().object;
    const BoxView seen = RenderBoxes(Together(kPlate, other), SmallCamera(), kBefore);
    const MeasuredView view{seen.frame.depth_m, SmallCamera(), kBefore, kReachM};
    const int num_true = static_cast<int>(std::ranges::count(seen.object, object));
    ASSERT_GT(num_true, 1000);
    EXPECT_LT(CountWhere(Labels(fixture, view, true), seen, 0, object), 0.12 * num_true);
  }
}

TEST(PixelLabels, PixelsOfOtherThingsAndOfTheFloorAreNotTaken) {
  const std::vector<Cuboid> block = {{1, {0.45, -0.3, 0}, {0.9, 0.3, 0.5}}};
  Fixture fixture = SurfaceOf(Together(kPlate, block));
  const BoxView seen =
      RenderBoxes(Together(Together(kPlate, kLegs), block), SmallCamera(), kBefore);
  const MeasuredView view{seen.frame.depth_m, SmallCamera(), kBefore, kReachM};
  // A thing that is no object of the map keeps its pixels as well.
  fixture.instances.instances[1].rejection = "small";
  const PixelLabels by_surface = Labels(fixture, view, false);
  const PixelLabels grown = Labels(fixture, view, true);
  for (std::size_t p = 0; p < grown.instance.size(); ++p) {
    if (by_surface.instance.data()[p] == kLoosePixel) continue;
    EXPECT_EQ(grown.instance.data()[p], by_surface.instance.data()[p]);
  }
  EXPECT_EQ(CountWhere(grown, seen, 0, -1), CountWhere(by_surface, seen, 0, -1));
  EXPECT_GT(by_surface.num_visible[1], 50);
}

// By the surface, and by a detection of the first thing whose mask is the whole picture.
PixelLabels LabelsWithAllShown(const Fixture& fixture, const MeasuredView& view) {
  Mask everything(view.depth_m.width(), view.depth_m.height());
  std::ranges::fill(everything, 1);
  const PixelMask mask = everything;
  const ShownInstance shown{0, &mask};
  const NearestElements nearest(fixture.elements);
  PixelLabels labels = Labels(fixture, view, false);
  GrowIntoMasks({fixture.elements, nearest, fixture.instances}, view, {&shown, 1}, labels);
  return labels;
}

TEST(PixelLabels, WhatADetectionShowsOverItsThingBelongsToIt) {
  Fixture fixture = SurfaceOf(kPlate);
  // The rail of a back, 0.3 m above the seat with nothing measured between, and a box far behind.
  const std::vector<Cuboid> rail = {{7, {-0.4, 0.27, 0.8}, {0.4, 0.3, 0.9}}};
  const std::vector<Cuboid> behind = {{5, {-0.5, 0.8, 0}, {0.5, 1.0, 0.8}}};
  const BoxView seen =
      RenderBoxes(Together(Together(kPlate, rail), behind), SmallCamera(), kBefore);
  const MeasuredView view{seen.frame.depth_m, SmallCamera(), kBefore, kReachM};
  const int num_rail = static_cast<int>(std::ranges::count(seen.object, 7));
  ASSERT_GT(num_rail, 300);
  EXPECT_EQ(CountWhere(Labels(fixture, view, true), seen, 0, 7), 0);
  const PixelLabels before = Labels(fixture, view, false);
  const PixelLabels labels = LabelsWithAllShown(fixture, view);
  EXPECT_GT(CountWhere(labels, seen, 0, 7), 0.9 * num_rail);
  EXPECT_EQ(CountWhere(labels, seen, 0, 5), CountWhere(before, seen, 0, 5));
  EXPECT_EQ(CountWhere(labels, seen, kRoomPixel, -1), CountWhere(before, seen, kRoomPixel, -1));
}

TEST(PixelLabels, WhatHangsTogetherWithAThingInItsMaskReachesOutOfItsBox) {
  // Leaves that the surface has as a piece of their own, and a hand's breadth on, unknown to it.
  const std::vector<Cuboid> leaves = {{2, {0.42, -0.1, 0.75}, {0.8, 0.1, 0.9}}};
  const std::vector<Cuboid> tips = {{7, {0.86, -0.1, 0.75}, {1.1, 0.1, 0.9}}};
  Fixture fixture = SurfaceOf(Together(kPlate, leaves));
  ASSERT_EQ(fixture.instances.instances.size(), 2U);
  const BoxView seen =
      RenderBoxes(Together(Together(kPlate, leaves), tips), SmallCamera(), kBefore);
  const MeasuredView view{seen.frame.depth_m, SmallCamera(), kBefore, kReachM};
  for (Instance& instance : fixture.instances.instances) {
    instance.class_name = "potted plant";
    instance.is_named = true;
  }
  const auto taken = [&](int object) {
    return CountWhere(LabelsWithAllShown(fixture, view), seen, 0, object);
  };
  const int num_tips = static_cast<int>(std::ranges::count(seen.object, 7));
  const int num_leaves = static_cast<int>(std::ranges::count(seen.object, 2));
  ASSERT_GT(num_tips, 200);
  EXPECT_EQ(taken(2), 0) << "a plant of its own keeps its leaves";
  fixture.instances.instances[1].rejection = "small";
  EXPECT_GT(taken(2), 0.9 * num_leaves);
  EXPECT_GT(taken(7), 0.9 * num_tips);
  fixture.instances.instances[1].class_name = "chair";
  EXPECT_EQ(taken(2), 0) << "a piece of something else";
}

TEST(PixelLabels, OnlyGapsWithoutDepthInsideAThingAreFilled) {
  DepthImage depth_m(40, 20, 1.0F);
  PinholeCamera camera{40, 20, 100, 100, 20, 10};
  PixelLabels labels{Image<int>(40, 20, 0), {}};
  const auto clear = [&](int u, int v) {
    depth_m(u, v) = 0;
    labels.instance(u, v) = kUnmeasuredPixel;
  };
  for (int v = 0; v < 20; ++v) {
    for (int u = 5; u < 12; ++u) clear(u, v);   // 7 cm at a metre
    for (int u = 15; u < 35; ++u) clear(u, v);  // 20 cm
    clear(39, v);                               // at the border
    labels.instance(2, v) = kRoomPixel;         // seen behind
  }
  FillUnmeasured({depth_m, camera, Pose3(), kReachM}, 0.15, labels);
  for (int v = 0; v < 20; ++v) {
    EXPECT_EQ(labels.instance(8, v), 0);
    EXPECT_EQ(labels.instance(20, v), kUnmeasuredPixel);
    EXPECT_EQ(labels.instance(39, v), kUnmeasuredPixel);
    EXPECT_EQ(labels.instance(2, v), kRoomPixel);
  }
  // Between two things a gap is nobody's.
  for (int v = 0; v < 20; ++v) {
    labels.instance(4, v) = 1;
    for (int u = 5; u < 12; ++u) clear(u, v);
  }
  FillUnmeasured({depth_m, camera, Pose3(), kReachM}, 0.15, labels);
  EXPECT_EQ(labels.instance(8, 7), kUnmeasuredPixel);
}

TEST(PixelLabels, OfDepthThatIsNoneOrTooFarNothingIsAThings) {
  const Fixture fixture = SurfaceOf(kPlate);
  for (const float depth_m : {0.0F, -1.0F, 50.0F, std::numeric_limits<float>::quiet_NaN()}) {
    const DepthImage image(32, 24, depth_m);
    const PinholeCamera camera{32, 24, 30, 30, 16, 12};
    const PixelLabels labels = Labels(fixture, {image, camera, kBefore, kReachM}, true);
    for (const int label : labels.instance) EXPECT_LT(label, 0);
  }
}

}  // namespace
}  // namespace deepslam::instances

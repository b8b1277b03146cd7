// Registration and selection together, on input that tells little or lies: nothing breaks, the
// confidence is low, and the map says why.
#include <cmath>
#include <vector>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "deepslam/registration/register_shape.h"
#include "deepslam/select/confidence.h"
#include "deepslam/select/select.h"
#include "support/furniture_world.h"

namespace deepslam::select {
namespace {

using testing_support::CandidateFor;
using testing_support::ChairGrid;
using testing_support::FurnitureWorld;
using testing_support::ViewSettings;

// The chair seen from all round, as it should be: what the others are compared with.
const std::vector<double> kAround = {0.0, 0.8, 1.6, 2.4, 3.2, 4.0, 4.8, 5.6};

class ScoreAChair : public testing::Test {
 protected:
  [[nodiscard]] MapObject Judge(const VoxelGrid& grid, const std::vector<ObjectView>& views) const {
    const ShapeCandidate candidate = CandidateFor(0.6, 1.3, 0.95);
    const shape::ShapeModel model(grid);
    const CandidateRegistration registration =
        registration::RegisterCandidate(candidate, model, views, {});
    const CandidateScore score = ScoreCandidate(candidate, model, registration, views, {});
    MapObject object = SelectShape(
        ObjectId{0}, "chair", {&candidate, 1}, {&registration, 1}, {&score, 1}, views, {});
    object.confidence = Confidence(object, model, {&candidate, 1}, {&registration, 1}, {&score, 1});
    return object;
  }

  // Pixels of the mask that `keep` allows.
  template <typename Keep>
  [[nodiscard]] std::vector<ObjectView> Masked(Keep keep) const {
    std::vector<ObjectView> views = views_;
    for (ObjectView& view : views) {
      for (int v = 0; v < view.mask_crop.height(); ++v) {
        for (int u = 0; u < view.mask_crop.width(); ++u) {
          if (!keep(u, v)) view.mask_crop(u, v) = 0;
        }
      }
    }
    return views;
  }

  FurnitureWorld world_{ChairGrid(), 0.9};
  std::vector<ObjectView> views_ = world_.Views(kAround);
};

void ExpectDoubtful(const MapObject& object) {
  EXPECT_TRUE(std::isfinite(object.confidence));
  EXPECT_TRUE(std::isfinite(object.scale_m));
  EXPECT_TRUE(object.world_from_object.translation_m.allFinite());
  EXPECT_TRUE(object.world_from_object.rotation.coeffs().allFinite());
  EXPECT_LT(object.confidence, 0.35);
  EXPECT_FALSE(object.note.empty());
}

TEST_F(ScoreAChair, TheTrueModelSeenAllRoundIsTrusted) {
  const MapObject object = Judge(ChairGrid(), views_);
  EXPECT_TRUE(object.chosen.valid());
  EXPECT_GT(object.confidence, 0.8);
  EXPECT_THAT(object.note, testing::IsEmpty());
}

TEST_F(ScoreAChair, OneViewIsTrustedLess) {
  const MapObject one = Judge(ChairGrid(), {views_[1]});
  EXPECT_LT(one.confidence, 0.6);
  EXPECT_THAT(one.note, testing::HasSubstr("one view"));
}

TEST_F(ScoreAChair, NoViewOrNothingInThem) {
  ExpectDoubtful(Judge(ChairGrid(), {}));
  ExpectDoubtful(Judge(ChairGrid(), {ObjectView()}));
  ExpectDoubtful(Judge(ChairGrid(), Masked([](int, int) { return false; })));
}

TEST_F(ScoreAChair, TenPoints) {
  ExpectDoubtful(Judge(
      ChairGrid(), Masked([](int u, int v) { return u >= 78 && u < 83 && v >= 60 && v < 62; })));
}

TEST_F(ScoreAChair, PointsOnALine) {
  ExpectDoubtful(Judge(ChairGrid(), Masked([](int, int v) { return v == 60; })));
  ExpectDoubtful(Judge(ChairGrid(), Masked([](int u, int) { return u == 80; })));
}

TEST_F(ScoreAChair, EmptyAndFullModels) {
  ExpectDoubtful(Judge(VoxelGrid(), views_));
  ExpectDoubtful(Judge(testing_support::FullGrid(), views_));
}

// The masks of a picture show what is beside the chair: floor to its left.
TEST_F(ScoreAChair, MasksThatShowSomethingElse) {
  std::vector<ObjectView> views = views_;
  for (ObjectView& view : views) {
    for (int v = 0; v < view.mask_crop.height(); ++v) {
      for (int u = 0; u < view.mask_crop.width(); ++u) {
        view.mask_crop(u, v) = u < 40 && v > 90 && view.depth_crop_m(u, v) > 0 ? 1 : 0;
      }
    }
  }
  ExpectDoubtful(Judge(ChairGrid(), views));
}

TEST_F(ScoreAChair, EveryPixelIsTheChairs) {
  std::vector<ObjectView> views = views_;
  for (ObjectView& view : views) {
    for (std::uint8_t& pixel : view.mask_crop) pixel = 1;
  }
  ExpectDoubtful(Judge(ChairGrid(), views));
}

}  // namespace
}  // namespace deepslam::select

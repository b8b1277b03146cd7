#include "deepslam/report/object_rows.h"

#include <gmock/gmock.h>

#include "support/box_meshes.h"

namespace deepslam::report {
namespace {

MapObject TurnedBox() {
  MapObject object;
  object.id = ObjectId{4};
  object.class_name = "cabinet";
  object.chosen = CandidateId{8};
  object.source = CandidateSource::kRetrieval;
  object.world_from_object.rotation = Eigen::AngleAxisd(M_PI / 2, Eigen::Vector3d::UnitX());
  object.world_from_object.translation_m = {0, 0, 2};
  object.views.resize(3);
  object.scores.resize(2);
  object.scores[0].candidate = CandidateId{8};
  object.scores[0].score = 0.7;
  object.scores[1].candidate = CandidateId{9};
  object.scores[1].note = "too few points";
  return object;
}

TEST(MakeObjectRow, MeasuresTheMeshAlongTheObjectsAxesAndAboveTheGround) {
  const ObjectRow row =
      MakeObjectRow(TurnedBox(), testing_support::BoxMesh({1, 3, 0.5F}), {1, 2, 3}, {});
  EXPECT_EQ(row.name, "cabinet_04");
  EXPECT_TRUE(row.size_m.isApprox(Eigen::Vector3d(1, 3, 0.5), 1e-6));
  EXPECT_NEAR(row.bottom_above_ground_m, 2 - 1.5, 1e-6);  // its y points up
  EXPECT_EQ(row.num_views, 3);
  EXPECT_EQ(row.source, "CAD library");
  EXPECT_EQ(row.colour, (Rgb8{1, 2, 3}));
}

TEST(MakeObjectRow, ListsCandidatesInTheOrderOfTheScores) {
  std::vector<ShapeCandidate> candidates(2);
  candidates[0].id = CandidateId{9};
  candidates[0].model = "maker__chair";
  candidates[0].source = CandidateSource::kFused;
  candidates[1].id = CandidateId{1};
  const ObjectRow row = MakeObjectRow(TurnedBox(), {}, {}, ById(candidates));
  ASSERT_EQ(row.candidates.size(), 2U);
  EXPECT_TRUE(row.candidates[0].chosen);
  EXPECT_EQ(row.candidates[0].score, 0.7);
  EXPECT_EQ(row.candidates[0].model, "");  // not among the candidates
  EXPECT_FALSE(row.candidates[1].chosen);
  EXPECT_EQ(row.candidates[1].model, "maker__chair");
  EXPECT_EQ(row.candidates[1].source, "own measurement");
  EXPECT_EQ(row.candidates[1].note, "too few points");
}

TEST(MakeObjectRow, AnObjectWithoutASurfaceHasNoSize) {
  const ObjectRow row = MakeObjectRow(TurnedBox(), {}, {}, {});
  EXPECT_EQ(row.size_m, Eigen::Vector3d::Zero());
  EXPECT_EQ(row.bottom_above_ground_m, 0);
}

}  // namespace
}  // namespace deepslam::report

// What speaks for and against the place of an object: confidence by relations, on made-up scores.
#include "deepslam/select/confidence.h"

#include <limits>
#include <numbers>
#include <vector>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "deepslam/shape/voxelize.h"
#include "support/box_meshes.h"

namespace deepslam::select {
namespace {

constexpr int kNumViews = 8;

shape::ShapeModel Model(const TriangleMesh& mesh) {
  return shape::ShapeModel(shape::Voxelize(mesh).value());
}

Pose3 At(double x_m, double yaw_deg) {
  return {Eigen::Quaterniond(
              Eigen::AngleAxisd(yaw_deg * std::numbers::pi / 180, Eigen::Vector3d::UnitZ())),
          {x_m, 0, 0.4}};
}

class ConfidenceInAPlace : public testing::Test {
 protected:
  ConfidenceInAPlace() { Add(CandidateSource::kRetrieval, At(0, 0), 1.0, 0.95); }

  void Add(CandidateSource source,
           const Pose3& world_from_object,
           double scale_m,
           double score,
           int num_views = kNumViews) {
    const CandidateId id{static_cast<int>(candidates_.size())};
    candidates_.emplace_back();
    candidates_.back().id = id;
    candidates_.back().source = source;
    CandidateRegistration& registration = registrations_.emplace_back();
    registration.candidate = id;
    registration.ok = true;
    registration.scale_m = scale_m;
    registration.world_from_object = world_from_object;
    registration.views.resize(kNumViews);
    for (int n = 0; n < num_views; ++n) registration.views[static_cast<std::size_t>(n)].ok = true;
    CandidateScore& entry = scores_.emplace_back();
    entry.candidate = id;
    entry.score = score;
    entry.seen_share = 0.5;
  }

  // Of the candidate of that number, as if it had won.
  [[nodiscard]] double Of(std::size_t number) const {
    MapObject winner;
    winner.chosen = candidates_[number].id;
    winner.scale_m = registrations_[number].scale_m;
    winner.world_from_object = registrations_[number].world_from_object;
    winner.views = registrations_[number].views;
    return Confidence(winner, shape_, candidates_, registrations_, scores_);
  }

  shape::ShapeModel shape_ = Model(testing_support::ChairMesh(0.45F, 0.5F, 0.45F, 0.9F, 0.04F));
  std::vector<ShapeCandidate> candidates_;
  std::vector<CandidateRegistration> registrations_;
  std::vector<CandidateScore> scores_;
};

TEST_F(ConfidenceInAPlace, IsHighWhereEveryModelStandsThere) {
  Add(CandidateSource::kRetrieval, At(0.1, 10), 1.1, 0.9);
  EXPECT_GT(Of(0), 0.9);
  EXPECT_LE(Of(0), 1.0);
}

TEST_F(ConfidenceInAPlace, FallsWithEveryOtherPlaceThatExplainsTheDepthAsWell) {
  const double alone = Of(0);
  Add(CandidateSource::kRetrieval, At(0, 40), 1.0, 0.7);
  EXPECT_EQ(Of(0), alone);  // agrees far worse
  for (const auto& [world_from_object, scale_m] :
       {std::pair{At(0.3, 0), 1.0}, std::pair{At(0, 30), 1.0}, std::pair{At(0, 0), 1.3}}) {
    Add(CandidateSource::kRetrieval, world_from_object, scale_m, 0.94);
    EXPECT_LT(Of(0), alone - 0.05);
    candidates_.pop_back();
    registrations_.pop_back();
    scores_.pop_back();
  }
}

TEST_F(ConfidenceInAPlace, TurnsOfTheShapeAreNoOtherPlace) {
  const double alone = Of(0);
  Add(CandidateSource::kRetrieval, At(0, 180), 1.0, 0.95);
  EXPECT_LT(Of(0), alone);
  shape_ = Model(testing_support::TableMesh(1.4F, 0.8F, 0.75F, 0.08F));
  EXPECT_EQ(Of(0), alone);
}

TEST_F(ConfidenceInAPlace, IsNotMadeByTheDepthItself) {
  const double alone = Of(0);
  for (std::size_t n = 0; n < kNumCandidateSources; ++n) {
    const auto source = static_cast<CandidateSource>(n);
    if (!TraitsOf(source).follows_depth) continue;
    Add(source, At(0.5, 90), 1.5, 0.99);
    EXPECT_EQ(Of(0), alone);
    // Standing where no whole model does, it is hardly to be trusted itself.
    EXPECT_LT(Of(candidates_.size() - 1), 0.5);
  }
}

TEST_F(ConfidenceInAPlace, ModelsThatFewViewsHoldInPlaceDoNotVote) {
  const double alone = Of(0);
  Add(CandidateSource::kRetrieval, At(0.5, 0), 1.0, 0.99, kNumViews / 2 - 1);
  EXPECT_EQ(Of(0), alone);
}

TEST_F(ConfidenceInAPlace, FallsWhereNoWholeModelExplainsTheDepth) {
  Add(CandidateSource::kCompleted, At(0, 0), 1.0, 0.99);
  const double explained = Of(1);
  scores_[0].score = 0.65;
  EXPECT_LT(Of(1), explained - 0.2);
}

TEST_F(ConfidenceInAPlace, GrowsWithWhatWasSeen) {
  double before = 0;
  for (const double seen : {0.0, 0.1, 0.2, 0.3}) {
    scores_[0].seen_share = seen;
    EXPECT_GT(Of(0), before);
    before = Of(0);
  }
}

TEST_F(ConfidenceInAPlace, IsInRangeWhateverTheScoresAre) {
  for (const double score : {std::numeric_limits<double>::quiet_NaN(), -1e300, 1e300, 0.0}) {
    Add(CandidateSource::kRetrieval, At(0, 90), 1.0, score);
    EXPECT_GE(Of(0), 0);
    EXPECT_LE(Of(0), 1);
  }
  MapObject nothing;
  EXPECT_EQ(Confidence(nothing, shape_, candidates_, registrations_, scores_), 0);
}

}  // namespace
}  // namespace deepslam::select

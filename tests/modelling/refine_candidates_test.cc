// What selection makes of an object by all its depth: the winner's pose is refined, and kept only
// where it agrees better; a completed model is as large as it was measured.
#include "deepslam/modelling/refine_candidates.h"

#include <cmath>
#include <numbers>
#include <string>
#include <utility>
#include <vector>

#include <gtest/gtest.h>

#include "deepslam/geometry/pose.h"
#include "deepslam/scene/wall_geometry.h"
#include "deepslam/select/placed.h"
#include "deepslam/select/select.h"
#include "support/furniture_world.h"

namespace deepslam::modelling {
namespace {

using testing_support::CandidateFor;
using testing_support::ChairGrid;
using testing_support::FurnitureWorld;
using testing_support::Perturbed;
using testing_support::PlacedAt;
using testing_support::ViewSettings;

constexpr double kSize_m = 0.9;

ObjectOptions WithPose(bool pose = true) {
  ObjectOptions options;
  options.refinement.pose = pose;
  return options;
}

// What this module's functions need of a registration or score to be the same.
bool IsSame(const CandidateRegistration& a, const CandidateRegistration& b) {
  if (a.candidate != b.candidate || a.ok != b.ok || a.scale_m != b.scale_m ||
      a.world_from_object != b.world_from_object || a.views.size() != b.views.size())
    return false;
  for (std::size_t i = 0; i < a.views.size(); ++i) {
    if (a.views[i].ok != b.views[i].ok ||
        a.views[i].camera_from_object != b.views[i].camera_from_object ||
        a.views[i].information != b.views[i].information)
      return false;
  }
  return true;
}

bool IsFinite(const CandidateRegistration& registration) {
  const auto finite = [](const Pose3& pose) {
    return pose.translation_m.allFinite() && pose.rotation.coeffs().allFinite();
  };
  bool all = std::isfinite(registration.scale_m) && finite(registration.world_from_object);
  for (const ViewRegistration& view : registration.views)
    all = all && finite(view.camera_from_object) && view.information.allFinite();
  return all;
}

// A chair and what competes to be it.
class RefineTheWinner : public testing::Test {
 protected:
  // A candidate that stands somewhere, scored when the set is.
  void Add(const VoxelGrid& grid, const CandidateRegistration& registration, double max_size_m) {
    const int id = static_cast<int>(set_.candidates.size());
    ShapeCandidate candidate = CandidateFor(0.5, max_size_m, 0, id);
    candidate.model = "model_" + std::to_string(id);
    set_.models.merge(PrepareModels({{candidate.model, grid}}, prepared_));
    set_.candidates.push_back(candidate);
    set_.registrations.push_back(registration);
    set_.registrations.back().candidate = candidate.id;
  }
  void AddAt(const VoxelGrid& grid, const Similarity3& placed, double max_size_m = 1.5) {
    Add(grid, PlacedAt(placed, views_), max_size_m);
  }
  // As the chain places it.
  void AddRegistered(const VoxelGrid& grid) {
    AddAt(grid, world_.world_from_object());
    set_.registrations.back() =
        RegisterAll(std::span(set_.candidates).last(1), set_.models, views_, "chair", {})[0];
  }

  [[nodiscard]] MapObject Selected() const {
    return select::SelectShape(
        set_.object, set_.class_name, set_.candidates, set_.registrations, set_.scores, views_, {});
  }
  [[nodiscard]] double ScoreOfSelected() const {
    const MapObject object = Selected();
    return object.chosen.valid() ? object.scores.front().score : 0;
  }

  // Refines; whatever the input, nothing gets worse or stops being a number, and what is told to
  // have stayed is what it was.
  std::optional<std::size_t> Refine(const ObjectOptions& options = WithPose()) {
    ScoreAll(views_, options, set_);
    const CandidateSet before = set_;
    const CandidateId chosen = Selected().chosen;
    const double score = ScoreOfSelected();
    const std::optional<std::size_t> replaced = RefineWinner(views_, options, set_);
    EXPECT_EQ(Selected().chosen, chosen);
    EXPECT_GE(ScoreOfSelected(), score);
    for (std::size_t i = 0; i < set_.candidates.size(); ++i) {
      EXPECT_TRUE(IsFinite(set_.registrations[i])) << i;
      EXPECT_TRUE(std::isfinite(set_.scores[i].score)) << i;
      if (replaced == i) {
        EXPECT_EQ(set_.candidates[i].id, chosen);
        EXPECT_GT(set_.scores[i].score, before.scores[i].score);
        EXPECT_EQ(set_.registrations[i].candidate, chosen);
        EXPECT_EQ(set_.registrations[i].views.size(), views_.size());
      } else {
        EXPECT_TRUE(IsSame(set_.registrations[i], before.registrations[i])) << i;
        EXPECT_EQ(set_.scores[i].score, before.scores[i].score) << i;
      }
    }
    return replaced;
  }

  [[nodiscard]] Similarity3 Beside(double factor = 1.1) const {
    return Perturbed(world_.world_from_object(), factor, 1.0);
  }

  // Object pixels that `keep` allows.
  template <typename Keep>
  void Mask(Keep keep) {
    for (std::size_t i = 0; i < views_.size(); ++i) {
      for (int v = 0; v < views_[i].mask_crop.height(); ++v) {
        for (int u = 0; u < views_[i].mask_crop.width(); ++u) {
          if (!keep(i, u, v)) views_[i].mask_crop(u, v) = 0;
        }
      }
    }
  }

  PreparedModels prepared_{0};
  FurnitureWorld world_{ChairGrid(), kSize_m};
  std::vector<ObjectView> views_ = world_.Views({0.2, 0.9, 1.6, 2.3, 3.0});
  CandidateSet set_ = {ObjectId{3}, "chair", {}, {}, {}, {}, {}};
};

TEST_F(RefineTheWinner, BringsAModelThatStandsBesideToItsPlace) {
  AddAt(ChairGrid(), Beside());
  ScoreAll(views_, {}, set_);
  const double before = set_.scores[0].score;
  ASSERT_EQ(Refine(), 0U);
  const CandidateRegistration& registration = set_.registrations[0];
  const Similarity3& truth = world_.world_from_object();
  EXPECT_NEAR(registration.scale_m / truth.scale, 1.0, 0.02);
  EXPECT_LT((registration.world_from_object.translation_m - truth.translation_m).norm(), 0.015);
  EXPECT_GT(set_.scores[0].score, before + 0.03);
  const CandidateScore anew = select::ScoreCandidate(
      set_.candidates[0], world_.model(), registration, views_, select::SelectOptions());
  EXPECT_EQ(set_.scores[0].score, anew.score);
}

TEST_F(RefineTheWinner, ByItsOptionAlone) {
  AddAt(ChairGrid(), Beside());
  EXPECT_EQ(Refine(WithPose(false)), std::nullopt);
}

TEST_F(RefineTheWinner, AndNobodyElse) {
  AddAt(testing_support::StoolGrid(), Beside());
  AddAt(ChairGrid(), Beside());
  AddAt(testing_support::BlockGrid(), Beside());
  EXPECT_EQ(Refine(), 1U);
}

// Where its bounds do not let it be as large as it is, refined it would agree less.
TEST_F(RefineTheWinner, KeepsWhatAgreesBetterAsItIs) {
  AddAt(ChairGrid(), world_.world_from_object(), 0.85 * kSize_m);
  EXPECT_EQ(Refine(), std::nullopt);
}

// Where tracking drifts, few views hold the place that agrees best with all: refined, the chair
// would come after the stool, which agrees less and is said to be held by all.
TEST_F(RefineTheWinner, KeepsWhatWouldLoseToAWorseOne) {
  ViewSettings drifting;
  drifting.drift_m = 0.015;
  views_ = world_.Views({0.2, 0.9, 1.6, 2.3, 3.0}, drifting);
  ObjectOptions options = WithPose();
  options.registration.max_move_m = 0.01;
  AddAt(ChairGrid(), Beside());
  const CandidateSet alone = set_;
  AddAt(testing_support::StoolGrid(), world_.world_from_object());
  ScoreAll(views_, {}, set_);
  ASSERT_EQ(Selected().chosen, CandidateId{0});
  EXPECT_EQ(Refine(options), std::nullopt);
  set_ = alone;
  EXPECT_EQ(Refine(options), 0U);
  EXPECT_LE(select::NumRegistered(set_.registrations[0].views), 2);
}

TEST_F(RefineTheWinner, SameInputSameBytes) {
  AddAt(ChairGrid(), Beside());
  ScoreAll(views_, {}, set_);
  CandidateSet again = set_;
  ASSERT_EQ(Refine(), 0U);
  ASSERT_EQ(RefineWinner(views_, WithPose(), again), 0U);
  EXPECT_TRUE(IsSame(set_.registrations[0], again.registrations[0]));
  EXPECT_EQ(set_.scores[0].score, again.scores[0].score);
}

TEST_F(RefineTheWinner, WithNobodyInTheCandidateSetOrNowhereToStand) {
  EXPECT_EQ(Refine(), std::nullopt);
  AddRegistered(VoxelGrid());
  EXPECT_EQ(Refine(), std::nullopt);
}

TEST_F(RefineTheWinner, NeverWorseByOneView) {
  views_.resize(1);
  AddRegistered(ChairGrid());
  AddAt(ChairGrid(), Beside());
  Refine();
}

TEST_F(RefineTheWinner, NeverWorseByTenPoints) {
  views_.resize(1);
  Mask([](std::size_t, int u, int v) { return u >= 78 && u < 83 && v >= 60 && v < 62; });
  AddRegistered(ChairGrid());
  AddAt(ChairGrid(), Beside());
  EXPECT_EQ(Refine(), std::nullopt);
}

TEST_F(RefineTheWinner, NeverWorseByPointsOnALine) {
  Mask([](std::size_t, int u, int) { return u == 80; });
  AddRegistered(ChairGrid());
  AddAt(ChairGrid(), Beside());
  Refine();
}

TEST_F(RefineTheWinner, NeverWorseByPointsOnALevelLine) {
  Mask([](std::size_t, int, int v) { return v == 60; });
  AddRegistered(ChairGrid());
  AddAt(ChairGrid(), Beside());
  Refine();
}

TEST_F(RefineTheWinner, NeverWorseWithoutViewsOrPoints) {
  views_ = {};
  AddAt(ChairGrid(), Beside());
  EXPECT_EQ(Refine(), std::nullopt);
  views_ = {ObjectView(), ObjectView()};
  set_ = {ObjectId{3}, "chair", {}, {}, {}, {}, {}};
  AddAt(ChairGrid(), Beside());
  EXPECT_EQ(Refine(), std::nullopt);
  views_ = world_.Views({0.2, 0.9});
  Mask([](std::size_t, int, int) { return false; });
  set_ = {ObjectId{3}, "chair", {}, {}, {}, {}, {}};
  AddAt(ChairGrid(), Beside());
  EXPECT_EQ(Refine(), std::nullopt);
}

TEST_F(RefineTheWinner, NeverWorseFullOrUpsideDown) {
  AddRegistered(testing_support::FullGrid());
  Refine();
  set_ = {ObjectId{3}, "chair", {}, {}, {}, {}, {}};
  Similarity3 upside_down = world_.world_from_object();
  upside_down.rotation =
      upside_down.rotation * Eigen::AngleAxisd(std::numbers::pi, Eigen::Vector3d::UnitX());
  AddAt(ChairGrid(), upside_down);
  AddAt(VoxelGrid(), world_.world_from_object());
  Refine();
}

TEST_F(RefineTheWinner, NeverWorseFromAnywhere) {
  for (const double factor : {0.7, 0.9, 1.1, 1.4}) {
    for (int turn = 0; turn < 4; ++turn) {
      set_ = {ObjectId{3}, "chair", {}, {}, {}, {}, {}};
      Similarity3 placed = Beside(factor);
      placed.rotation = Eigen::AngleAxisd(turn * 0.5 * std::numbers::pi, Eigen::Vector3d::UnitZ()) *
                        placed.rotation;
      AddAt(ChairGrid(), placed);
      AddAt(testing_support::StoolGrid(), Beside());
      Refine();
    }
  }
}

// The back of the only design is not there: what is left is smaller than any product of its class.
TEST(CompleteBest, IsAsLargeAsItWasMeasured) {
  VoxelGrid seat = ChairGrid();
  for (int i = 0; i < kGridSize; ++i) {
    for (int j = 0; j < kGridSize; ++j) {
      for (int k = kGridSize / 2; k < kGridSize; ++k) seat.occupied[VoxelGrid::Index(i, j, k)] = 0;
    }
  }
  const FurnitureWorld world(seat, kSize_m);
  const double true_size_m = world.model().extent().maxCoeff() * world.world_from_object().scale;
  const std::vector<ObjectView> views = world.Views({0.2, 1.1, 2.0, 2.9, 3.8, 4.7, 5.6});
  CandidateSet set = {ObjectId{3}, "chair", {}, {}, {}, {}, {}};
  set.candidates.push_back(CandidateFor(0.8 * kSize_m, 1.2 * kSize_m));
  PreparedModels prepared(0);
  set.models = PrepareModels({{"model", ChairGrid()}}, prepared);
  set.registrations.push_back(PlacedAt(world.world_from_object(), views));
  ScoreAll(views, {}, set);
  Proposals completed = CompleteBest(set, views, "filled", {});
  NumberFrom(1, completed);
  AddCandidates(completed, views, {}, prepared, set);
  ASSERT_EQ(completed.candidates.size(), 1U);
  EXPECT_NEAR(completed.candidates[0].size_m / true_size_m, 1.0, 0.1);
  EXPECT_NEAR(set.registrations[1].scale_m * kModelExtent / true_size_m, 1.0, 0.1);
  EXPECT_GT(set.scores[1].score, set.scores[0].score);
  EXPECT_GT(set.scores[1].score, 0.9);
}

// A wall stands right before the chair's front: its front is the other side, and it stays in place.
TEST(AddCandidates, TurnsWhatFacesTheWallItStandsAt) {
  const FurnitureWorld world(ChairGrid(), kSize_m);
  const Similarity3 truth = world.world_from_object();
  const std::vector<ObjectView> views = world.Views({0.2, 1.1, 2.0, 2.9, 3.8, 4.7, 5.6});
  const Eigen::Vector2d front = (truth.rotation * Eigen::Vector3d::UnitX()).head<2>();
  const Eigen::Vector2d foot =
      truth.translation_m.head<2>() + (truth.scale * world.model().box_max().x() + 0.05) * front;
  LayoutWall wall;
  wall.from_m = foot + 2 * Eigen::Vector2d(front.y(), -front.x());
  wall.to_m = foot - 2 * Eigen::Vector2d(front.y(), -front.x());
  if (DistanceBefore(wall, truth.translation_m.head<2>()) < 0) std::swap(wall.from_m, wall.to_m);
  wall.top_m = 2.5;
  Layout layout;
  layout.walls.push_back(wall);
  ObjectOptions options;
  const auto added = [&] {
    CandidateSet set = {ObjectId{3}, "chair", {}, {}, {}, {}, {}};
    set.candidates.push_back(CandidateFor(0.8 * kSize_m, 1.2 * kSize_m));
    PreparedModels prepared(0);
    set.models = PrepareModels({{"model", ChairGrid()}}, prepared);
    set.registrations.push_back(PlacedAt(truth, views));
    ScoreAll(views, options, set);
    Proposals completed = CompleteBest(set, views, "filled", options);
    NumberFrom(1, completed);
    AddCandidates(completed, views, options, prepared, set);
    EXPECT_EQ(completed.models.begin()->second.occupied,
              set.models.at(completed.candidates[0].model)->grid().occupied);
    return set;
  };
  const CandidateSet free = added();
  options.layout = &layout;
  const CandidateSet blocked = added();
  EXPECT_EQ(free.scores[0].front_blocked, 0);
  EXPECT_EQ(blocked.scores[0].front_blocked, 1);
  EXPECT_EQ(blocked.scores[1].front_blocked, 0);
  EXPECT_EQ(blocked.scores[1].score, free.scores[1].score);
  const Pose3 turn = free.registrations[1].world_from_object.Inverse() *
                     blocked.registrations[1].world_from_object;
  EXPECT_NEAR(turn.translation_m.norm(), 0, 1e-9);
  EXPECT_NEAR(RotationAngle(turn.rotation), std::numbers::pi, 1e-6);
  // The same surface in the world, in every view.
  const std::string& name = free.candidates[1].model;
  for (std::size_t v = 0; v < views.size(); ++v) {
    const Pose3 other_from_one = blocked.registrations[1].views[v].camera_from_object.Inverse() *
                                 free.registrations[1].views[v].camera_from_object;
    for (const Eigen::Vector3f& p : free.models.at(name)->surface_points()) {
      const Eigen::Vector3f moved = (other_from_one * p.cast<double>()).cast<float>();
      ASSERT_NEAR(
          blocked.models.at(name)->Distance(moved), free.models.at(name)->Distance(p), 1e-3);
    }
  }
}

}  // namespace
}  // namespace deepslam::modelling

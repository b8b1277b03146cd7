#include "deepslam/loop/appearance.h"

#include <gtest/gtest.h>

#include "deepslam/core/parallel.h"
#include "deepslam/loop/feature_pose.h"
#include "deepslam/loop/keyframe_path.h"
#include "deepslam/loop/similar_keyframes.h"
#include "loop/registered_loops.h"
#include "loop/textured_room.h"
#include "support/pose_matchers.h"

namespace deepslam::loop {
namespace {

using ::deepslam::testing_support::PoseNear;
using testing_support::AsProposed;
using testing_support::ExpectRegistrationToBearOut;
using testing_support::FeaturesAlong;
using testing_support::kCamera;
using testing_support::kFeatures;
using testing_support::Looking;
using testing_support::Photograph;
using testing_support::Round;
using testing_support::TexturedRoom;
using testing_support::Tracked;

KeyframeFeatures FeaturesOf(const TexturedRoom& room, const Pose3& pose, int idx) {
  return ExtractFeatures(Photograph(room, pose, idx), kCamera, kFeatures);
}

// Tracking that is off more and more: by `end` at the last keyframe.
std::vector<Pose3> Drifted(const std::vector<Pose3>& truth, const Vector6d& end) {
  std::vector<Pose3> poses;
  for (std::size_t k = 0; k < truth.size(); ++k) {
    const double share = static_cast<double>(k) / static_cast<double>(truth.size() - 1);
    poses.push_back(V2t(share * end) * truth[k]);
  }
  return poses;
}

Vector6d Drift(double x_m, double y_m, double yaw_rad) {
  return (Vector6d() << x_m, y_m, 0.05, 0, 0, yaw_rad).finished();
}

// Registration that finds the truth wherever the proposal is near it.
std::vector<KeyframeRegistration> RegisteredByTruth(const std::vector<AppearanceLoop>& proposed,
                                                    const std::vector<Pose3>& truth) {
  std::vector<KeyframeRegistration> registrations;
  for (const AppearanceLoop& loop : proposed) {
    const Pose3 exact = truth[static_cast<std::size_t>(loop.old_keyframe.value)].Inverse() *
                        truth[static_cast<std::size_t>(loop.new_keyframe.value)];
    const bool near = (exact.Inverse() * loop.old_from_new).translation_m.norm() < 0.1;
    registrations.push_back({near, exact, 1e6 * Matrix6d::Identity(), 0.95, 0.9});
  }
  return registrations;
}

TEST(ExtractFeatures, CornersLieWhereTheDepthSays) {
  const TexturedRoom room;
  const Pose3 pose = Looking({-1, 0.2, 1.4}, 0.3);
  const KeyframeFeatures features = FeaturesOf(room, pose, 7);
  EXPECT_EQ(features.keyframe, FrameIdx{7});
  ASSERT_GT(features.points_camera.size(), 200u);
  EXPECT_LE(features.points_camera.size(), static_cast<std::size_t>(kFeatures));
  EXPECT_EQ(features.points_camera.size(), features.descriptors.size());
  for (const Eigen::Vector3f& p : features.points_camera) {
    const Eigen::Vector3d ray = pose.rotation * (p.cast<double>() / p.z());
    EXPECT_NEAR(room.Cast(pose.translation_m, ray), static_cast<double>(p.z()), 0.03);
  }
}

TEST(ExtractFeatures, NothingToSeeGivesNothing) {
  const TexturedRoom room;
  const Pose3 pose = Looking({-1, 0.2, 1.4}, 0.3);
  Frame black = Photograph(room, pose, 0);
  black.colour = ColourImage(kCamera.width, kCamera.height);
  EXPECT_TRUE(ExtractFeatures(black, kCamera, kFeatures).descriptors.empty());
  Frame blind = Photograph(room, pose, 0);
  blind.depth_m = DepthImage(kCamera.width, kCamera.height);
  EXPECT_TRUE(ExtractFeatures(blind, kCamera, kFeatures).descriptors.empty());
  Frame other_size = Photograph(room, pose, 0);
  other_size.depth_m = DepthImage(160, 120, 2.0F);
  EXPECT_TRUE(ExtractFeatures(other_size, kCamera, kFeatures).descriptors.empty());
  EXPECT_TRUE(ExtractFeatures(Frame(), kCamera, kFeatures).descriptors.empty());
  Frame tiny;
  tiny.colour = ColourImage(16, 16);
  tiny.depth_m = DepthImage(16, 16, 1.0F);
  EXPECT_TRUE(ExtractFeatures(tiny, {16, 16, 13, 13, 7.5, 7.5}, kFeatures).descriptors.empty());
}

TEST(PoseFromFeatures, FindsTheMotionBetweenTwoViews) {
  const TexturedRoom room;
  const Pose3 a = Looking({-1, 0.2, 1.4}, 0.3);
  const Pose3 b = Looking({-0.7, 0.0, 1.5}, 0.5);
  const auto found = PoseFromFeatures(FeaturesOf(room, a, 0), FeaturesOf(room, b, 1), 20);
  ASSERT_TRUE(found.has_value());
  EXPECT_THAT(found->old_from_new, PoseNear(a.Inverse() * b, 0.03, 1.0));
  EXPECT_GT(found->num_inliers, 30);
  EXPECT_LT(found->num_rivals, found->num_inliers / 4);
  EXPECT_GT(found->spread_rad, 0.1);
}

TEST(PoseFromFeatures, OtherRoomsAndRepeatsGiveNoSurePose) {
  const TexturedRoom room;
  TexturedRoom other;
  other.seed = 2;
  const Pose3 a = Looking({-1, 0.2, 1.4}, 0.3);
  const Pose3 b = Looking({-0.7, 0.0, 1.5}, 0.5);
  EXPECT_FALSE(PoseFromFeatures(FeaturesOf(room, a, 0), FeaturesOf(other, b, 1), 20).has_value());
  // Tiles of four blocks all over a room of walls: nothing, a pose with rivals, or the true one.
  TexturedRoom tiled;
  tiled.period = 4;
  tiled.boxes.clear();
  for (const double x_m : {-0.9, -0.7, -0.5, -0.3}) {
    const Pose3 c = Looking({x_m, 0.0, 1.5}, 0.5);
    const auto repeat = PoseFromFeatures(FeaturesOf(tiled, a, 0), FeaturesOf(tiled, c, 1), 20);
    if (!repeat || 2 * repeat->num_rivals > repeat->num_inliers) continue;
    EXPECT_THAT(repeat->old_from_new, PoseNear(a.Inverse() * c, 0.05, 2.0));
  }
  EXPECT_FALSE(PoseFromFeatures({}, FeaturesOf(room, b, 1), 20).has_value());
}

TEST(FindSimilarKeyframes, NamesThePlaceOfARevisitAndLittleElse) {
  const TexturedRoom room;
  // 60 to the lap: keyframe 60 + k stands where k stood.
  const std::vector<KeyframeFeatures> features = FeaturesAlong(room, Round(76, 75.0 / 60.0));
  const SimilarityOptions options{20, 4, 0.3};
  const auto similar = FindSimilarKeyframes(features, options);
  ASSERT_EQ(similar.size(), features.size());
  int found = 0;
  for (std::size_t k = 0; k < similar.size(); ++k) {
    EXPECT_LE(similar[k].size(), 4u);
    for (const SimilarKeyframe& candidate : similar[k]) EXPECT_LE(candidate.index + 20, k);
    if (k >= 60 && !similar[k].empty() &&
        std::abs(static_cast<int>(similar[k].front().index) - static_cast<int>(k) + 60) <= 3) {
      ++found;
    }
  }
  EXPECT_GE(found, 14) << "of 16";
  const std::vector<KeyframeFeatures> none(30);
  for (const auto& list : FindSimilarKeyframes(none, options)) EXPECT_TRUE(list.empty());
  EXPECT_TRUE(FindSimilarKeyframes({}, options).empty());
}

TEST(AppearanceLoops, ATrueRevisitIsFoundAndItsDriftMeasured) {
  const TexturedRoom room;
  const std::vector<Pose3> truth = Round(76, 75.0 / 60.0);
  const std::vector<KeyframeFeatures> features = FeaturesAlong(room, truth);
  const Odometry odometry = Tracked(Drifted(truth, Drift(0.35, -0.2, 0.1)));
  const AppearanceOptions options;
  const std::vector<AppearanceLoop> proposed = ProposeAppearanceLoops(features, odometry, options);
  const AcceptedAppearance accepted =
      AcceptAppearanceLoops(proposed, RegisteredByTruth(proposed, truth), odometry, options);
  ASSERT_GE(accepted.edges.size(), 10u);
  for (const RelativePose& edge : accepted.edges) {
    EXPECT_GE(edge.j.value - edge.i.value, options.min_gap_keyframes);
    EXPECT_THAT(edge.i_from_j,
                PoseNear(truth[static_cast<std::size_t>(edge.i.value)].Inverse() *
                             truth[static_cast<std::size_t>(edge.j.value)],
                         0.03,
                         1.0));
    const Eigen::LLT<Matrix6d> factor(edge.information.Full());
    EXPECT_EQ(factor.info(), Eigen::Success) << "positive definite";
  }
}

TEST(AppearanceLoops, AWalkThatDoesNotComeBackHasNone) {
  const TexturedRoom room;
  const std::vector<Pose3> truth = Round(50, 0.7);
  EXPECT_TRUE(
      ProposeAppearanceLoops(FeaturesAlong(room, truth), Tracked(truth), AppearanceOptions())
          .empty());
}

// The second half is another room with the same look: only the path tells them apart.
TEST(AppearanceLoops, ALookAlikeFartherThanDriftIsRefused) {
  const TexturedRoom room;
  const std::vector<Pose3> here = Round(30, 0.4);
  std::vector<KeyframeFeatures> features = FeaturesAlong(room, here);
  std::vector<Pose3> poses = here;
  for (std::size_t k = 0; k < here.size(); ++k) {
    features.push_back(features[k]);
    features.back().keyframe = FrameIdx{static_cast<int>(poses.size())};
    Pose3 moved = here[k];
    moved.translation_m.x() += 6;
    poses.push_back(moved);
  }
  EXPECT_TRUE(ProposeAppearanceLoops(features, Tracked(poses), AppearanceOptions()).empty());
  // Where tracking was lost in between, nothing is known of the way.
  Odometry lost = Tracked(poses);
  lost.edges[29].composed = true;
  EXPECT_FALSE(ProposeAppearanceLoops(features, lost, AppearanceOptions()).empty());
}

TEST(AppearanceLoops, TilesAreNoPlace) {
  TexturedRoom tiled;
  tiled.period = 4;
  tiled.boxes.clear();
  const std::vector<Pose3> truth = Round(50, 0.7);
  const AppearanceOptions options;
  const Odometry odometry = Tracked(truth);
  for (const AppearanceLoop& loop :
       ProposeAppearanceLoops(FeaturesAlong(tiled, truth), odometry, options)) {
    ADD_FAILURE() << loop.old_keyframe.value << " " << loop.new_keyframe.value;
  }
}

AppearanceLoop Loop(const std::vector<Pose3>& truth, int i, int j, const Pose3& off = {}) {
  return {FrameIdx{i},
          FrameIdx{j},
          truth[static_cast<std::size_t>(i)].Inverse() * off * truth[static_cast<std::size_t>(j)],
          50,
          0,
          0,
          false,
          ""};
}

std::vector<int> AcceptedNewKeyframes(const AcceptedAppearance& result) {
  std::vector<int> accepted;
  for (const AppearanceLoop& loop : result.loops) {
    if (loop.accepted) accepted.push_back(loop.new_keyframe.value);
  }
  return accepted;
}

TEST(AcceptAppearanceLoops, NeedsNeighboursThatSayTheSame) {
  const std::vector<Pose3> truth = Round(76, 75.0 / 60.0);
  const Odometry odometry = Tracked(truth);
  const AppearanceOptions options;
  const std::vector<AppearanceLoop> alone = {Loop(truth, 1, 61)};
  const AcceptedAppearance refused =
      AcceptAppearanceLoops(alone, AsProposed(alone), odometry, options);
  EXPECT_TRUE(refused.edges.empty());
  EXPECT_NE(refused.loops.front().reason.find("neighbours"), std::string::npos);
  const std::vector<AppearanceLoop> three = {
      Loop(truth, 1, 61), Loop(truth, 3, 63), Loop(truth, 5, 65)};
  EXPECT_EQ(AcceptAppearanceLoops(three, AsProposed(three), odometry, options).edges.size(), 3u);
}

// Of a long path few keyframes are looked at, and those near each other lie further apart on it.
TEST(AcceptAppearanceLoops, NeighboursAreThoseThatWereLookedAt) {
  const std::vector<Pose3> truth = Round(90, 1.5);
  const Odometry odometry = Tracked(truth);
  const std::vector<AppearanceLoop> apart = {
      Loop(truth, 1, 61), Loop(truth, 17, 77), Loop(truth, 29, 89)};
  AppearanceOptions options;
  EXPECT_EQ(KeyframeStep(90, options), 1);
  EXPECT_TRUE(AcceptAppearanceLoops(apart, AsProposed(apart), odometry, options).edges.empty());
  options.max_keyframes = 12;
  EXPECT_EQ(KeyframeStep(90, options), 8);
  EXPECT_EQ(KeyframeStep(0, options), 1);
  EXPECT_EQ(AcceptAppearanceLoops(apart, AsProposed(apart), odometry, options).edges.size(), 3u);
}

TEST(AcceptAppearanceLoops, ContradictionsAreSettledByTheMajorityOrNotAtAll) {
  const std::vector<Pose3> truth = Round(80, 79.0 / 60.0);
  const Odometry odometry = Tracked(truth);
  AppearanceOptions options;
  options.drift_share = 0.02;
  const Pose3 elsewhere{Eigen::Quaterniond::Identity(), {0.9, 0.4, 0}};
  std::vector<AppearanceLoop> loops;
  for (int k = 0; k < 9; ++k) loops.push_back(Loop(truth, k, 60 + k));
  for (int k = 0; k < 3; ++k) loops.push_back(Loop(truth, 2 + k, 69 + k, elsewhere));
  const AcceptedAppearance majority =
      AcceptAppearanceLoops(loops, AsProposed(loops), odometry, options);
  EXPECT_EQ(AcceptedNewKeyframes(majority), (std::vector<int>{60, 61, 62, 63, 64, 65, 66, 67, 68}));
  for (int k = 3; k < 9; ++k) loops.push_back(Loop(truth, 2 + k, 69 + k, elsewhere));
  const AcceptedAppearance even =
      AcceptAppearanceLoops(loops, AsProposed(loops), odometry, options);
  EXPECT_TRUE(even.edges.empty());
  EXPECT_NE(even.loops.front().reason.find("ambiguous"), std::string::npos);
}

TEST(AcceptAppearanceLoops, RegistrationHasToBearThemOut) {
  const std::vector<Pose3> truth = Round(76, 75.0 / 60.0);
  const Odometry odometry = Tracked(truth);
  const AppearanceOptions options;
  const std::vector<AppearanceLoop> loops = {
      Loop(truth, 1, 61), Loop(truth, 3, 63), Loop(truth, 5, 65)};
  ExpectRegistrationToBearOut(loops, [&](const auto& registrations) {
    return AcceptAppearanceLoops(loops, registrations, odometry, options).edges.size();
  });
}

TEST(RefuseContradicted, DropsWhatTheSolutionDoesNotBearOut) {
  const std::vector<Pose3> truth = Round(76, 75.0 / 60.0);
  const Odometry odometry = Tracked(truth);
  const AppearanceOptions options;
  const std::vector<AppearanceLoop> loops = {
      Loop(truth, 1, 61), Loop(truth, 3, 63), Loop(truth, 5, 65)};
  AcceptedAppearance accepted = AcceptAppearanceLoops(loops, AsProposed(loops), odometry, options);
  EXPECT_FALSE(RefuseContradicted(odometry, options, accepted));
  Odometry moved = odometry;
  moved.frames[63].world_from_camera.translation_m.x() += 1;
  EXPECT_TRUE(RefuseContradicted(moved, options, accepted));
  EXPECT_EQ(AcceptedNewKeyframes(accepted), (std::vector<int>{61, 65}));
  EXPECT_EQ(accepted.edges.size(), 2u);
}

TEST(KeyframePath, WeakStretchesDriftByTheirWholeLength) {
  std::vector<Pose3> line(11);
  for (std::size_t k = 0; k < line.size(); ++k)
    line[k].translation_m.x() = 0.5 * static_cast<double>(k);
  Odometry odometry = Tracked(line);
  for (std::size_t k = 3; k < 5; ++k) odometry.frames[k].status = TrackingStatus::kDegenerate;
  const KeyframePath path(odometry, 0.1);
  EXPECT_DOUBLE_EQ(path.Length_m(0, 10), 5.0);
  EXPECT_DOUBLE_EQ(path.Length_m(10, 0), 5.0);
  EXPECT_DOUBLE_EQ(path.Drift_m(0, 10), 8 * 0.05 + 2 * 0.5);
  EXPECT_FALSE(path.Broken(0, 10));
  EXPECT_EQ(path.IndexOf(FrameIdx{99}), -1);
}

TEST(AppearanceLoops, TheNumberOfThreadsChangesNothing) {
  const TexturedRoom room;
  const std::vector<Pose3> truth = Round(76, 75.0 / 60.0);
  const std::vector<KeyframeFeatures> features = FeaturesAlong(room, truth);
  const Odometry odometry = Tracked(truth);
  const auto propose = [&](int threads) {
    const ThreadLimit limit(threads);
    return ProposeAppearanceLoops(features, odometry, AppearanceOptions());
  };
  const std::vector<AppearanceLoop> one = propose(1);
  const std::vector<AppearanceLoop> four = propose(4);
  ASSERT_EQ(one.size(), four.size());
  ASSERT_FALSE(one.empty());
  for (std::size_t k = 0; k < one.size(); ++k) {
    EXPECT_EQ(one[k].new_keyframe, four[k].new_keyframe);
    EXPECT_EQ(one[k].old_from_new, four[k].old_from_new);
  }
}

TEST(AppearanceLoops, NothingAndOff) {
  const TexturedRoom room;
  const AppearanceOptions options;
  EXPECT_TRUE(ProposeAppearanceLoops({}, {}, options).empty());
  EXPECT_TRUE(AcceptAppearanceLoops({}, {}, {}, options).edges.empty());
  const std::vector<Pose3> one = Round(2, 1.0);
  EXPECT_TRUE(
      ProposeAppearanceLoops(FeaturesAlong(room, {one.front()}), Tracked({one.front()}), options)
          .empty());
  // Keyframes that saw nothing all the way.
  const std::vector<Pose3> truth = Round(76, 75.0 / 60.0);
  EXPECT_TRUE(
      ProposeAppearanceLoops(std::vector<KeyframeFeatures>(76), Tracked(truth), options).empty());
  AppearanceOptions off;
  off.enabled = false;
  EXPECT_TRUE(ProposeAppearanceLoops(FeaturesAlong(room, truth), Tracked(truth), off).empty());
}

}  // namespace
}  // namespace deepslam::loop

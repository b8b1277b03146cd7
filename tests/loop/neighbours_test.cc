#include "deepslam/loop/neighbours.h"

#include <algorithm>
#include <iterator>
#include <span>

#include <gtest/gtest.h>

#include "deepslam/core/parallel.h"
#include "loop/registered_loops.h"
#include "loop/textured_room.h"
#include "support/pose_matchers.h"

namespace deepslam::loop {
namespace {

using ::deepslam::testing_support::PoseNear;
using testing_support::AsProposed;
using testing_support::ExpectRegistrationToBearOut;
using testing_support::FeaturesAlong;
using testing_support::Looking;
using testing_support::TexturedRoom;
using testing_support::Tracked;

// Sideways along a wall.
std::vector<Pose3> Along() {
  std::vector<Pose3> poses;
  for (int k = 0; k < 12; ++k) poses.push_back(Looking({-1 + 0.1 * k, 0.2, 1.4}, 0.3));
  return poses;
}

// From keyframe 6 on everything stands `slide` off.
std::vector<Pose3> Slid(std::vector<Pose3> poses, const Pose3& slide) {
  for (std::size_t k = 6; k < poses.size(); ++k) poses[k] = slide * poses[k];
  return poses;
}

std::vector<AppearanceLoop> ProposeAll(std::span<const KeyframeFeatures> features,
                                       const Odometry& odometry,
                                       bool depth_alone,
                                       const AppearanceOptions& options = {}) {
  return ProposeNeighbours(PoorlyMeasured(odometry, depth_alone), features, 0, options);
}

const Pose3 kSlide{Eigen::Quaterniond::Identity(), {0.5, 0.3, 0}};

TEST(Neighbours, WhatDepthAloneTrackedIsReregisteredWhereverItSlid) {
  const TexturedRoom room;
  const std::vector<Pose3> truth = Along();
  const Odometry slid = Tracked(Slid(truth, kSlide));
  const std::vector<AppearanceLoop> proposed = ProposeAll(FeaturesAlong(room, truth), slid, true);
  ASSERT_EQ(proposed.size(), slid.edges.size());
  for (std::size_t k = 0; k < proposed.size(); ++k) {
    EXPECT_EQ(proposed[k].old_keyframe, slid.edges[k].i);
    EXPECT_EQ(proposed[k].new_keyframe, slid.edges[k].j);
    const auto n = static_cast<std::size_t>(proposed[k].old_keyframe.value);
    EXPECT_THAT(proposed[k].old_from_new, PoseNear(truth[n].Inverse() * truth[n + 1], 0.03, 1.0));
  }
  const std::vector<RelativePose> edges = AcceptNeighbours(proposed, AsProposed(proposed));
  EXPECT_EQ(edges.size(), proposed.size());
}

TEST(Neighbours, WhatImagesTrackedStandsButAcrossALoss) {
  const TexturedRoom room;
  const std::vector<Pose3> truth = Along();
  const std::vector<KeyframeFeatures> features = FeaturesAlong(room, truth);
  EXPECT_TRUE(ProposeAll(features, Tracked(truth), false).empty());
  Odometry lost = Tracked(Slid(truth, kSlide));
  lost.edges[5].composed = true;  // from keyframe 5 to 6
  const std::vector<AppearanceLoop> proposed = ProposeAll(features, lost, false);
  EXPECT_GE(proposed.size(), 5u);
  EXPECT_LE(proposed.size(), 9u);
  for (const AppearanceLoop& pair : proposed) {
    EXPECT_GE(pair.old_keyframe.value, 3);
    EXPECT_LE(pair.old_keyframe.value, 5);
    EXPECT_GE(pair.new_keyframe.value, 6);
    EXPECT_LE(pair.new_keyframe.value, 8);
    const auto i = static_cast<std::size_t>(pair.old_keyframe.value);
    const auto j = static_cast<std::size_t>(pair.new_keyframe.value);
    EXPECT_THAT(pair.old_from_new, PoseNear(truth[i].Inverse() * truth[j], 0.04, 1.5));
  }
}

TEST(Neighbours, PieceByPieceAreThoseOfTheWhole) {
  const TexturedRoom room;
  const std::vector<Pose3> truth = Along();
  const std::vector<KeyframeFeatures> features = FeaturesAlong(room, truth);
  Odometry lost = Tracked(Slid(truth, kSlide));
  lost.edges[5].composed = true;
  const std::vector<NeighbourPair> pairs = PoorlyMeasured(lost, true);
  ASSERT_FALSE(pairs.empty());
  for (const NeighbourPair& pair : pairs) {
    EXPECT_LT(pair.older, pair.newer);
    EXPECT_LE(pair.newer - pair.older, kMostNeighbourGap);
  }
  const std::vector<AppearanceLoop> whole = ProposeNeighbours(pairs, features, 0, {});
  std::vector<AppearanceLoop> pieces;
  for (int newer = 0; newer < 12; ++newer) {  // one more keyframe at a time
    std::vector<NeighbourPair> own;
    std::ranges::copy_if(pairs, std::back_inserter(own), [&](const NeighbourPair& pair) {
      return pair.newer == newer;
    });
    const int first = std::max(0, newer - kMostNeighbourGap);
    const auto run = std::span(features).subspan(static_cast<std::size_t>(first),
                                                 static_cast<std::size_t>(newer + 1 - first));
    std::ranges::move(ProposeNeighbours(own, run, first, {}), std::back_inserter(pieces));
  }
  ASSERT_EQ(pieces.size(), whole.size());
  for (std::size_t k = 0; k < whole.size(); ++k) {
    EXPECT_EQ(pieces[k].old_keyframe, whole[k].old_keyframe);
    EXPECT_EQ(pieces[k].new_keyframe, whole[k].new_keyframe);
    EXPECT_EQ(pieces[k].old_from_new, whole[k].old_from_new);
  }
  EXPECT_TRUE(ProposeNeighbours(pairs, std::span(features).first(1), 0, {}).empty());
}

TEST(Neighbours, RegistrationHasToBearThemOut) {
  const TexturedRoom room;
  const std::vector<Pose3> truth = Along();
  const std::vector<AppearanceLoop> proposed =
      ProposeAll(FeaturesAlong(room, truth), Tracked(truth), true);
  ASSERT_FALSE(proposed.empty());
  ExpectRegistrationToBearOut(proposed, [&](const auto& registrations) {
    return AcceptNeighbours(proposed, registrations).size();
  });
}

TEST(Neighbours, TilesAndBareWallsGiveNothingWrong) {
  const std::vector<Pose3> truth = Along();
  TexturedRoom tiled;
  tiled.period = 4;
  tiled.boxes.clear();
  TexturedRoom bare;
  bare.contrast = 0;
  EXPECT_TRUE(ProposeAll(FeaturesAlong(bare, truth), Tracked(truth), true).empty());
  for (const AppearanceLoop& pair : ProposeAll(FeaturesAlong(tiled, truth), Tracked(truth), true)) {
    const auto n = static_cast<std::size_t>(pair.old_keyframe.value);
    EXPECT_THAT(pair.old_from_new, PoseNear(truth[n].Inverse() * truth[n + 1], 0.05, 2.0));
  }
}

TEST(Neighbours, NothingAndOff) {
  AppearanceOptions off;
  off.enabled = false;
  const TexturedRoom room;
  const std::vector<Pose3> truth = Along();
  const std::vector<KeyframeFeatures> features = FeaturesAlong(room, truth);
  EXPECT_TRUE(ProposeAll(features, Tracked(truth), true, off).empty());
  EXPECT_TRUE(ProposeAll({}, {}, true).empty());
  EXPECT_TRUE(ProposeAll({}, Tracked(truth), true).empty()) << "features are missing";
  EXPECT_TRUE(AcceptNeighbours({}, {}).empty());
}

TEST(Neighbours, TheNumberOfThreadsChangesNothing) {
  const TexturedRoom room;
  const std::vector<Pose3> truth = Along();
  const std::vector<KeyframeFeatures> features = FeaturesAlong(room, truth);
  const auto propose = [&](int threads) {
    const ThreadLimit limit(threads);
    return ProposeAll(features, Tracked(truth), true);
  };
  const std::vector<AppearanceLoop> one = propose(1);
  const std::vector<AppearanceLoop> four = propose(4);
  ASSERT_EQ(one.size(), four.size());
  for (std::size_t k = 0; k < one.size(); ++k) {
    EXPECT_EQ(one[k].new_keyframe, four[k].new_keyframe);
    EXPECT_EQ(one[k].old_from_new, four[k].old_from_new);
  }
}

}  // namespace
}  // namespace deepslam::loop

#include "deepslam/loop/covisible.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>
#include <set>
#include <utility>

#include <gtest/gtest.h>

#include "loop/textured_room.h"
#include "support/pose_matchers.h"

namespace deepslam::loop {
namespace {

using ::deepslam::testing_support::PoseNear;
using testing_support::Looking;
using testing_support::Tracked;

// A camera that sweeps to and fro between two views 92 deg apart, and sees the same again after 12.
std::vector<Pose3> Sweeping(int num_keyframes) {
  std::vector<Pose3> poses;
  for (int k = 0; k < num_keyframes; ++k)
    poses.push_back(Looking({0, 0.2, 1.4}, 0.8 * std::sin(2 * std::numbers::pi * k / 12)));
  return poses;
}

CovisibleOptions AllPairs() {
  CovisibleOptions options;
  options.max_pairs = 1000;
  return options;
}

// All of them.
std::vector<CovisiblePair> ProposeCovisible(const Odometry& odometry,
                                            const CovisibleOptions& options) {
  return CovisiblePairs(odometry, options).Next(std::numeric_limits<std::size_t>::max());
}

std::set<std::pair<int, int>> Positions(const std::vector<CovisiblePair>& pairs) {
  std::set<std::pair<int, int>> positions;
  for (const CovisiblePair& pair : pairs) positions.insert({pair.older, pair.newer});
  return positions;
}

std::vector<KeyframeRegistration> AsTracked(const std::vector<CovisiblePair>& pairs) {
  std::vector<KeyframeRegistration> registrations;
  for (const CovisiblePair& pair : pairs)
    registrations.push_back({true, pair.older_from_newer, 1e6 * Matrix6d::Identity(), 0.95, 0.9});
  return registrations;
}

TEST(Covisible, WhatASweepSeesAgainIsMeasuredAndWhatItDoesNotIsNot) {
  const std::vector<Pose3> truth = Sweeping(40);
  const auto pairs = Positions(ProposeCovisible(Tracked(truth), AllPairs()));
  for (int k = 0; k + 12 < 40; ++k) EXPECT_TRUE(pairs.contains({k, k + 12})) << k;
  EXPECT_FALSE(pairs.contains({3, 9})) << "the two ends of the sweep";
  for (int k = 0; k + 1 < 40; ++k) EXPECT_FALSE(pairs.contains({k, k + 1})) << "tracking's own";
}

TEST(Covisible, PosesAreTheTrackedOnesAndPairsComeOnceInOrder) {
  const std::vector<Pose3> truth = Sweeping(30);
  const std::vector<CovisiblePair> pairs = ProposeCovisible(Tracked(truth), {});
  ASSERT_GT(pairs.size(), 100u);
  EXPECT_EQ(Positions(pairs).size(), pairs.size());
  for (std::size_t k = 0; k < pairs.size(); ++k) {
    ASSERT_LT(pairs[k].older, pairs[k].newer);
    EXPECT_LE(pairs[k > 0 ? k - 1 : 0].newer, pairs[k].newer);
    const Pose3& older = truth[static_cast<std::size_t>(pairs[k].older)];
    const Pose3& newer = truth[static_cast<std::size_t>(pairs[k].newer)];
    EXPECT_THAT(pairs[k].older_from_newer, PoseNear(older.Inverse() * newer, 1e-9, 1e-6));
  }
}

TEST(Covisible, AFewAtATimeAreTheSame) {
  const Odometry odometry = Tracked(Sweeping(30));
  const std::vector<CovisiblePair> all = ProposeCovisible(odometry, {});
  for (const std::size_t most : {std::size_t{1}, std::size_t{7}, all.size()}) {
    CovisiblePairs pairs(odometry, {});
    std::vector<CovisiblePair> joined;
    while (true) {
      const std::vector<CovisiblePair> some = pairs.Next(most);
      joined.insert(joined.end(), some.begin(), some.end());
      if (some.size() < most) break;
    }
    ASSERT_EQ(joined.size(), all.size()) << most;
    for (std::size_t k = 0; k < all.size(); ++k) {
      EXPECT_EQ(std::pair(joined[k].older, joined[k].newer), std::pair(all[k].older, all[k].newer));
      EXPECT_EQ(joined[k].older_from_newer, all[k].older_from_newer);
    }
    EXPECT_TRUE(pairs.Next(most).empty());
  }
}

TEST(Covisible, WorkGrowsWithTheNumberOfKeyframes) {
  CovisibleOptions near;
  near.max_gap_keyframes = 12;
  const std::size_t once = ProposeCovisible(Tracked(Sweeping(60)), near).size();
  const std::size_t twice = ProposeCovisible(Tracked(Sweeping(120)), near).size();
  EXPECT_LE(twice, 2 * once + 12 * 12);
  for (const auto& [older, newer] : Positions(ProposeCovisible(Tracked(Sweeping(60)), near)))
    EXPECT_LE(newer - older, 12);
}

TEST(Covisible, AKeyframeIsRegisteredToFewSpreadOverThoseBeforeIt) {
  CovisibleOptions few;
  few.max_pairs = 4;
  const auto all = Positions(ProposeCovisible(Tracked(Sweeping(60)), AllPairs()));
  const auto pairs = Positions(ProposeCovisible(Tracked(Sweeping(60)), few));
  EXPECT_TRUE(std::ranges::includes(all, pairs));
  const int newer = 51;
  std::vector<int> olders;
  for (const auto& [i, j] : pairs) {
    if (j == newer) olders.push_back(i);
  }
  ASSERT_EQ(olders.size(), 4u);
  EXPECT_LT(olders.front(), newer / 3);
  EXPECT_GT(olders.back(), newer / 2);
  for (const auto& [i, j] : all) {
    if (j > 3) continue;
    EXPECT_TRUE(pairs.contains({i, j})) << "no more than there are";
  }
}

TEST(Covisible, NothingIsAssumedAcrossALoss) {
  Odometry lost = Tracked(Sweeping(40));
  lost.edges[19].composed = true;  // from keyframe 19 to 20
  const auto pairs = Positions(ProposeCovisible(lost, AllPairs()));
  EXPECT_TRUE(pairs.contains({5, 17}));
  EXPECT_TRUE(pairs.contains({22, 34}));
  for (const auto& [older, newer] : pairs) EXPECT_EQ(older < 20, newer < 20);
}

TEST(Covisible, RegistrationHasToBearThemOut) {
  const Odometry odometry = Tracked(Sweeping(30));
  const std::vector<CovisiblePair> pairs = ProposeCovisible(odometry, {});
  const auto accepted = [&](const auto& change) {
    std::vector<KeyframeRegistration> registrations = AsTracked(pairs);
    for (KeyframeRegistration& registration : registrations) change(registration);
    return AcceptCovisible(pairs, registrations, odometry).size();
  };
  const double nan = std::numeric_limits<double>::quiet_NaN();
  const Eigen::Quaterniond turned(Eigen::AngleAxisd(0.2, Eigen::Vector3d::UnitY()));
  EXPECT_EQ(accepted([](KeyframeRegistration&) {}), pairs.size());
  EXPECT_EQ(accepted([](KeyframeRegistration& r) { r.ok = false; }), 0u);
  EXPECT_EQ(accepted([](KeyframeRegistration& r) { r.agreement = 0.5; }), 0u);
  EXPECT_EQ(accepted([](KeyframeRegistration& r) { r.intensity_correlation = 0.3; }), 0u);
  EXPECT_EQ(accepted([](KeyframeRegistration& r) { r.old_from_new.translation_m.x() += 0.4; }), 0u);
  EXPECT_EQ(accepted([&](KeyframeRegistration& r) { r.old_from_new.rotation *= turned; }), 0u);
  EXPECT_EQ(accepted([&](KeyframeRegistration& r) { r.old_from_new.translation_m.x() = nan; }), 0u);
}

TEST(Covisible, EdgesAreTheRegistrations) {
  const Odometry odometry = Tracked(Sweeping(30));
  const std::vector<CovisiblePair> pairs = ProposeCovisible(odometry, {});
  std::vector<KeyframeRegistration> registrations = AsTracked(pairs);
  for (KeyframeRegistration& registration : registrations)
    registration.old_from_new.translation_m.x() += 0.02;
  const std::vector<RelativePose> edges = AcceptCovisible(pairs, registrations, odometry);
  ASSERT_EQ(edges.size(), pairs.size());
  for (std::size_t k = 0; k < edges.size(); ++k) {
    EXPECT_EQ(edges[k].i.value, pairs[k].older);
    EXPECT_EQ(edges[k].j.value, pairs[k].newer);
    EXPECT_EQ(edges[k].i_from_j, registrations[k].old_from_new);
    EXPECT_EQ(edges[k].information, registrations[k].information);
    EXPECT_FALSE(edges[k].composed);
  }
}

TEST(Covisible, WhatTheSolutionContradictsIsLeftOut) {
  const Odometry odometry = Tracked(Sweeping(30));
  const std::vector<CovisiblePair> pairs = ProposeCovisible(odometry, {});
  std::vector<RelativePose> edges = AcceptCovisible(pairs, AsTracked(pairs), odometry);
  const std::size_t all = edges.size();
  edges[3].i_from_j.translation_m.y() += 0.09;
  edges[7].i_from_j.rotation *=
      Eigen::Quaterniond(Eigen::AngleAxisd(0.06, Eigen::Vector3d::UnitX()));
  edges[9].i_from_j.translation_m.z() += 0.01;
  std::vector<RelativePose> kept = edges;
  std::erase_if(kept, [&](const RelativePose& edge) { return !IsConsistent(edge, odometry); });
  EXPECT_EQ(kept.size(), all - 2);
  for (const RelativePose& edge : kept) {
    EXPECT_FALSE(edge.i == edges[3].i && edge.j == edges[3].j);
    EXPECT_FALSE(edge.i == edges[7].i && edge.j == edges[7].j);
  }
}

TEST(Covisible, BrokenPosesAndEmptyPathsGiveNothing) {
  EXPECT_TRUE(ProposeCovisible({}, {}).empty());
  EXPECT_TRUE(AcceptCovisible({}, {}, {}).empty());
  Odometry broken = Tracked(Sweeping(20));
  for (TrackedFrame& frame : broken.frames)
    frame.world_from_camera.translation_m.x() = std::numeric_limits<double>::quiet_NaN();
  EXPECT_TRUE(ProposeCovisible(broken, {}).empty());
}

}  // namespace
}  // namespace deepslam::loop

// Rendered sequences, tracked, and held against the truth they were made from.
#pragma once

#include <algorithm>
#include <utility>
#include <vector>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "alignment/box_world.h"
#include "deepslam/dataset/memory_frame_source.h"
#include "deepslam/tracking/odometry.h"
#include "support/pose_matchers.h"

namespace deepslam::tracking {

using dataset::MemoryFrameSource;
using testing_support::Arc;
using testing_support::BoxWorld;
using testing_support::kRadPerDeg;
using testing_support::kSmallCamera;
using testing_support::LookAt;
using testing_support::PoseNear;
using testing_support::Render;
using testing_support::RenderFrame;

inline Odometry Track(std::vector<Frame> frames,
                      const OdometryOptions& options = {},
                      const PinholeCamera& camera = kSmallCamera) {
  const MemoryFrameSource source(camera, std::move(frames));
  SilentProgress progress;
  Result<Odometry> odometry = EstimateOdometry(source, options, progress);
  EXPECT_TRUE(odometry.ok());
  return std::move(odometry).value();
}

inline void ExpectTrue(const Odometry& odometry,
                       const std::vector<Pose3>& truth,
                       std::size_t begin,
                       std::size_t end,
                       double tolerance_m = 0.02,
                       double tolerance_deg = 0.6) {
  for (std::size_t k = begin; k < end; ++k) {
    EXPECT_THAT(
        odometry.frames[begin].world_from_camera.Inverse() * odometry.frames[k].world_from_camera,
        PoseNear(truth[begin].Inverse() * truth[k], tolerance_m, tolerance_deg))
        << "frame " << k;
  }
}

inline void ExpectConsistent(const Odometry& odometry) {
  EXPECT_TRUE(std::ranges::is_sorted(odometry.keyframes));
  for (std::size_t k = 1; k < odometry.keyframes.size(); ++k) {
    const bool joined = std::ranges::any_of(odometry.edges, [&](const RelativePose& edge) {
      return edge.i == odometry.keyframes[k - 1] && edge.j == odometry.keyframes[k];
    });
    EXPECT_TRUE(joined) << "keyframe " << odometry.keyframes[k];
  }
  for (const FrameIdx keyframe : odometry.keyframes)
    EXPECT_EQ(odometry.at(keyframe).keyframe, keyframe);
  for (const RelativePose& edge : odometry.edges) {
    EXPECT_EQ(edge.information.Full().llt().info(), Eigen::Success);
  }
}

inline void ExpectStatus(const Odometry& odometry,
                         std::size_t begin,
                         std::size_t end,
                         TrackingStatus status) {
  for (std::size_t k = begin; k < end; ++k)
    EXPECT_EQ(odometry.frames[k].status, status) << "frame " << k;
}

// Every edge that claims to be measured is as good as it claims.
inline void ExpectHonestEdges(const Odometry& odometry, const std::vector<Pose3>& truth) {
  for (const RelativePose& edge : odometry.edges) {
    if (edge.composed) continue;
    const Pose3 true_i_from_j = truth[static_cast<std::size_t>(edge.i.value)].Inverse() *
                                truth[static_cast<std::size_t>(edge.j.value)];
    const Vector6d error = T2v(edge.i_from_j.Inverse() * true_i_from_j);
    // Five standard deviations.
    EXPECT_LT(error.dot(edge.information.Full() * error), 25) << edge.i << " to " << edge.j;
  }
}

}  // namespace deepslam::tracking

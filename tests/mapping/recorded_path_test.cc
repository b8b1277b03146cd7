// A walk whose recorder (ARKit, a T265) drifts as such do, and that tracking loses for a while.
#include <cmath>
#include <numbers>
#include <optional>

#include <gmock/gmock.h>

#include "deepslam/core/angles.h"
#include "deepslam/geometry/trajectory_error.h"
#include "deepslam/mapping/recorded_edges.h"
#include "deepslam/mapping/track_path.h"
#include "mapping/walked_room.h"

namespace deepslam::mapping {
namespace {

using testing::HasSubstr;

constexpr int kNumFrames = 220;
// Frames between these show nothing: a hand before the camera.
constexpr std::pair<int, int> kHidden[] = {{60, 72}, {120, 150}};

// Once round the room and a third, half a metre a second.
std::vector<Pose3> Walk() {
  std::vector<Pose3> poses;
  for (int k = 0; k < kNumFrames; ++k) {
    const double angle = 2 * std::numbers::pi * 1.33 * k / (kNumFrames - 1);
    poses.push_back(Looking(
        {1.7 * std::cos(angle), 1.2 * std::sin(angle), 1.4 + 0.1 * std::sin(3 * angle)}, angle));
  }
  return poses;
}

bool IsHidden(int k) {
  return std::ranges::any_of(kHidden, [&](const auto& h) { return k >= h.first && k < h.second; });
}

// 1 % of the way and 2 degrees a minute, and some noise from frame to frame; in a world of its own.
std::vector<std::optional<Pose3>> Recorded(const std::vector<Pose3>& truth) {
  Random random(5, "recorder", 0);
  const Pose3 yaw{RotationFromVector({0, 2.0 / 600 * kRadPerDeg, 0}), Eigen::Vector3d::Zero()};
  std::vector<std::optional<Pose3>> recorded = {
      Pose3{RotationFromVector({0.3, -1, 2}), {7, -4, 1}}};
  for (std::size_t k = 1; k < truth.size(); ++k) {
    Pose3 motion = truth[k - 1].Inverse() * truth[k];
    motion.translation_m *= 1.01;
    Vector6d noise;
    for (int n = 0; n < 6; ++n) noise[n] = (n < 3 ? 0.0005 : 0.0003) * random.Normal();
    recorded.push_back(*recorded.back() * motion * yaw * V2t(noise));
  }
  return recorded;
}

dataset::MemoryFrameSource WalkedWith(const std::vector<Pose3>& truth,
                                      std::vector<std::optional<Pose3>> recorded,
                                      bool hidden) {
  std::vector<Frame> frames = FramesAlong({}, truth);
  for (int k = 0; hidden && k < kNumFrames; ++k) {
    if (!IsHidden(k)) continue;
    Frame& frame = frames[static_cast<std::size_t>(k)];
    std::fill(frame.depth_m.begin(), frame.depth_m.end(), 0.0F);
    std::fill(frame.colour.begin(), frame.colour.end(), Rgb8{60, 50, 45});
  }
  return {kCamera, std::move(frames), std::move(recorded)};
}

double Ate_m(const Odometry& odometry, const std::vector<Pose3>& truth) {
  std::vector<TimedPose> estimate, true_poses;
  for (std::size_t k = 0; k < truth.size(); ++k) {
    estimate.push_back({odometry.frames[k].time_s, odometry.frames[k].world_from_camera});
    true_poses.push_back({odometry.frames[k].time_s, truth[k]});
  }
  return ComputeTrajectoryError(estimate, true_poses, {})->ate_m.rmse;
}

struct Paths {
  Odometry track, capture, prior;
};

Paths AllPaths(const FrameSource& frames) {
  RecordingProgress progress;
  return {TrackPath(frames, {}, {}, InMemory(), progress)->odometry,
          TakePathOfCapture(frames, {}, progress)->odometry,
          TrackPath(frames, {}, {}, InMemory(), progress, RecordedPath::kAsPrior)->odometry};
}

TEST(RecordedPath, CarriesOnWhereTrackingIsLostAndIsCorrectedElsewhere) {
  const std::vector<Pose3> truth = Walk();
  const dataset::MemoryFrameSource frames = WalkedWith(truth, Recorded(truth), true);
  const Paths paths = AllPaths(frames);
  const double prior_m = Ate_m(paths.prior, truth);
  EXPECT_LE(prior_m, Ate_m(paths.capture, truth));
  EXPECT_LE(prior_m, Ate_m(paths.track, truth));
  EXPECT_TRUE(std::ranges::all_of(paths.prior.frames, IsAligned)) << "all frames are placed";
  EXPECT_FALSE(std::ranges::all_of(paths.track.frames, IsAligned)) << "some are hidden";
  for (int k = 0; k < kNumFrames; ++k) {
    if (IsHidden(k)) {
      EXPECT_NE(paths.prior.frames[static_cast<std::size_t>(k)].status, TrackingStatus::kTracked);
    }
  }
}

TEST(RecordedPath, DoesNoHarmWhereTrackingIsNeverLost) {
  const std::vector<Pose3> truth = Walk();
  const dataset::MemoryFrameSource frames = WalkedWith(truth, Recorded(truth), false);
  const Paths paths = AllPaths(frames);
  EXPECT_LE(Ate_m(paths.prior, truth), Ate_m(paths.capture, truth));
  // What the recorder adds is noise where everything is measured.
  EXPECT_LE(Ate_m(paths.prior, truth), 1.1 * Ate_m(paths.track, truth) + 0.0005);
}

TEST(RecordedPath, FramesWithoutAPoseAreTrackedAlone) {
  const std::vector<Pose3> truth = Walk();
  std::vector<std::optional<Pose3>> recorded = Recorded(truth);
  for (std::size_t k = 20; k < recorded.size(); k += 3) recorded[k].reset();
  for (std::size_t k = 150; k < recorded.size(); ++k) recorded[k].reset();
  const dataset::MemoryFrameSource frames = WalkedWith(truth, recorded, true);
  RecordingProgress progress;
  const auto path = TrackPath(frames, {}, {}, InMemory(), progress, RecordedPath::kAsPrior);
  ASSERT_TRUE(path.ok()) << path.error().message;
  EXPECT_EQ(path->odometry.frames.size(), truth.size());
}

TEST(RecordedPath, OfACaptureWithoutPosesIsRefused) {
  const dataset::MemoryFrameSource frames =
      SourceOf(FramesAlong({}, {Looking({0, 0, 1.4}, 0), Looking({0.02, 0, 1.4}, 0)}));
  RecordingProgress progress;
  const auto path = TrackPath(frames, {}, {}, InMemory(), progress, RecordedPath::kAsPrior);
  ASSERT_FALSE(path.ok());
  EXPECT_EQ(path.error().code, ErrorCode::kInvalidInput);
  EXPECT_THAT(path.error().message, HasSubstr("--poses track"));
}

// --- its noise

Pose3 Noisy(const Pose3& motion, double sigma_m, double sigma_rad, Random& random) {
  Vector6d noise;
  for (int n = 0; n < 6; ++n) noise[n] = (n < 3 ? sigma_m : sigma_rad) * random.Normal();
  return motion * V2t(noise);
}

TEST(RecordedNoise, IsFoundFromTheData) {
  const std::vector<Pose3> truth = Walk();
  const Odometry tracked = TrackedAs(truth);
  for (const double times : {1.0, 5.0}) {
    const double sigma_m = times * 0.004, sigma_rad = times * 0.004;
    Random random(3);
    std::vector<Pose3> recorded = {truth.front()};
    for (std::size_t k = 1; k < truth.size(); ++k)
      recorded.push_back(recorded.back() *
                         Noisy(truth[k - 1].Inverse() * truth[k], sigma_m, sigma_rad, random));
    const auto of = [&](FrameIdx frame) {
      return std::optional(recorded[static_cast<std::size_t>(frame.value)]);
    };
    const RecordedNoise noise = EstimateRecordedNoise(tracked, of, {1, 1});
    EXPECT_NEAR(noise.translation_m / sigma_m, 1, 0.2);
    EXPECT_NEAR(noise.rotation_rad / sigma_rad, 1, 0.2);
  }
}

TEST(RecordedNoise, OfTooLittleIsTheFallback) {
  const Odometry tracked = TrackedAs({Pose3(), Pose3(), Pose3()});
  const auto none = [](FrameIdx) { return std::optional<Pose3>(); };
  const RecordedNoise noise = EstimateRecordedNoise(tracked, none, {0.03, 0.02});
  EXPECT_EQ(noise.translation_m, 0.03);
  EXPECT_EQ(noise.rotation_rad, 0.02);
  EXPECT_TRUE(RecordedEdges(tracked, none, noise).empty());
}

TEST(RecordedEdges, JoinKeyframesThatHavePoses) {
  const std::vector<Pose3> truth = Walk();
  const Odometry tracked = TrackedAs({truth.begin(), truth.begin() + 6});
  const auto all_but_one = [&](FrameIdx frame) {
    return frame.value == 2 ? std::nullopt
                            : std::optional(truth[static_cast<std::size_t>(frame.value)]);
  };
  const std::vector<RelativePose> edges = RecordedEdges(tracked, all_but_one, {0.01, 0.02});
  ASSERT_EQ(edges.size(), 3U);
  EXPECT_EQ(edges[0].i.value, 0);
  EXPECT_EQ(edges[1].i.value, 3);
  const Matrix6d information = edges[0].information.Full();
  EXPECT_NEAR(information(0, 0), 1e4, 1e-6);
  EXPECT_NEAR(information(5, 5), 2500, 1e-6);
}

}  // namespace
}  // namespace deepslam::mapping

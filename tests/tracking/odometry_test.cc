#include "deepslam/tracking/odometry.h"

#include <algorithm>
#include <cmath>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "deepslam/alignment/image_pyramid.h"
#include "deepslam/core/parallel.h"
#include "deepslam/dataset/memory_frame_source.h"
#include "deepslam/tracking/pose_interpolation.h"
#include "tracking/tracked_sequence.h"

namespace deepslam::tracking {
namespace {

TEST(EstimateOdometry, FollowsAnArcThroughAFurnishedRoom) {
  const std::vector<Pose3> truth = Arc(30);
  const Odometry odometry = Track(Render(BoxWorld::Furnished(), truth));
  ASSERT_EQ(odometry.frames.size(), truth.size());
  EXPECT_EQ(odometry.frames.front().world_from_camera, Pose3{});
  for (const TrackedFrame& frame : odometry.frames)
    EXPECT_EQ(frame.status, TrackingStatus::kTracked);
  EXPECT_GE(odometry.keyframes.size(), 4U);
  ExpectTrue(odometry, truth, 0, truth.size());
  ExpectConsistent(odometry);
}

class EstimateOdometryNoise : public ::testing::TestWithParam<double> {};

// Stereo cameras are three to four times as noisy as the model that the options state.
TEST_P(EstimateOdometryNoise, FollowsAnArcWithDepthNoisierThanTheModel) {
  const std::vector<Pose3> truth = Arc(12);
  const Odometry odometry = Track(Render(BoxWorld::Furnished(), truth, GetParam()));
  ASSERT_EQ(odometry.frames.size(), truth.size());
  for (const TrackedFrame& frame : odometry.frames)
    EXPECT_EQ(frame.status, TrackingStatus::kTracked) << "frame " << frame.frame;
  ExpectTrue(odometry, truth, 0, truth.size(), 0.03, 0.8);
  ExpectConsistent(odometry);
}

// Errors of square blocks of pixels, as block matching makes them: invisible between neighbours.
std::vector<Frame> RenderWithBlocks(const std::vector<Pose3>& poses, double noise, int block_px) {
  const std::vector<Frame> exact = Render(BoxWorld::Furnished(), poses, 0.0);
  std::vector<Frame> frames = Render(BoxWorld::Furnished(), poses, noise);
  for (std::size_t k = 0; k < frames.size(); ++k) {
    const DepthImage noisy = frames[k].depth_m;
    for (int v = 0; v < noisy.height(); ++v) {
      for (int u = 0; u < noisy.width(); ++u) {
        const int block_u = u / block_px * block_px, block_v = v / block_px * block_px;
        frames[k].depth_m(u, v) =
            exact[k].depth_m(u, v) + noisy(block_u, block_v) - exact[k].depth_m(block_u, block_v);
      }
    }
  }
  return frames;
}

TEST(EstimateOdometry, FollowsAnArcWithNoiseSharedBetweenNeighbours) {
  const std::vector<Pose3> truth = Arc(8);
  const Odometry odometry = Track(RenderWithBlocks(truth, 8.0, 4));
  for (const TrackedFrame& frame : odometry.frames)
    EXPECT_EQ(frame.status, TrackingStatus::kTracked) << "frame " << frame.frame;
  ExpectTrue(odometry, truth, 0, truth.size(), 0.05, 1.5);
}

// Noise shared over more pixels than it is looked for in is underrated, and few depths agree by it.
TEST(EstimateOdometry, ImagesThatAgreeMakeUpForUnderratedNoise) {
  const std::vector<Pose3> truth = Arc(8);
  std::vector<Frame> frames = RenderWithBlocks(truth, 6.0, 20);
  const Odometry odometry = Track(frames);
  for (const TrackedFrame& frame : odometry.frames)
    EXPECT_EQ(frame.status, TrackingStatus::kTracked) << "frame " << frame.frame;
  ExpectTrue(odometry, truth, 0, truth.size(), 0.06, 1.5);
  // Without images the same depth says too little.
  for (Frame& frame : frames) frame.colour = ColourImage();
  const Odometry without = Track(std::move(frames));
  EXPECT_TRUE(std::ranges::any_of(without.frames, [](const TrackedFrame& frame) {
    return frame.status == TrackingStatus::kLost;
  }));
}

// Such depth leaves every alignment doubtful, also where images show that it is right.
TEST(EstimateOdometry, ImagesThatAgreeCarrySubTrajectoriesOverDespiteUnderratedNoise) {
  std::vector<Pose3> truth = Arc(6, 1.0);
  const std::vector<Pose3> round = Arc(31, 2.0);
  for (std::size_t k = 0; k < round.size(); ++k) truth.push_back(round[round.size() - 1 - k]);
  const Odometry odometry = Track(RenderWithBlocks(truth, 4.0, 20));
  const Pose3 end =
      odometry.frames[0].world_from_camera.Inverse() * odometry.frames.back().world_from_camera;
  EXPECT_THAT(end, PoseNear(truth[0].Inverse() * truth.back(), 0.06, 1.5));
}

INSTANTIATE_TEST_SUITE_P(TimesTheModel, EstimateOdometryNoise, ::testing::Values(4.0, 8.0));

TEST(EstimateOdometry, PlainFrameToFrameIcpIsAConfiguration) {
  OdometryOptions options;
  options.reference = "previous";
  options.alignment.photometric = false;
  options.rotation_search = false;
  const std::vector<Pose3> truth = Arc(15);
  const Odometry odometry = Track(Render(BoxWorld::Furnished(), truth), options);
  ExpectTrue(odometry, truth, 0, truth.size(), 0.04, 1.5);
  ExpectConsistent(odometry);
  EXPECT_EQ(odometry.edges.size(), odometry.keyframes.size() - 1);
}

// Along a bare wall depth shows no motion; what was predicted from a prediction is less sure each
// time.
TEST(EstimateOdometry, AMotionThatNothingShowsAges) {
  BoxWorld hall;
  hall.room = {{-20, -20, 0}, {20, 2.6, 20}};
  std::vector<Pose3> poses;
  for (int k = 0; k < 7; ++k)
    poses.push_back(LookAt({0.02 * k, 0, 1.5}, {0.3 + 0.1 * k, 2.6, 0.9}));
  OdometryOptions options;
  options.reference = "previous";
  options.alignment.photometric = false;
  options.rotation_search = false;
  options.keyframe_angle_deg = 0.5;  // every frame
  const Odometry odometry = Track(Render(hall, poses), options);
  std::vector<double> along_m;  // x of the camera is along the wall
  for (const RelativePose& edge : odometry.edges)
    along_m.push_back(std::sqrt(edge.information.Full().inverse()(0, 0)));
  ASSERT_GE(along_m.size(), 4U);
  // The first edge has no motion to go by.
  for (std::size_t k = 2; k < along_m.size(); ++k) EXPECT_GT(along_m[k], along_m[k - 1]) << k;
}

TEST(EstimateOdometry, SurvivesFastTurnsAndBigSteps) {
  const BoxWorld world = BoxWorld::Furnished();
  std::vector<Pose3> truth;
  for (int k = 0; k < 6; ++k) {
    const double pan = (k % 2 == 0 ? 0.0 : 16.0) * kRadPerDeg;
    truth.push_back(
        LookAt({-1.6, -0.3, 1.4}, {-1.6 + 2 * std::cos(pan), -0.3 + 2 * std::sin(pan), 0.6}));
  }
  ExpectTrue(Track(Render(world, truth)), truth, 0, truth.size());
  const std::vector<Pose3> steps = Arc(6, 9.0);  // 0.24 m and 9 deg each
  ExpectTrue(Track(Render(world, steps)), steps, 0, steps.size(), 0.03, 1.0);
}

TEST(EstimateOdometry, CoveredLensAndUnreadableFramesSaySoAndTheRestStaysRight) {
  const std::vector<Pose3> truth = Arc(24, 1.0);
  std::vector<Frame> frames = Render(BoxWorld::Furnished(), truth);
  for (std::size_t k = 10; k < 13; ++k) std::ranges::fill(frames[k].depth_m, 0.0F);
  frames[15] = Frame{};
  const Odometry odometry = Track(std::move(frames));
  for (std::size_t k = 0; k < truth.size(); ++k) {
    const TrackingStatus expected = k >= 10 && k < 13 ? TrackingStatus::kLost
                                    : k == 15         ? TrackingStatus::kUnreadable
                                                      : TrackingStatus::kTracked;
    EXPECT_EQ(odometry.frames[k].status, expected) << "frame " << k;
  }
  // Lost frames are interpolated between their neighbours: good to the curvature of the path.
  ExpectTrue(odometry, truth, 0, truth.size(), 0.03, 1.0);
  ExpectConsistent(odometry);
}

TEST(EstimateOdometry, TwoCapturesInOneAreJoinedByAnEdgeThatSaysSo) {
  const std::vector<Pose3> first = Arc(8);
  BoxWorld other;
  other.texture_phase = 2;
  other.boxes = {{{-0.3, -0.2, 0}, {0.4, 1.0, 1.5}}, {{-1.5, 1, 0}, {-0.5, 1.8, 0.5}}};
  std::vector<Pose3> second;
  for (int k = 0; k < 8; ++k)
    second.push_back(LookAt({1.6 - 0.02 * k, 1.5, 1.0}, {-0.5, 0.2, 0.8}));
  std::vector<Frame> frames = Render(BoxWorld::Furnished(), first);
  for (Frame& frame : Render(other, second)) frames.push_back(std::move(frame));
  for (std::size_t k = 0; k < frames.size(); ++k) frames[k].time_s = 0.05 * static_cast<double>(k);
  const Odometry odometry = Track(std::move(frames));
  EXPECT_EQ(odometry.frames[8].status, TrackingStatus::kLost);
  std::vector<Pose3> truth = first;
  truth.insert(truth.end(), second.begin(), second.end());
  ExpectTrue(odometry, truth, 0, 8);
  ExpectTrue(odometry, truth, 8, 16);
  ExpectConsistent(odometry);
  const auto across = std::ranges::find_if(odometry.edges, [](const RelativePose& edge) {
    return edge.i.value < 8 && edge.j.value >= 8;
  });
  ASSERT_NE(across, odometry.edges.end());
  EXPECT_TRUE(across->composed);
  EXPECT_LT(across->information.Full()(0, 0),
            0.01 * odometry.edges.front().information.Full()(0, 0));
}

TEST(EstimateOdometry, IsByteEqualForAnyNumberOfThreads) {
  const std::vector<Frame> frames = Render(BoxWorld::Furnished(), Arc(12));
  const auto track = [&](int num_threads) {
    const ThreadLimit limit(num_threads);
    return Track(frames);
  };
  const Odometry one = track(1);
  const Odometry two = track(2);
  ASSERT_EQ(one.frames.size(), two.frames.size());
  for (std::size_t k = 0; k < one.frames.size(); ++k) {
    EXPECT_EQ(one.frames[k].world_from_camera, two.frames[k].world_from_camera);
    EXPECT_EQ(one.frames[k].rmse_m, two.frames[k].rmse_m);
  }
  ASSERT_EQ(one.edges.size(), two.edges.size());
  for (std::size_t k = 0; k < one.edges.size(); ++k)
    EXPECT_EQ(one.edges[k].information, two.edges[k].information);
}

// What others would read again.
TEST(EstimateOdometry, HandsOverKeyframesAsTheyWereRead) {
  const std::vector<Frame> frames = Render(BoxWorld::Furnished(), Arc(14));
  const MemoryFrameSource source(kSmallCamera, frames);
  const OdometryOptions options;
  SilentProgress progress;
  std::vector<ReadKeyframe> taken;
  const auto take = [&](ReadKeyframe keyframe) { taken.push_back(std::move(keyframe)); };
  const Result<Odometry> odometry = EstimateOdometry(source, options, progress, take);
  ASSERT_TRUE(odometry.ok());
  ASSERT_GT(odometry->keyframes.size(), 2U);
  std::vector<FrameIdx> frames_taken;
  for (const ReadKeyframe& keyframe : taken) {
    frames_taken.push_back(keyframe.frame);
    EXPECT_EQ(keyframe.depth_m, frames[static_cast<std::size_t>(keyframe.frame.value)].depth_m);
    const Result<alignment::ReadFrame> read =
        alignment::ReadPyramid(source, keyframe.frame, options.alignment.pyramid);
    ASSERT_TRUE(read.ok());
    EXPECT_EQ(keyframe.pyramid->levels.front().depth_m, read->pyramid.levels.front().depth_m);
  }
  EXPECT_EQ(frames_taken, odometry->keyframes);
}

TEST(EstimateOdometry, RefusesCapturesWithNothingToTrack) {
  SilentProgress progress;
  const auto error_of = [&](std::vector<Frame> frames) {
    const Result<Odometry> odometry = EstimateOdometry(
        MemoryFrameSource(kSmallCamera, std::move(frames)), OdometryOptions{}, progress);
    return odometry.ok() ? std::string("none") : odometry.error().message;
  };
  EXPECT_THAT(error_of({}), testing::HasSubstr("no frames"));
  EXPECT_THAT(error_of(std::vector<Frame>(5)),
              testing::HasSubstr("5 of 5 frames could not be read"));
  std::vector<Frame> dark = Render(BoxWorld::Furnished(), Arc(3));
  for (Frame& frame : dark) std::ranges::fill(frame.depth_m, 0.0F);
  EXPECT_THAT(error_of(std::move(dark)), testing::HasSubstr("no frame has usable depth"));
}

TEST(OdometryFromCapturePoses, TakesPosesOverAndFillsGaps) {
  const std::vector<Pose3> truth = Arc(12);
  std::vector<std::optional<Pose3>> poses(truth.begin(), truth.end());
  poses[0].reset();
  poses[5].reset();
  poses[7] = Pose3{Eigen::Quaterniond(0, 0, 0, 0), Eigen::Vector3d::Constant(std::nan(""))};
  const MemoryFrameSource source(kSmallCamera, Render(BoxWorld::Furnished(), truth), poses);
  SilentProgress progress;
  const Result<Odometry> odometry = OdometryFromCapturePoses(source, OdometryOptions{}, progress);
  ASSERT_TRUE(odometry.ok());
  EXPECT_THAT(odometry->frames[1].world_from_camera, PoseNear(Pose3{}, 1e-9, 1e-6));
  for (const std::size_t k : {0U, 5U, 7U})
    EXPECT_EQ(odometry->frames[k].status, TrackingStatus::kLost);
  for (std::size_t k = 1; k < truth.size(); ++k) {
    const bool given = k != 5 && k != 7;
    EXPECT_THAT(odometry->frames[k].world_from_camera,
                PoseNear(truth[1].Inverse() * truth[k], given ? 1e-9 : 0.01, given ? 1e-6 : 0.5));
  }
  EXPECT_EQ(odometry->keyframes.front(), FrameIdx{1});
  ExpectConsistent(*odometry);
}

TEST(OdometryFromCapturePoses, MarksUnreadableFramesAndRefusesMostlyBadCaptures) {
  const std::vector<Pose3> truth = Arc(6);
  const auto with_bad = [&](std::size_t num_bad) {
    std::vector<Frame> frames = Render(BoxWorld::Furnished(), truth);
    std::fill_n(frames.begin(), num_bad, Frame());
    const MemoryFrameSource source(kSmallCamera, std::move(frames), {truth.begin(), truth.end()});
    SilentProgress progress;
    return OdometryFromCapturePoses(source, OdometryOptions{}, progress);
  };
  const Result<Odometry> some = with_bad(2);
  ASSERT_TRUE(some.ok());
  EXPECT_EQ(some->frames[1].status, TrackingStatus::kUnreadable);
  EXPECT_EQ(some->keyframes.front(), FrameIdx{2});
  EXPECT_THAT(some->frames[4].world_from_camera,
              PoseNear(truth[0].Inverse() * truth[4], 1e-9, 1e-6));
  const Result<Odometry> most = with_bad(4);
  ASSERT_FALSE(most.ok());
  EXPECT_THAT(most.error().message, testing::HasSubstr("4 of 6 frames could not be read"));
}

TEST(OdometryFromCapturePoses, NamesTheMissingFile) {
  const MemoryFrameSource source(kSmallCamera, Render(BoxWorld::Furnished(), Arc(2)));
  SilentProgress progress;
  const Result<Odometry> odometry = OdometryFromCapturePoses(source, OdometryOptions{}, progress);
  ASSERT_FALSE(odometry.ok());
  EXPECT_EQ(odometry.error().code, ErrorCode::kInvalidInput);
  EXPECT_THAT(odometry.error().message, testing::HasSubstr("groundtruth.txt"));
}

TEST(InterpolateMissing, GoesByTimeAndCarriesTheEnds) {
  const Pose3 a;
  const Pose3 b = V2t((Vector6d() << 4, 0, 0, 0, 0, 0.8).finished());
  const std::vector<std::optional<Pose3>> poses = {std::nullopt, a, std::nullopt, b, std::nullopt};
  const std::vector<double> times = {0, 1, 2, 5, 6};
  const std::vector<Pose3> filled = InterpolateMissing(poses, times);
  EXPECT_EQ(filled[0], a);
  EXPECT_THAT(filled[2], PoseNear(V2t((Vector6d() << 1, 0, 0, 0, 0, 0.2).finished()), 1e-12, 1e-6));
  EXPECT_EQ(filled[4], b);
  // Clocks that stand still: by position.
  EXPECT_NEAR(
      InterpolateMissing(poses, std::vector<double>(5, 3.0))[2].translation_m.x(), 2.0, 1e-12);
}

}  // namespace
}  // namespace deepslam::tracking

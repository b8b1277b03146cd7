// A camera that turns on the spot before a bare wall over a floor: depth fixes five degrees of
// freedom, and along the wall there is nothing but its edge with the floor, as JPEG has it.
#include <cmath>
#include <cstdint>
#include <vector>

#include <gmock/gmock.h>

#include "deepslam/image_codec/decode.h"
#include "deepslam/image_codec/jpeg.h"
#include "tracking/tracked_sequence.h"

namespace deepslam::tracking {
namespace {

// A hall with furniture at both ends of a long wall without any texture.
BoxWorld Hall(double texture) {
  BoxWorld hall;
  hall.room = {{-6, -3, 0}, {6, 2.2, 2.7}};
  hall.boxes = {{{-3.4, 0.4, 0}, {-2.6, 1.3, 0.8}},
                {{-4.6, 1.3, 0}, {-3.8, 2.2, 1.9}},
                {{2.7, 0.3, 0}, {3.4, 1.2, 0.9}},
                {{3.8, 1.2, 0}, {4.7, 2.2, 1.7}}};
  hall.texture = texture;
  hall.floor_darker = 70;
  return hall;
}

// Past the wall from end to end, a step at a time; the hand that holds it moves a little.
std::vector<Pose3> TurnOnTheSpot(double step_deg) {
  std::vector<Pose3> poses;
  for (double deg = 155; deg > 25; deg -= step_deg) {
    const double angle = deg * kRadPerDeg;
    const Eigen::Vector3d eye(0.01 * std::cos(3 * angle), 0.01 * std::sin(2 * angle), 1.4);
    poses.push_back(LookAt(eye, eye + Eigen::Vector3d(std::cos(angle), std::sin(angle), -0.3)));
  }
  return poses;
}

void CompressColour(std::vector<Frame>& frames) {
  for (Frame& frame : frames) {
    const auto packed = image_codec::EncodeJpeg(frame.colour, 80);
    ASSERT_TRUE(packed.ok());
    auto unpacked = image_codec::DecodeColour(*packed);
    ASSERT_TRUE(unpacked.ok());
    frame.colour = *std::move(unpacked);
  }
}

double DistanceAlong_m(const Odometry& odometry, const std::vector<Pose3>& truth, std::size_t k) {
  const Pose3 is =
      odometry.frames[0].world_from_camera.Inverse() * odometry.frames[k].world_from_camera;
  return (is.translation_m - (truth[0].Inverse() * truth[k]).translation_m).norm();
}

class BareWall : public ::testing::TestWithParam<double> {};

TEST_P(BareWall, IsNotSlidAlongOnATurn) {
  const std::vector<Pose3> truth = TurnOnTheSpot(GetParam());
  std::vector<Frame> frames = Render(Hall(0), truth, 0.0);
  CompressColour(frames);
  const Odometry odometry = Track(std::move(frames));
  int num_unsure = 0;
  for (std::size_t k = 0; k < truth.size(); ++k) {
    const TrackingStatus status = odometry.frames[k].status;
    num_unsure += status == TrackingStatus::kTracked ? 0 : 1;
    if (status == TrackingStatus::kLost) continue;
    // What a hand may do unseen in half a second: the motion before is carried on.
    EXPECT_LT(DistanceAlong_m(odometry, truth, k), 0.1) << "frame " << k;
  }
  EXPECT_GT(num_unsure, 0) << "nothing shows where the camera is along the wall";
  ExpectHonestEdges(odometry, truth);
}

INSTANTIATE_TEST_SUITE_P(StepsDeg, BareWall, ::testing::Values(4.0, 8.0, 12.0));

// What images show along a wall is followed, also where depth shows nothing of it.
TEST(WallWithAPicture, IsFollowedAlongItself) {
  BoxWorld hall = Hall(0.3);
  hall.boxes.clear();
  std::vector<Pose3> truth;
  for (int k = 0; k < 25; ++k) {
    // Faster and slower, which no motion model foresees.
    const double x = -0.6 + 0.05 * k + 0.06 * std::sin(0.7 * k);
    truth.push_back(LookAt({x, 0.2, 1.4}, {x + 0.1, 2.2, 1.1}));
  }
  std::vector<Frame> frames = Render(hall, truth, 0.0);
  CompressColour(frames);
  ExpectTrue(Track(std::move(frames)), truth, 0, truth.size(), 0.02, 0.6);
}

// The grain of its paint is followed as well, a grey level or two, on turns that speed up and slow
// down.
TEST(GrainedWall, IsFollowedAlongItself) {
  constexpr PinholeCamera kCamera{640, 480, 524, 524, 319.5, 239.5};
  BoxWorld hall = Hall(0);
  hall.grain_greys = 2;
  hall.boxes.clear();
  std::vector<Pose3> truth;
  std::vector<Frame> frames;
  double x = -1.2;
  for (int k = 0; k < 25; ++k) {
    x += 0.03 + 0.03 * std::sin(0.8 * k);
    truth.push_back(LookAt({x, 0.8, 1.4}, {x + 0.4 * std::sin(0.3 * k), 2.2, 1.4}));
    frames.push_back(RenderFrame(hall, truth.back(), 1.0, frames.size(), kCamera));
    frames.back().time_s = 0.1 * k;
  }
  ExpectTrue(Track(std::move(frames), {}, kCamera), truth, 0, truth.size(), 0.02, 1.0);
}

}  // namespace
}  // namespace deepslam::tracking

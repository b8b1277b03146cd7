#include <gmock/gmock.h>

#include "deepslam/layouts/open_capture.h"
#include "support/test_data.h"

namespace deepslam::layouts {
namespace {

TEST(RealCapture, EveryFrameReadsAndMostPixelsHaveDepth) {
  DEEPSLAM_REQUIRE_TEST_DATA(data);
  const Result<dataset::Capture> capture = OpenCapture(data / "data/redkitchen");
  ASSERT_TRUE(capture.ok()) << capture.error().message;
  EXPECT_TRUE(capture->has_poses);
  EXPECT_THAT(capture->warnings, testing::IsEmpty());
  ASSERT_EQ(capture->frames->num_frames(), 500);
  for (int i = 0; i < 500; i += 25) {
    const Result<Frame> frame = capture->frames->Read(FrameIdx{i});
    ASSERT_TRUE(frame.ok()) << frame.error().message;
    const auto num_valid = std::count_if(
        frame->depth_m.begin(), frame->depth_m.end(), [](float d) { return d > 0.4f && d < 6.0f; });
    EXPECT_GT(num_valid, 640 * 480 / 2) << "frame " << i;
  }
}

// The same point of the room, seen from two frames by the capture's own poses, lies at one place:
// checks that poses, depth units and intrinsics are understood the way they are meant.
TEST(RealCapture, PosesDepthAndIntrinsicsFitTogether) {
  DEEPSLAM_REQUIRE_TEST_DATA(data);
  for (const char* name : {"data/redkitchen", "data/fr3_cabinet"}) {
    const Result<dataset::Capture> capture = OpenCapture(data / name);
    ASSERT_TRUE(capture.ok()) << capture.error().message;
    const FrameSource& frames = *capture->frames;
    const PinholeCamera& camera = frames.camera();
    const FrameIdx a{10};
    const FrameIdx b{12};
    const Frame frame_a = *frames.ReadDepth(a);
    const Frame frame_b = *frames.ReadDepth(b);
    const Pose3 b_from_a =
        frames.capture_world_from_camera(b)->Inverse() * *frames.capture_world_from_camera(a);
    std::vector<double> differences_m;
    for (int v = 40; v < 440; v += 10) {
      for (int u = 40; u < 600; u += 10) {
        if (frame_a.depth_m(u, v) <= 0) continue;
        const Eigen::Vector3d p_b = b_from_a * camera.Unproject(u, v, frame_a.depth_m(u, v));
        const std::optional<Eigen::Vector2d> q = camera.Project(p_b);
        if (!q) continue;
        const int u_b = static_cast<int>(std::lround(q->x()));
        const int v_b = static_cast<int>(std::lround(q->y()));
        if (!frame_b.depth_m.Contains(u_b, v_b) || frame_b.depth_m(u_b, v_b) <= 0) continue;
        differences_m.push_back(std::abs(frame_b.depth_m(u_b, v_b) - p_b.z()));
      }
    }
    ASSERT_GT(differences_m.size(), 500u) << name;
    std::nth_element(differences_m.begin(),
                     differences_m.begin() + static_cast<std::ptrdiff_t>(differences_m.size() / 2),
                     differences_m.end());
    // Kinect noise at 2 m is about 6 mm; truth adds about a centimetre.
    EXPECT_LT(differences_m[differences_m.size() / 2], 0.03) << name;
  }
}

}  // namespace
}  // namespace deepslam::layouts

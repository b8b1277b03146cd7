// What frame j brings to an alignment is what it would show as a reference.
#include "deepslam/alignment/source_points.h"

#include <cstddef>
#include <cstdint>

#include <gtest/gtest.h>

#include "alignment/box_world.h"
#include "deepslam/alignment/reference_pixels.h"

namespace deepslam::alignment {
namespace {

using testing_support::BoxWorld;
using testing_support::kSmallCamera;
using testing_support::LookAt;
using testing_support::RenderFrame;

FramePyramid Furnished(const Pose3& world_from_camera, std::uint64_t seed = 1) {
  const Frame frame = RenderFrame(BoxWorld::Furnished(), world_from_camera, 1.0, seed);
  return AsReference(BuildPyramid(frame, kSmallCamera, {}));
}

const Pose3 kWorldFromI = LookAt({1.6, -1.9, 1.4}, {0, 0, 0.4});

bool Equal(const PackedPixel& packed, const SurfacePixel& pixel) {
  return packed.a == pixel.nx && packed.b == pixel.ny && packed.c == pixel.nz &&
         packed.d == pixel.offset_m;
}

bool Equal(const PackedPixel& packed, const IntensityPixel& pixel) {
  return packed.a == pixel.value && packed.b == pixel.du && packed.c == pixel.dv;
}

TEST(SourcePoints, ShowWhatTheFrameShowsAsAReference) {
  for (const PyramidLevel& level : Furnished(kWorldFromI).levels) {
    for (const int stride : {1, 3}) {
      const SourcePoints points(level, {stride, true, true});
      int num_points = 0;
      for (const SourceRow& row : points.rows()) {
        for (std::size_t n = row.begin; n < row.end; ++n) {
          if (!(points.depth_m()[n] > 0)) continue;  // fills the lanes
          const std::size_t pixel = static_cast<std::size_t>(row.v * level.camera.width +
                                                             static_cast<int>(points.column()[n]));
          EXPECT_EQ(points.depth_m()[n], level.depth_m[pixel]);
          EXPECT_TRUE(Equal(points.surface()[n], level.surface[pixel])) << row.v;
          EXPECT_TRUE(Equal(points.intensity()[n], level.gradients[pixel])) << row.v;
          EXPECT_EQ(points.has_normal()[n], level.surface[pixel].offset_m < 0 ? 1 : 0);
          ++num_points;
        }
      }
      EXPECT_GT(num_points, level.camera.width * level.camera.height / (2 * stride * stride));
    }
  }
}

TEST(SourcePoints, WithoutIntensityHaveNoTexture) {
  const FramePyramid pyramid = Furnished(kWorldFromI);
  const SourcePoints points(pyramid.levels.front(), {2, false, false});
  ASSERT_GT(points.size(), 0U);
  for (std::size_t n = 0; n < points.size(); ++n) EXPECT_EQ(points.has_texture()[n], 0);
}

}  // namespace
}  // namespace deepslam::alignment

#include "deepslam/presentation/object_pictures.h"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <utility>

#include <fmt/format.h>

#include "deepslam/geometry/box.h"
#include "deepslam/render/shaded_view.h"
#include "deepslam/report/draw.h"
#include "deepslam/scene/upright_turns.h"
#include "deepslam/shape/rasterise_depth.h"
#include "deepslam/shape/render_voxels.h"

namespace deepslam::presentation {
namespace {

Mask ModelMask(const PicturedObject& object,
               const PinholeCamera& camera,
               const Pose3& world_from_camera) {
  const Pose3 camera_from_object = world_from_camera.Inverse() * object.object->world_from_object;
  const DepthImage depth = shape::RasteriseDepth(*object.mesh, camera_from_object, camera);
  Mask mask(depth.width(), depth.height());
  std::transform(depth.begin(), depth.end(), mask.begin(), [](float d) { return d > 0 ? 1 : 0; });
  return mask;
}

// The box widened to show the surroundings, clipped to the image.
Box2 Widened(const Box2& box, const PinholeCamera& camera) {
  const double margin = 0.25 * std::max(box.width_px(), box.height_px()) + 8;
  return {std::max(0.0, std::floor(box.u_min - margin)),
          std::max(0.0, std::floor(box.v_min - margin)),
          std::min(camera.width - 1.0, std::ceil(box.u_max + margin)),
          std::min(camera.height - 1.0, std::ceil(box.v_max + margin))};
}

ColourImage Cropped(const ColourImage& picture, const Box2& box) {
  ColourImage crop(static_cast<int>(box.width_px()) + 1, static_cast<int>(box.height_px()) + 1);
  for (int v = 0; v < crop.height(); ++v) {
    for (int u = 0; u < crop.width(); ++u) {
      crop(u, v) = picture(u + static_cast<int>(box.u_min), v + static_cast<int>(box.v_min));
    }
  }
  return crop;
}

// The segments of an object's views, in the order of its views.
std::vector<const Segment*> SegmentsOf(const MapObject& object, std::span<const Segment> segments) {
  std::vector<const Segment*> seen;
  for (const ViewRegistration& view : object.views) {
    const auto segment = std::find_if(segments.begin(), segments.end(), [&](const Segment& s) {
      return s.detection == view.view;
    });
    if (segment != segments.end()) seen.push_back(&*segment);
  }
  return seen;
}

void AppendPoints(const Segment& segment,
                  const Frame& frame,
                  const PinholeCamera& camera,
                  const Pose3& world_from_camera,
                  int max_points,
                  std::vector<Eigen::Vector3f>& points_world) {
  const DepthImage& depth = frame.depth_m;
  if (segment.mask.width() != depth.width() || segment.mask.height() != depth.height()) return;
  const Mask mask = segment.mask.Unpacked();
  const int step = segment.num_points / std::max(1, max_points) + 1;
  int count = 0;
  for (int v = 0; v < depth.height(); ++v) {
    for (int u = 0; u < depth.width(); ++u) {
      if (mask(u, v) == 0 || depth(u, v) <= 0 || count++ % step != 0) continue;
      const Eigen::Vector3d p_camera = camera.Unproject(u, v, static_cast<double>(depth(u, v)));
      points_world.push_back((world_from_camera * p_camera).cast<float>());
    }
  }
}

}  // namespace

PictureLimits LimitsFor(std::size_t num_objects) {
  if (num_objects <= 20) return {};
  if (num_objects <= 60) return {2, 4, 300};
  return {0, 0, 0};
}

std::vector<report::Picture> ObjectPictures(const PicturedObject& object,
                                            std::span<const Segment> segments,
                                            const OptimizedMap& map,
                                            const FrameSource& frames,
                                            const std::set<FrameIdx>& shown,
                                            int max_pictures) {
  std::vector<const Segment*> seen = SegmentsOf(*object.object, segments);
  std::erase_if(seen, [&](const Segment* segment) { return !shown.contains(segment->frame); });
  std::vector<report::Picture> pictures;
  for (const Segment* segment : Spread(seen, max_pictures)) {
    const Result<Frame> frame = frames.ReadColour(segment->frame);
    if (!frame.ok()) continue;
    const Box2 box = Widened(segment->box_px, frames.camera());
    PinholeCamera camera = frames.camera();
    camera.cx -= box.u_min;
    camera.cy -= box.v_min;
    const ColourImage crop = Cropped(frame->colour, box);
    camera.width = crop.width();
    camera.height = crop.height();
    const Mask mask =
        ModelMask(object,
                  camera,
                  map.frames[static_cast<std::size_t>(segment->frame.value)].world_from_camera);
    const QuarterTurn upright = UprightTurnIn(map, segment->frame);
    AddPicture(
        pictures,
        report::DrawOutline(Turned(crop, upright), Turned(mask, upright), object.colour, 340),
        fmt::format("frame {}", segment->frame.value));
  }
  return pictures;
}

std::vector<Eigen::Vector3f> MeasuredPoints(const MapObject& object,
                                            std::span<const Segment> segments,
                                            const OptimizedMap& map,
                                            const FrameSource& frames,
                                            int max_points_per_view) {
  // Frames read for a picture's points: they spread over all sides.
  constexpr int kMaxPicturedViews = 4;
  std::vector<Eigen::Vector3f> points_world;
  if (max_points_per_view <= 0) return points_world;
  for (const Segment* segment : Spread(SegmentsOf(object, segments), kMaxPicturedViews)) {
    const Result<Frame> frame = frames.Read(segment->frame);
    if (!frame.ok()) continue;
    AppendPoints(*segment,
                 *frame,
                 frames.camera(),
                 map.frames[static_cast<std::size_t>(segment->frame.value)].world_from_camera,
                 max_points_per_view,
                 points_world);
  }
  return points_world;
}

report::Picture Thumbnail(const shape::ShapeModel& model, Rgb8 colour) {
  constexpr int kSide_px = 128;  // px: a thumbnail beside the object's numbers
  if (model.empty()) return {};
  // The unit cube just fills the picture from here.
  const PinholeCamera camera{kSide_px, kSide_px, 290, 290, 0.5 * kSide_px, 0.5 * kSide_px};
  const Pose3 object_from_camera =
      render::LookAt(Eigen::Vector3d(2.0, 1.25, 1.1), Eigen::Vector3d::Zero());
  const Eigen::Vector3f lamp = Eigen::Vector3f(0.55f, 0.1f, 0.83f).normalized();
  const DepthImage depth =
      shape::RenderDepth(model, Similarity3::From(object_from_camera.Inverse(), 1.0), camera);
  ColourImage picture(kSide_px, kSide_px, Rgb8{255, 255, 255});
  for (int v = 0; v < kSide_px; ++v) {
    for (int u = 0; u < kSide_px; ++u) {
      if (depth(u, v) <= 0) continue;
      const Eigen::Vector3d p =
          object_from_camera * camera.Unproject(u, v, static_cast<double>(depth(u, v)));
      const Eigen::Vector3f normal = model.Gradient(p.cast<float>()).normalized();
      const float light = 0.4f + 0.6f * std::max(0.0f, normal.dot(lamp));
      const auto lit = [&](std::uint8_t c) {
        return static_cast<std::uint8_t>(std::clamp(light * float(c) * 1.15f, 0.0f, 255.0f));
      };
      picture(u, v) = {lit(colour.r), lit(colour.g), lit(colour.b)};
    }
  }
  std::vector<report::Picture> made;
  AddPicture(made, report::EncodeJpeg(picture), {});
  return made.empty() ? report::Picture{} : std::move(made.front());
}

}  // namespace deepslam::presentation

#include "deepslam/stages/report_pictures.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <map>
#include <numbers>

#include <fmt/format.h>

#include "deepslam/eval/silhouette.h"
#include "deepslam/geometry/upright.h"
#include "deepslam/render/shaded_view.h"
#include "deepslam/report/draw.h"
#include "deepslam/scene/upright_turns.h"
#include "deepslam/shape/render_voxels.h"
#include "deepslam/shape/shape_model.h"

namespace deepslam::stages {
namespace {

constexpr int kSceneWidth = 900;
constexpr int kSceneHeight = 600;
constexpr int kThumbnailWidth = 240;
constexpr int kMaxFramePictures = 6;
constexpr int kMaxPhotographs = 2;

void AddPicture(std::vector<report::Picture>& pictures,
                Result<std::string> jpeg,
                std::string caption) {
  if (jpeg.ok()) pictures.push_back({std::move(jpeg).value(), "image/jpeg", std::move(caption)});
}

Box3 Bounds(std::span<const PicturedObject> objects) {
  Box3 bounds;
  for (const PicturedObject& o : objects) {
    for (const Eigen::Vector3f& vertex : o.mesh.vertices) {
      bounds.Extend(o.object->world_from_object * vertex.cast<double>());
    }
  }
  return bounds;
}

// A floor under the objects, checkered by half metres so that sizes can be seen.
std::array<TriangleMesh, 2> Floor(const Box3& bounds) {
  constexpr double kTile_m = 0.5;
  std::array<TriangleMesh, 2> tiles;
  const auto index = [](double x) { return static_cast<int>(std::floor(x / kTile_m)); };
  constexpr int kMaxTiles = 200;
  const int x0 = index(bounds.min.x()) - 1,
            x1 = std::min(index(bounds.max.x()) + 1, x0 + kMaxTiles);
  const int y0 = index(bounds.min.y()) - 1,
            y1 = std::min(index(bounds.max.y()) + 1, y0 + kMaxTiles);
  for (int x = x0; x <= x1; ++x) {
    for (int y = y0; y <= y1; ++y) {
      TriangleMesh& mesh = tiles[static_cast<std::size_t>((x + y) & 1)];
      const auto first = static_cast<std::uint32_t>(mesh.vertices.size());
      for (const auto& [dx, dy] :
           {std::pair(0, 0), std::pair(1, 0), std::pair(1, 1), std::pair(0, 1)}) {
        mesh.vertices.emplace_back(
            static_cast<float>((x + dx) * kTile_m), static_cast<float>((y + dy) * kTile_m), 0.0f);
      }
      mesh.faces.push_back({first, first + 1, first + 2});
      mesh.faces.push_back({first, first + 2, first + 3});
    }
  }
  return tiles;
}

std::vector<render::ShadedMesh> ObjectMeshes(std::span<const PicturedObject> objects) {
  std::vector<render::ShadedMesh> meshes;
  for (const PicturedObject& o : objects) {
    meshes.push_back({o.mesh, o.object->world_from_object, o.colour, false});
  }
  return meshes;
}

double CameraAzimuth(const OptimizedMap& map, const Box3& bounds) {
  Eigen::Vector3d mean = Eigen::Vector3d::Zero();
  for (const TrackedFrame& frame : map.frames) mean += frame.world_from_camera.translation_m;
  if (!map.frames.empty()) mean /= static_cast<double>(map.frames.size());
  const Eigen::Vector3d direction = mean - bounds.Center();
  return direction.head<2>().norm() < 0.05 ? 0.0 : std::atan2(direction.y(), direction.x());
}

// Share of the picture that objects fill from a keyframe; the keyframes that see most come first.
std::vector<FrameIdx> BestKeyframes(std::span<const PicturedObject> objects,
                                    const OptimizedMap& map,
                                    const PinholeCamera& camera,
                                    const std::set<FrameIdx>& shown) {
  std::vector<std::pair<int, FrameIdx>> seen;
  for (const FrameIdx keyframe : map.keyframes) {
    if (!shown.contains(keyframe)) continue;
    const Pose3 camera_from_world =
        map.frames[static_cast<std::size_t>(keyframe.value)].world_from_camera.Inverse();
    int count = 0;
    for (const PicturedObject& o : objects) {
      const auto pixel =
          camera.Project(camera_from_world * o.object->world_from_object.translation_m);
      if (pixel && pixel->x() > 0 && pixel->y() > 0 && pixel->x() < camera.width &&
          pixel->y() < camera.height)
        ++count;
    }
    seen.emplace_back(-count, keyframe);
  }
  std::stable_sort(seen.begin(), seen.end());
  std::vector<FrameIdx> best;
  for (const auto& [negative_count, keyframe] : seen) {
    const bool far = std::all_of(best.begin(), best.end(), [&, k = keyframe](FrameIdx other) {
      return std::abs(other.value - k.value) > static_cast<int>(map.frames.size()) / 8;
    });
    if (far && negative_count < 0) best.push_back(keyframe);
    if (best.size() == kMaxPhotographs) break;
  }
  return best;
}

Mask ModelMask(const PicturedObject& object,
               const PinholeCamera& camera,
               const Pose3& world_from_camera) {
  const Pose3 camera_from_object = world_from_camera.Inverse() * object.object->world_from_object;
  const DepthImage depth = eval::RasteriseDepth(object.mesh, camera_from_object, camera);
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

// Colours that neighbours in the list do not share; by id, so that an object keeps its colour over
// frames.
Rgb8 InstanceColour(int id) {
  constexpr std::array<Rgb8, 10> kPalette{{{230, 57, 70},
                                           {29, 121, 199},
                                           {42, 157, 78},
                                           {244, 162, 30},
                                           {123, 44, 191},
                                           {0, 170, 170},
                                           {214, 82, 160},
                                           {130, 110, 40},
                                           {90, 90, 220},
                                           {140, 190, 40}}};
  return kPalette[static_cast<std::size_t>(id) % kPalette.size()];
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

// At most `count` of them, evenly.
template <typename T>
std::vector<T> Spread(const std::vector<T>& all, int max_count) {
  std::vector<T> some;
  const std::size_t count = std::min(all.size(), static_cast<std::size_t>(max_count));
  for (std::size_t n = 0; n < count; ++n)
    some.push_back(all[(2 * n + 1) * all.size() / (2 * count)]);
  return some;
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

std::vector<report::Picture> ScenePictures(std::span<const PicturedObject> objects,
                                           const OptimizedMap& map) {
  std::vector<report::Picture> pictures;
  const Box3 bounds = Bounds(objects);
  if (bounds.empty()) return pictures;
  const PinholeCamera camera{
      kSceneWidth, kSceneHeight, 1000, 1000, 0.5 * kSceneWidth, 0.5 * kSceneHeight};
  std::vector<render::ShadedMesh> meshes = ObjectMeshes(objects);
  const auto floor = Floor(bounds);
  meshes.push_back({floor[0], Pose3{}, Rgb8{225, 225, 225}, false});
  meshes.push_back({floor[1], Pose3{}, Rgb8{205, 205, 205}, false});
  const render::ShadedScene scene(meshes);
  const double azimuth = CameraAzimuth(map, bounds);
  constexpr double kElevation_rad = 0.6;
  for (const double turn : {0.0, std::numbers::pi * 0.75}) {
    const Pose3 pose = render::Overlook(bounds, camera, azimuth + turn, kElevation_rad);
    AddPicture(pictures,
               report::EncodeJpeg(scene.View(camera, pose)),
               turn == 0.0 ? "The map from the camera's side; floor tiles are 0.5 m"
                           : "The map from behind");
  }
  return pictures;
}

report::Picture SceneThumbnail(std::span<const PicturedObject> objects,
                               const TriangleMesh& room_world,
                               const OptimizedMap& map) {
  constexpr int kDrawnWidth = 2 * kThumbnailWidth;  // drawn twice as large, for smooth edges
  constexpr int kDrawnHeight = kDrawnWidth * 2 / 3;
  const PinholeCamera camera{kDrawnWidth,
                             kDrawnHeight,
                             1.1 * kDrawnWidth,
                             1.1 * kDrawnWidth,
                             0.5 * kDrawnWidth,
                             0.5 * kDrawnHeight};
  Box3 bounds = Bounds(objects);
  std::vector<render::ShadedMesh> meshes = ObjectMeshes(objects);
  if (bounds.empty()) {
    for (const Eigen::Vector3f& vertex : room_world.vertices) bounds.Extend(vertex.cast<double>());
    if (bounds.empty()) return {};
    meshes.push_back({room_world, Pose3{}, Rgb8{200, 200, 200}, true});
  } else {
    const auto floor = Floor(bounds);
    meshes.push_back({floor[0], Pose3{}, Rgb8{225, 225, 225}, false});
    meshes.push_back({floor[1], Pose3{}, Rgb8{205, 205, 205}, false});
  }
  constexpr double kElevation_rad = 0.6;
  const Pose3 pose = render::Overlook(bounds, camera, CameraAzimuth(map, bounds), kElevation_rad);
  Result<std::string> jpeg =
      report::DrawOverlays(render::ShadeView(meshes, camera, pose), {}, kThumbnailWidth);
  if (!jpeg.ok()) return {};
  return {std::move(jpeg).value(), "image/jpeg", {}};
}

std::vector<report::PicturePair> Photographs(std::span<const PicturedObject> objects,
                                             const TriangleMesh& room_world,
                                             const OptimizedMap& map,
                                             const FrameSource& frames,
                                             const std::set<FrameIdx>& shown) {
  std::vector<report::PicturePair> pairs;
  std::vector<render::ShadedMesh> with_room = ObjectMeshes(objects);
  with_room.push_back({room_world, Pose3{}, Rgb8{200, 200, 200}, true});
  const render::ShadedScene scene(with_room);
  for (const FrameIdx keyframe : BestKeyframes(objects, map, frames.camera(), shown)) {
    const Result<Frame> frame = frames.ReadColour(keyframe);
    if (!frame.ok()) continue;
    const Pose3& pose = map.frames[static_cast<std::size_t>(keyframe.value)].world_from_camera;
    const QuarterTurn upright = UprightTurnIn(map, keyframe);
    std::vector<report::Picture> both;
    AddPicture(both,
               report::DrawOverlays(Turned(frame->colour, upright), {}, 640),
               fmt::format("Frame {}, as the camera saw it", keyframe.value));
    const ColourImage drawn = scene.View(frames.camera(), pose);
    AddPicture(both,
               report::EncodeJpeg(Turned(drawn, upright)),
               "The map from there, objects in class colours in the measured room");
    if (both.size() == 2) pairs.push_back({std::move(both[0]), std::move(both[1])});
  }
  return pairs;
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
  constexpr int kMaxViews = 4;
  std::vector<Eigen::Vector3f> points_world;
  if (max_points_per_view <= 0) return points_world;
  for (const Segment* segment : Spread(SegmentsOf(object, segments), kMaxViews)) {
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
  constexpr int kSide_px = 128;
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

std::vector<FrameIdx> FramesToPicture(std::span<const Segment> segments,
                                      const OptimizedMap& map,
                                      const std::set<FrameIdx>& shown) {
  std::set<FrameIdx> segmented;
  for (const Segment& segment : segments) segmented.insert(segment.frame);
  std::vector<FrameIdx> all;
  std::ranges::copy_if(map.keyframes, std::back_inserter(all), [&](FrameIdx keyframe) {
    return segmented.contains(keyframe) && shown.contains(keyframe);
  });
  return Spread(all, kMaxFramePictures);
}

std::vector<report::Picture> FramePictures(std::span<const FrameIdx> wanted,
                                           std::span<const Segment> segments,
                                           std::span<const ObjectTrack> tracks,
                                           const OptimizedMap& map,
                                           const FrameSource& frames) {
  std::map<DetectionId, ObjectId> object_of;
  for (const ObjectTrack& track : tracks) {
    for (const TrackMember& member : track.members) object_of[member.detection] = track.id;
  }
  std::map<FrameIdx, std::vector<const Segment*>> in_frame;
  for (const Segment& segment : segments) in_frame[segment.frame].push_back(&segment);
  const PinholeCamera& camera = frames.camera();
  const auto overlay_of = [&](const Segment& s, QuarterTurn upright) {
    const auto object = object_of.find(s.detection);
    report::Overlay overlay{Turned(s.box_px, camera.width, camera.height, upright),
                            Turned(s.mask.Unpacked(), upright),
                            fmt::format("{} {:.2f}", s.class_name, s.score),
                            Rgb8{150, 150, 150}};
    if (object != object_of.end()) {
      overlay.colour = InstanceColour(object->second.value);
      overlay.label = fmt::format("{}_{:02d} {:.2f}", s.class_name, object->second.value, s.score);
    }
    return overlay;
  };
  std::vector<report::Picture> pictures;
  for (const FrameIdx keyframe : wanted) {
    const Result<Frame> frame = frames.ReadColour(keyframe);
    if (!frame.ok()) continue;
    const QuarterTurn upright = UprightTurnIn(map, keyframe);
    std::vector<report::Overlay> overlays;
    for (const Segment* segment : in_frame[keyframe])
      overlays.push_back(overlay_of(*segment, upright));
    AddPicture(pictures,
               report::DrawOverlays(Turned(frame->colour, upright), overlays, 520),
               fmt::format("frame {}", keyframe.value));
  }
  return pictures;
}

}  // namespace deepslam::stages

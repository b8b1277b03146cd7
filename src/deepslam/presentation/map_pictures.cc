#include "deepslam/presentation/map_pictures.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <cstdlib>
#include <numbers>
#include <string>
#include <utility>

#include <fmt/format.h>

#include "deepslam/geometry/box.h"
#include "deepslam/render/shaded_view.h"
#include "deepslam/report/draw.h"
#include "deepslam/scene/upright_turns.h"

namespace deepslam::presentation {
namespace {

constexpr int kSceneWidth = 900;       // px, of the report's view of the map
constexpr int kSceneHeight = 600;      // px
constexpr int kThumbnailWidth = 240;   // px, in lists of captures
constexpr int kMaxPhotographs = 2;     // of keyframes, those with most objects in view
constexpr double kElevationRad = 0.6;  // from which the map is looked down upon

Box3 Bounds(std::span<const PicturedObject> objects) {
  Box3 bounds;
  for (const PicturedObject& o : objects) {
    for (const Eigen::Vector3f& vertex : o.mesh->vertices) {
      bounds.Extend(o.object->world_from_object * vertex.cast<double>());
    }
  }
  return bounds;
}

// A floor under the objects, checkered by half metres so that sizes can be seen.
std::array<TriangleMesh, 2> Floor(const Box3& bounds) {
  constexpr double kTile_m = 0.5;  // a side
  std::array<TriangleMesh, 2> tiles;
  const auto index = [](double x) { return static_cast<int>(std::floor(x / kTile_m)); };
  constexpr int kMaxTiles = 200;  // along a side: 100 m; a stray object must not make millions
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
    meshes.push_back({*o.mesh, o.object->world_from_object, o.colour, false});
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

}  // namespace

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
  for (const double turn : {0.0, std::numbers::pi * 0.75}) {
    const Pose3 pose = render::Overlook(bounds, camera, azimuth + turn, kElevationRad);
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
  constexpr int kDrawnWidth = 2 * kThumbnailWidth;   // drawn twice as large, for smooth edges
  constexpr int kDrawnHeight = kDrawnWidth * 2 / 3;  // px; 3:2
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
  const Pose3 pose = render::Overlook(bounds, camera, CameraAzimuth(map, bounds), kElevationRad);
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

}  // namespace deepslam::presentation

#include "deepslam/modelling/loop_evidence.h"

#include <algorithm>
#include <cstddef>
#include <iterator>
#include <vector>

#include "deepslam/core/parallel.h"
#include "deepslam/geometry/similarity.h"
#include "deepslam/shape/view_points.h"

namespace deepslam::modelling {
namespace {

constexpr int kEvidencePointsPerView = 300;  // enough for the shares that loops compare
constexpr int kSurroundingsStridePx = 8;  // enough for a share; a view gives a few hundred points
constexpr float kMaxSurroundingsDepthM = 5.0F;  // farther depth is too noisy to compare rooms by

void AppendWorld(const Pose3& world_from_camera,
                 std::span<const Eigen::Vector3f> points_camera,
                 std::vector<Eigen::Vector3f>& points_world) {
  for (const Eigen::Vector3f& p : points_camera) {
    points_world.push_back((world_from_camera * p.cast<double>()).cast<float>());
  }
}

std::vector<Eigen::Vector3f> Surroundings(const ObjectView& view) {
  std::vector<Eigen::Vector3f> points;
  for (int v = 0; v < view.depth_crop_m.height(); v += kSurroundingsStridePx) {
    for (int u = 0; u < view.depth_crop_m.width(); u += kSurroundingsStridePx) {
      const float depth_m = view.depth_crop_m(u, v);
      if (depth_m <= 0 || depth_m > kMaxSurroundingsDepthM || view.mask_crop(u, v) != 0) continue;
      points.push_back(view.camera.Unproject(u, v, depth_m).cast<float>());
    }
  }
  return points;
}

Result<VoxelGrid> ChosenModel(const MapObject& object,
                              const ModelSource& source,
                              const LoopWorld& world) {
  const auto made = world.made.models.find(object.model);
  if (made != world.made.models.end()) return made->second;
  return source.Read(object.source, object.model);
}

}  // namespace

void AppendMeasured(std::span<const ObjectView> views, loop::ObjectEvidence& evidence) {
  std::vector<std::vector<Eigen::Vector3f>> points(views.size());
  std::vector<std::vector<Eigen::Vector3f>> surroundings(views.size());
  ParallelFor(views.size(), [&](std::size_t n) {
    points[n] = shape::ExtractViewPoints(views[n], kEvidencePointsPerView).points_camera;
    surroundings[n] = Surroundings(views[n]);
  });
  for (std::size_t n = 0; n < views.size(); ++n) {
    AppendWorld(views[n].world_from_camera, points[n], evidence.depth_points_world);
    AppendWorld(views[n].world_from_camera, surroundings[n], evidence.surroundings_world);
  }
}

Result<loop::LoopEvidence> CollectEvidence(const std::set<ObjectId>& wanted,
                                           const LoopClosing& closing,
                                           const LoopWorld& world) {
  loop::LoopEvidence evidence;
  for (const ObjectId id : wanted) evidence[id];
  std::vector<ObjectTrack> tracks;
  std::ranges::copy_if(world.association.tracks,
                       std::back_inserter(tracks),
                       [&](const ObjectTrack& track) { return evidence.contains(track.id); });
  const auto add = [&](std::span<TrackViews> batch) {
    ParallelFor(batch.size(), [&](std::size_t n) {
      AppendMeasured(batch[n].views, evidence.at(batch[n].track->id));
    });
    return Ok();
  };
  const Status measured = closing.sources.views.ForBatches(
      {tracks, world.odometry, world.ground}, observe::ViewContent::kDepth, add);
  if (!measured.ok()) return measured.error();
  for (const MapObject& object : world.map.objects) {
    if (!wanted.contains(object.id)) continue;
    const Result<VoxelGrid> grid = ChosenModel(object, closing.sources.models, world);
    if (!grid.ok()) return grid.error();
    const Similarity3 world_from_model =
        Similarity3::From(object.world_from_object, object.scale_m);
    const PreparedModel model = closing.sources.prepared.Prepare(object.model, *grid);
    std::vector<Eigen::Vector3f>& surface_world = evidence[object.id].model_points_world;
    for (const Eigen::Vector3f& p : model->surface_points())
      surface_world.push_back((world_from_model * p.cast<double>()).cast<float>());
  }
  return evidence;
}

}  // namespace deepslam::modelling

#include "deepslam/presentation/report_page.h"

#include <algorithm>
#include <array>
#include <atomic>
#include <cstddef>
#include <cstdint>
#include <span>
#include <utility>

#include "deepslam/core/parallel.h"
#include "deepslam/fuse/tsdf.h"
#include "deepslam/presentation/frame_pictures.h"
#include "deepslam/presentation/map_pictures.h"
#include "deepslam/presentation/not_mapped_pictures.h"
#include "deepslam/presentation/object_pictures.h"
#include "deepslam/presentation/room_beside.h"
#include "deepslam/report/object_rows.h"
#include "deepslam/report/tracked_path.h"
#include "deepslam/report/warnings.h"

namespace deepslam::presentation {
namespace {

// The cloud that the map's size is held against.
constexpr double kCloudVoxelM = 0.01;
constexpr std::int64_t kCloudPointBytes = 15;  // three floats, three bytes of colour

// Frames whose photographs may be shown: a person was looked for and not seen. Where no network
// looked, all that the detector listed.
std::set<FrameIdx> ShownFrames(std::span<const DetectedFrame> detected,
                               report::ReportContent& content) {
  content.looked_for_people = std::ranges::any_of(
      detected, [](const DetectedFrame& frame) { return frame.contains_person.has_value(); });
  std::set<FrameIdx> shown;
  for (const DetectedFrame& frame : detected) {
    if (frame.contains_person.value_or(content.looked_for_people)) {
      content.num_person_frames += frame.contains_person.has_value() ? 1 : 0;
    } else {
      shown.insert(frame.frame);
    }
  }
  return shown;
}

std::vector<PicturedObject> PicturedObjects(const FinishedMap& finished,
                                            const ClassTable& classes) {
  std::vector<PicturedObject> pictured;
  const std::vector<MapObject>& objects = finished.map.map.objects;
  for (std::size_t n = 0; n < objects.size(); ++n) {
    pictured.push_back(
        {&objects[n], &finished.meshes[n], ClassColour(classes, objects[n].class_name)});
  }
  return pictured;
}

// The detections whose pixels the page shows: of objects' views, and of these frames.
std::set<DetectionId> PicturedDetections(const ReportSources& sources,
                                         std::span<const FrameIdx> frames) {
  std::set<DetectionId> pictured;
  for (const MapObject& object : sources.finished.map.map.objects) {
    for (const ViewRegistration& view : object.views) pictured.insert(view.view);
  }
  for (const Segment& segment : sources.segments) {
    if (std::ranges::find(frames, segment.frame) != frames.end())
      pictured.insert(segment.detection);
  }
  return pictured;
}

report::ReportContent ContentWithoutPictures(const ReportSources& sources) {
  const OptimizedMap& map = sources.finished.map;
  report::ReportContent content;
  content.title = sources.run.capture_name;
  content.tool_version = sources.run.tool_version;
  content.capture_hash = sources.run.capture_sha256;
  content.verdict = NameOf(sources.verdict.verdict);
  content.verdict_reasons = sources.verdict.reasons;
  content.warnings =
      report::Warnings(sources.capture_warnings, sources.association, sources.proposals, map.map);
  content.corrections = sources.corrections;
  content.map = map;
  content.layout_world = sources.finished.layout_world;
  content.loops = sources.loops;
  content.scene_glb = sources.scene_glb;
  report::TrackedPath path = report::LayOntoMap(sources.trajectory, sources.ground, map);
  content.tracked_world_from_camera = std::move(path.world_from_camera);
  content.heights = std::move(path.heights);
  content.sizes.fused_cloud = static_cast<std::size_t>(
      kCloudPointBytes * fuse::ExpectedSurfacePoints(sources.finished.room_world, kCloudVoxelM));
  return content;
}

// What a picture is drawn of.
struct PictureSources {
  const OptimizedMap& map;
  const FrameSource& frames;
  std::vector<PicturedObject> objects;
  std::set<FrameIdx> shown;
  std::vector<Segment> segments;  // with masks, of what is shown
};

// `rows` in the order of the object's scores.
void AddThumbnails(const PicturedObject& pictured,
                   const report::CandidatesById& by_id,
                   const ReportAccess& access,
                   int max_thumbnails,
                   std::vector<report::CandidateRow>& rows) {
  const std::size_t count = std::min(rows.size(), static_cast<std::size_t>(max_thumbnails));
  ParallelFor(count, [&](std::size_t i) {
    const auto found = by_id.find(pictured.object->scores[i].candidate);
    if (found == by_id.end()) return;
    const auto model = access.model_of(*found->second, rows[i].chosen);
    if (model != nullptr) rows[i].thumbnail = Thumbnail(*model, pictured.colour);
  });
}

// Of all objects; nothing when the user asked to stop.
std::optional<std::vector<report::ObjectRow>> ObjectRows(const PictureSources& pictures,
                                                         const Proposals& proposals,
                                                         const ReportAccess& access,
                                                         const Progress& progress) {
  const PictureLimits limits = LimitsFor(pictures.objects.size());
  const report::CandidatesById by_id = report::ById(proposals.candidates);
  std::vector<report::ObjectRow> rows(pictures.objects.size());
  std::atomic<bool> stopped = false;
  ParallelFor(rows.size(), [&](std::size_t n) {
    if (stopped || progress.StopRequested()) {
      stopped = true;
      return;
    }
    const PicturedObject& object = pictures.objects[n];
    report::ObjectRow& row = rows[n];
    row = report::MakeObjectRow(*object.object, *object.mesh, object.colour, by_id);
    row.pictures = ObjectPictures(
        object, pictures.segments, pictures.map, pictures.frames, pictures.shown, limits.crops);
    row.measured_world = MeasuredPoints(
        *object.object, pictures.segments, pictures.map, pictures.frames, limits.points_per_view);
    AddThumbnails(object, by_id, access, limits.thumbnails, row.candidates);
  });
  if (stopped) return std::nullopt;
  return rows;
}

}  // namespace

Result<ReportPage> MakeReportPage(const ReportSources& sources,
                                  const ReportAccess& access,
                                  const ClassTable& classes,
                                  const Progress& progress) {
  const FinishedMap& finished = sources.finished;
  const OptimizedMap& map = finished.map;
  ReportPage page{ContentWithoutPictures(sources), {}};
  report::ReportContent& content = page.content;
  PictureSources pictures{map,
                          access.frames,
                          PicturedObjects(finished, classes),
                          ShownFrames(sources.detected, content),
                          {}};
  const std::vector<FrameIdx> with_segments =
      FramesToPicture(sources.segments, map, pictures.shown);
  Result<std::vector<Segment>> segments =
      access.segments_of(PicturedDetections(sources, with_segments));
  if (!segments.ok()) return segments.error();
  pictures.segments = std::move(segments).value();
  std::optional<std::vector<report::ObjectRow>> rows =
      ObjectRows(pictures, sources.proposals, access, progress);
  if (!rows) return Interrupted();
  content.objects = *std::move(rows);
  const auto photograph = [&] {
    // The room for pictures that show the objects' meshes; the floor stays measured.
    const TriangleMesh room =
        RoomBeside(finished.room_world, map.map.objects, finished.meshes, std::nullopt);
    content.photographs = Photographs(pictures.objects, room, map, access.frames, pictures.shown);
  };
  const std::array<std::function<void()>, 5> draw = {
      photograph,
      [&] {
        content.frame_pictures = FramePictures(
            with_segments, pictures.segments, sources.association.tracks, map, access.frames);
      },
      [&] {
        content.not_mapped =
            NotMappedPictures(sources.association.not_mapped, map, access.frames, pictures.shown);
      },
      [&] { content.scene_pictures = ScenePictures(pictures.objects, map); },
      [&] { page.thumbnail = SceneThumbnail(pictures.objects, finished.room_world, map); }};
  ParallelFor(draw.size(), [&](std::size_t n) { draw[n](); });
  return page;
}

}  // namespace deepslam::presentation

#include <algorithm>
#include <array>
#include <atomic>
#include <functional>
#include <limits>
#include <map>
#include <set>

#include <fmt/format.h>

#include "deepslam/artifact/map_json.h"
#include "deepslam/artifact/segments_json.h"
#include "deepslam/core/parallel.h"
#include "deepslam/fuse/tsdf.h"
#include "deepslam/pipeline/manifest.h"
#include "deepslam/report/report.h"
#include "deepslam/stages/read_side_by_side.h"
#include "deepslam/stages/report_pictures.h"
#include "deepslam/stages/room_beside.h"
#include "deepslam/stages/stage_inputs.h"

namespace deepslam::stages {
namespace {

using pipeline::StageContext;
using pipeline::StageSummary;

// The cloud that the map's size is held against.
constexpr double kCloudVoxelM = 0.01;
constexpr std::int64_t kCloudPointBytes = 15;  // three floats, three bytes of colour

using CandidatesById = std::map<CandidateId, const ShapeCandidate*>;

CandidatesById ById(const Proposals& proposals) {
  CandidatesById by_id;
  for (const ShapeCandidate& candidate : proposals.candidates) by_id[candidate.id] = &candidate;
  return by_id;
}

// In the order of the object's scores.
std::vector<report::CandidateRow> CandidateRows(const MapObject& object,
                                                const CandidatesById& by_id) {
  std::vector<report::CandidateRow> rows;
  for (const CandidateScore& score : object.scores) {
    report::CandidateRow row;
    if (const auto it = by_id.find(score.candidate); it != by_id.end()) {
      row.model = it->second->model;
      row.source = TraitsOf(it->second->source).in_words;
      row.is_partial = TraitsOf(it->second->source).is_partial;
    }
    row.score = score.score;
    row.surface_share = score.surface_share;
    row.coverage_share = score.coverage_share;
    row.free_violation = score.free_violation;
    row.num_views = score.num_views;
    row.chosen = score.candidate == object.chosen;
    row.note = score.note;
    rows.push_back(std::move(row));
  }
  return rows;
}

Box3 BoundsOf(const TriangleMesh& mesh) {
  Box3 box;
  for (const Eigen::Vector3f& vertex : mesh.vertices) box.Extend(vertex.cast<double>());
  return box;
}

double LowestPoint(const TriangleMesh& mesh, const Pose3& world_from_object) {
  double lowest = std::numeric_limits<double>::infinity();
  for (const Eigen::Vector3f& vertex : mesh.vertices) {
    lowest = std::min(lowest, (world_from_object * vertex.cast<double>()).z());
  }
  return mesh.vertices.empty() ? 0.0 : lowest;
}

report::ObjectRow MakeRow(const PicturedObject& pictured, const CandidatesById& by_id) {
  const MapObject& object = *pictured.object;
  report::ObjectRow row;
  row.name = pictured.name;
  row.class_name = object.class_name;
  row.size_m = BoundsOf(pictured.mesh).Size();
  row.world_from_object = object.world_from_object;
  row.bottom_above_ground_m = LowestPoint(pictured.mesh, object.world_from_object);
  row.confidence = object.confidence;
  row.num_views = static_cast<int>(object.views.size());
  row.source = TraitsOf(object.source).in_words;
  row.credit = object.credit;
  row.note = object.note;
  row.colour = pictured.colour;
  row.candidates = CandidateRows(object, by_id);
  return row;
}

Rgb8 ColourOf(const ClassTable& classes, const std::string& class_name) {
  const ObjectClass* known = classes.Find(class_name);
  if (known == nullptr) return {160, 160, 160};
  const auto byte = [](int x) { return static_cast<std::uint8_t>(std::clamp(x, 0, 255)); };
  return {byte(known->colour_rgb[0]), byte(known->colour_rgb[1]), byte(known->colour_rgb[2])};
}

// An object whose mesh could not be made stands in the map without one and is left out of pictures.
std::vector<PicturedObject> ReadPictured(const StageContext& context,
                                         const ObjectMap& map,
                                         const ClassTable& classes) {
  std::vector<PicturedObject> pictured;
  for (const MapObject& object : map.objects) {
    PicturedObject entry{&object, ObjectName(object), {}, ColourOf(classes, object.class_name)};
    Result<TriangleMesh> mesh = ReadMesh(context, "mesh", "objects/" + entry.name + ".ply");
    if (mesh.ok()) entry.mesh = std::move(mesh).value();
    pictured.push_back(std::move(entry));
  }
  return pictured;
}

std::vector<std::string> Warnings(const RunInputs& inputs,
                                  const Association& association,
                                  const Proposals& proposals,
                                  const OptimizedMap& map) {
  std::vector<std::string> warnings = inputs.capture->warnings;
  warnings.insert(warnings.end(), proposals.notes.begin(), proposals.notes.end());
  warnings.insert(warnings.end(), map.map.dropped.begin(), map.map.dropped.end());
  std::map<std::string, int> reasons;
  for (const Rejection& rejection : association.rejections) ++reasons[rejection.reason];
  for (const auto& [reason, count] : reasons) {
    warnings.push_back(
        fmt::format("{} to no object: {}",
                    count == 1 ? "1 detection belongs" : fmt::format("{} detections belong", count),
                    reason));
  }
  return warnings;
}

Result<std::vector<std::string>> Corrections(const StageContext& context) {
  std::vector<std::string> corrections;
  for (const std::string_view stage : {"ground", "associate", "select"}) {
    const Result<std::vector<std::string>> applied = ReadApplied(context, stage);
    if (!applied.ok()) return applied.error();
    corrections.insert(corrections.end(), applied->begin(), applied->end());
  }
  return corrections;
}

// What the stages said of themselves, and the sizes of the files a user takes away.
void AddManifests(const StageContext& context, report::ReportContent& content) {
  for (const std::string& stage : context.inputs()) {
    const std::string name = StageContext::DisplayName(stage, pipeline::kManifestFile);
    const Result<std::string> text = context.Read(stage, pipeline::kManifestFile);
    if (!text.ok()) continue;
    const Result<pipeline::Manifest> manifest = pipeline::DecodeManifest(*text, name);
    if (!manifest.ok()) continue;
    content.stage_summaries.emplace_back(stage, manifest->summary.line);
    const auto figure = [&](const char* figure_name) {
      const auto found = manifest->summary.figures.find(figure_name);
      return found == manifest->summary.figures.end() ? 0 : static_cast<std::size_t>(found->second);
    };
    if (stage != "export") continue;
    content.sizes.map_json = figure("map_bytes");
    content.sizes.scene_glb = figure("scene_bytes");
    content.sizes.objects_glb = figure("objects_glb_bytes");
    for (const auto& [file, output] : manifest->outputs)
      content.file_bytes.emplace_back(file, output.num_bytes);
  }
}

// Frames whose photographs may be shown: a person was looked for and not seen. Where no network
// looked, all that the detect stage listed; the page says so.
std::set<FrameIdx> ShownFrames(const artifact::DetectionTable& table,
                               report::ReportContent& content) {
  content.looked_for_people =
      std::any_of(table.images.begin(), table.images.end(), [](const auto& i) {
        return i.contains_person.has_value();
      });
  std::set<FrameIdx> shown;
  for (const artifact::DetectedImage& image : table.images) {
    if (image.contains_person.value_or(content.looked_for_people)) {
      content.num_person_frames += image.contains_person.has_value() ? 1 : 0;
    } else {
      shown.insert(image.frame);
    }
  }
  return shown;
}

// The tracked path laid onto the first final pose, so that what the graph changed shows; and the
// heights read off the floor against both paths.
void AddPaths(const Trajectory& trajectory, const Ground& ground, report::ReportContent& content) {
  const std::vector<TrackedFrame>& final_frames = content.map.frames;
  if (final_frames.empty() || trajectory.frames.size() != final_frames.size()) return;
  const Pose3 world_from_tracking = final_frames.front().world_from_camera *
                                    trajectory.frames.front().world_from_camera.Inverse();
  for (const TrackedFrame& frame : trajectory.frames)
    content.tracked_world_from_camera.push_back(world_from_tracking * frame.world_from_camera);
  if (!content.map.has_ground) return;
  for (const GroundObservation& seen : ground.observations) {
    const auto at = static_cast<std::size_t>(seen.keyframe.value);
    if (at >= final_frames.size()) continue;
    content.heights.push_back({seen.keyframe,
                               seen.plane_camera.d_m,
                               content.tracked_world_from_camera[at].translation_m.z(),
                               final_frames[at].world_from_camera.translation_m.z()});
  }
}

// `rows` as CandidateRows gives them.
void AddThumbnails(const StageContext& context,
                   const RunInputs& inputs,
                   const PicturedObject& pictured,
                   const CandidatesById& by_id,
                   int max_thumbnails,
                   std::vector<report::CandidateRow>& rows) {
  const std::size_t count = std::min(rows.size(), static_cast<std::size_t>(max_thumbnails));
  ParallelFor(count, [&](std::size_t i) {
    const auto found = by_id.find(pictured.object->scores[i].candidate);
    if (found == by_id.end()) return;
    const ShapeCandidate& candidate = *found->second;
    const std::string_view stage = rows[i].chosen ? "loops" : StageOfModel(candidate.source);
    Result<VoxelGrid> model = ReadModel(context, stage, candidate.model);
    if (!model.ok()) model = ReadModel(context, "loops", candidate.model);  // made, not chosen
    if (!model.ok()) return;
    rows[i].thumbnail =
        Thumbnail(*inputs.prepared->Prepare(candidate.model, *model), pictured.colour);
  });
}

// What the page is made of, read from the stages.
struct Sources {
  Trajectory trajectory;
  Ground ground;
  Loops loops;
  artifact::DetectionTable detections;
  std::vector<Segment> segments;  // without masks
  Association association;
  Proposals proposals;
  OptimizedMap map;
  CompactMap map_file;
  std::string scene_glb;
  std::vector<std::string> corrections;
  TriangleMesh room;
};

Result<Sources> ReadSources(const StageContext& context) {
  Sources sources;
  const auto read_map = [&] {
    const Result<std::string> text = context.Read("export", "map.json");
    return text.ok() ? Take(artifact::DecodeMap(*text, "export/map.json"), sources.map_file)
                     : Status(text.error());
  };
  const auto read_room = [&] {  // may be missing
    if (Result<TriangleMesh> room = ReadMesh(context, "fuse", "room.ply"); room.ok())
      sources.room = std::move(room).value();
    return Ok();
  };
  const std::vector<std::function<Status()>> readers = {
      [&] { return Take(ReadSegmentsWithoutMasks(context), sources.segments); },
      [&] { return Take(ReadCandidates(context, "loops"), sources.proposals); },
      [&] { return Take(ReadOptimized(context), sources.map); },
      [&] { return Take(ReadAssociation(context, "associate"), sources.association); },
      [&] { return Take(ReadTrajectory(context), sources.trajectory); },
      [&] { return Take(ReadDetections(context), sources.detections); },
      read_room,
      [&] { return Take(ReadGround(context, "ground"), sources.ground); },
      [&] { return Take(ReadLoops(context), sources.loops); },
      [&] { return Take(Corrections(context), sources.corrections); },
      [&] { return Take(context.Read("export", "scene.glb"), sources.scene_glb); },
      read_map};
  if (Status status = ReadSideBySide(readers); !status.ok()) return status.error();
  return sources;
}

// The room for pictures that show the objects' meshes; the floor stays measured.
TriangleMesh RoomWithout(std::span<const PicturedObject> pictured, const TriangleMesh& room) {
  std::vector<MapObject> objects;
  std::vector<TriangleMesh> meshes;
  for (const PicturedObject& object : pictured) {
    objects.push_back(*object.object);
    meshes.push_back(object.mesh);
  }
  return RoomBeside(room, objects, meshes, std::nullopt);
}

// The detections whose pixels the page shows: of objects' views, and of these frames.
std::set<DetectionId> Pictured(const Sources& sources, std::span<const FrameIdx> frames) {
  std::set<DetectionId> pictured;
  for (const MapObject& object : sources.map.map.objects) {
    for (const ViewRegistration& view : object.views) pictured.insert(view.view);
  }
  for (const Segment& segment : sources.segments) {
    if (std::ranges::find(frames, segment.frame) != frames.end())
      pictured.insert(segment.detection);
  }
  return pictured;
}

// Rows of all objects; false when the user asked to stop.
bool AddObjects(const StageContext& context,
                const RunInputs& inputs,
                const Sources& sources,
                std::span<const Segment> segments,
                std::span<const PicturedObject> pictured,
                const FrameSource& frames,
                const std::set<FrameIdx>& shown,
                report::ReportContent& content) {
  const PictureLimits limits = LimitsFor(pictured.size());
  const CandidatesById by_id = ById(sources.proposals);
  content.objects.resize(pictured.size());
  std::atomic<bool> stopped = false;
  ParallelFor(pictured.size(), [&](std::size_t n) {
    if (stopped || context.progress().StopRequested()) {
      stopped = true;
      return;
    }
    const PicturedObject& object = pictured[n];
    report::ObjectRow& row = content.objects[n];
    row = MakeRow(object, by_id);
    row.pictures = ObjectPictures(object, segments, sources.map, frames, shown, limits.crops);
    row.measured_world =
        MeasuredPoints(*object.object, segments, sources.map, frames, limits.points_per_view);
    AddThumbnails(context, inputs, object, by_id, limits.thumbnails, row.candidates);
  });
  return !stopped;
}

}  // namespace

Result<StageSummary> RunReport(StageContext& context, const RunInputs& inputs) {
  const Result<Sources> sources = ReadSources(context);
  if (!sources.ok()) return sources.error();
  report::ReportContent content;
  content.title = inputs.capture->name;
  content.tool_version = kToolVersion;
  content.capture_hash = inputs.capture->content_hash;
  content.verdict = NameOf(sources->map_file.verdict);
  content.verdict_reasons = sources->map_file.reasons;
  content.warnings = Warnings(inputs, sources->association, sources->proposals, sources->map);
  content.corrections = sources->corrections;
  content.map = sources->map;
  content.loops = sources->loops;
  content.scene_glb = sources->scene_glb;
  AddPaths(sources->trajectory, sources->ground, content);
  const std::set<FrameIdx> shown = ShownFrames(sources->detections, content);
  const FrameSource& frames = *inputs.capture->frames;
  report::Picture thumbnail;
  const std::vector<PicturedObject> pictured =
      ReadPictured(context, sources->map.map, inputs.classes);
  const std::vector<FrameIdx> with_segments =
      FramesToPicture(sources->segments, sources->map, shown);
  const Result<std::vector<Segment>> segments =
      ReadSegmentsOf(context, Pictured(*sources, with_segments));
  if (!segments.ok()) return segments.error();
  if (!AddObjects(context, inputs, *sources, *segments, pictured, frames, shown, content))
    return Interrupted();
  const std::array<std::function<void()>, 4> pictures = {
      [&] {
        content.photographs = Photographs(
            pictured, RoomWithout(pictured, sources->room), sources->map, frames, shown);
      },
      [&] {
        content.frame_pictures = FramePictures(
            with_segments, *segments, sources->association.tracks, sources->map, frames);
      },
      [&] { content.scene_pictures = ScenePictures(pictured, sources->map); },
      [&] { thumbnail = SceneThumbnail(pictured, sources->room, sources->map); }};
  ParallelFor(pictures.size(), [&](std::size_t n) { pictures[n](); });
  AddManifests(context, content);
  content.sizes.fused_cloud = static_cast<std::size_t>(
      kCloudPointBytes * fuse::ExpectedSurfacePoints(sources->room, kCloudVoxelM));
  if (Status status = context.Write("index.html", report::RenderReport(content)); !status.ok())
    return status.error();
  if (!thumbnail.bytes.empty()) {
    if (Status status = context.Write("thumbnail.jpg", thumbnail.bytes); !status.ok())
      return status.error();
  }
  return StageSummary{fmt::format("{}: {} objects", content.verdict, content.objects.size()), {}};
}

}  // namespace deepslam::stages

#include "deepslam/stages/presentation_inputs.h"

#include <array>
#include <functional>
#include <string>
#include <utility>

#include <fmt/format.h>

#include "deepslam/artifact/json_reader.h"
#include "deepslam/artifact/map_json.h"
#include "deepslam/core/sha256.h"
#include "deepslam/core/side_by_side.h"
#include "deepslam/layout/carry_layout.h"
#include "deepslam/shape/voxel_code.h"
#include "deepslam/stages/plan.h"
#include "deepslam/stages/stage_inputs.h"

namespace deepslam::stages {
namespace {

using pipeline::StageContext;

Result<TriangleMesh> ReadObjectMesh(const StageContext& context, const MapObject& object) {
  return ReadMesh(context, "mesh", fmt::format("objects/{}.ply", ObjectName(object)));
}

Result<presentation::ModelCode> ReadModelCode(const StageContext& context,
                                              const MapObject& object,
                                              const TriangleMesh& mesh) {
  const Result<std::string> binvox =
      context.Read("loops", fmt::format("models/{}.binvox", object.model));
  if (!binvox.ok()) return binvox.error();
  presentation::ModelCode code{Sha256Hex(*binvox), {}};
  if (!object.library_id.empty() || mesh.empty()) return code;
  const Result<VoxelGrid> grid = ReadModel(context, "loops", object.model);
  if (!grid.ok()) return grid.error();
  code.voxel_code = shape::EncodeVoxels(*grid);
  return code;
}

Status ReadMapped(const StageContext& context, ExportInputs& inputs) {
  presentation::FinishedMap& finished = inputs.finished;
  if (Status status = Take(ReadOptimized(context), finished.map); !status.ok()) return status;
  for (const MapObject& object : finished.map.map.objects) {
    Result<TriangleMesh> mesh = ReadObjectMesh(context, object);
    if (!mesh.ok()) return mesh.error();
    Result<presentation::ModelCode> code = ReadModelCode(context, object, *mesh);
    if (!code.ok()) return code.error();
    // Objects may share a model of which one alone has a surface.
    presentation::ModelCode& of_model = inputs.codes.models[object.model];
    of_model.voxels_sha256 = code->voxels_sha256;
    if (!code->voxel_code.empty()) of_model.voxel_code = std::move(code->voxel_code);
    finished.meshes.push_back(std::move(mesh).value());
  }
  return Ok();
}

Result<std::vector<KeyframeJoin>> ReadJoins(const StageContext& context) {
  const Result<Odometry> odometry = ReadOdometry(context);
  if (!odometry.ok()) return odometry.error();
  const Result<Loops> loops = ReadLoops(context);
  if (!loops.ok()) return loops.error();
  return JoinsOf(*odometry, loops->edges);
}

Status ReadCodes(const StageContext& context, presentation::ShapeCodes& codes) {
  Result<Proposals> proposals = ReadCandidates(context, "loops");
  if (!proposals.ok()) return proposals.error();
  codes.candidates = std::move(proposals->candidates);
  return Ok();
}

Status ReadLibraryChecksums(const StageContext& context, presentation::ShapeCodes& codes) {
  const Result<std::string> models = context.Read("propose", "library_models.json");
  if (!models.ok()) return models.error();
  artifact::JsonReader reader(*models, "propose/library_models.json", "deepslam/library_models", 1);
  for (const auto& [id, checksum] : reader.root()["models"].Members())
    codes.library_sha256[id] = checksum.String();
  return reader.ok() ? Ok() : Status(reader.error());
}

Result<std::vector<std::string>> ReadCorrections(const StageContext& context) {
  std::vector<std::string> corrections;
  for (const std::string_view stage : {"ground", "associate", "select"}) {
    const Result<std::vector<std::string>> applied = ReadApplied(context, stage);
    if (!applied.ok()) return applied.error();
    corrections.insert(corrections.end(), applied->begin(), applied->end());
  }
  return corrections;
}

Result<RunVerdict> ReadVerdict(const StageContext& context) {
  const Result<std::string> text = context.Read("export", "map.json");
  if (!text.ok()) return text.error();
  Result<CompactMap> map = artifact::DecodeMap(*text, "export/map.json");
  if (!map.ok()) return map.error();
  return RunVerdict{map->verdict, std::move(map->reasons)};
}

Result<std::vector<presentation::DetectedFrame>> ReadDetectedFrames(const StageContext& context) {
  const Result<artifact::DetectionTable> table = ReadDetections(context);
  if (!table.ok()) return table.error();
  std::vector<presentation::DetectedFrame> frames;
  for (const artifact::DetectedImage& image : table->images)
    frames.push_back({image.frame, image.contains_person});
  return frames;
}

Status ReadShownMap(const StageContext& context, presentation::FinishedMap& finished) {
  if (Status status = Take(ReadOptimized(context), finished.map); !status.ok()) return status;
  for (const MapObject& object : finished.map.map.objects) {
    Result<TriangleMesh> mesh = ReadObjectMesh(context, object);
    finished.meshes.push_back(mesh.ok() ? std::move(mesh).value() : TriangleMesh());
  }
  return Ok();
}

// The layout in the map's world: carried along by the keyframes whose place in the world of the
// first was measured, which it was read from.
Result<Layout> ReadLayoutOf(const StageContext& context, const OptimizedMap& map) {
  Result<Layout> layout = ReadLayout(context);
  if (!layout.ok()) return layout.error();
  const Result<Trajectory> tracked = ReadTrajectory(context);
  if (!tracked.ok()) return tracked.error();
  const Result<Ground> ground = ReadGround(context, "ground");
  if (!ground.ok()) return ground.error();
  const Pose3 level_from_tracking = layout->level_from_tracking;
  std::vector<layout::MovedCamera> cameras;
  for (const FrameIdx keyframe : tracked->keyframes) {
    const auto n = static_cast<std::size_t>(keyframe.value);
    if (n >= map.frames.size() || ApartAt(*ground, keyframe) != nullptr) continue;
    cameras.push_back({level_from_tracking * tracked->frames[n].world_from_camera,
                       map.frames[n].world_from_camera});
  }
  return layout::CarryLayout(std::move(layout).value(), cameras);
}

}  // namespace

presentation::RunIdentity IdentityOf(const dataset::Capture& capture) {
  return {std::string(kToolVersion), capture.name, capture.content_hash};
}

Result<ExportInputs> ReadExportInputs(const StageContext& context) {
  ExportInputs inputs;
  const std::array<std::function<Status()>, 6> readers = {
      [&] { return ReadMapped(context, inputs); },
      [&] { return Take(ReadDoubts(context), inputs.doubts); },
      [&] { return ReadCodes(context, inputs.codes); },
      [&] { return Take(ReadMesh(context, "fuse", "room.ply"), inputs.finished.room_world); },
      [&] { return Take(ReadJoins(context), inputs.joins); },
      [&] { return ReadLibraryChecksums(context, inputs.codes); }};
  if (Status status = RunSideBySide(readers); !status.ok()) return status.error();
  if (Status status =
          Take(ReadLayoutOf(context, inputs.finished.map), inputs.finished.layout_world);
      !status.ok())
    return status.error();
  return inputs;
}

Result<presentation::ReportSources> ReadReportSources(const StageContext& context) {
  presentation::ReportSources sources;
  const auto read_room = [&] {
    if (Result<TriangleMesh> room = ReadMesh(context, "fuse", "room.ply"); room.ok())
      sources.finished.room_world = std::move(room).value();
    return Ok();
  };
  const std::vector<std::function<Status()>> readers = {
      [&] { return Take(ReadSegmentsWithoutMasks(context), sources.segments); },
      [&] { return Take(ReadCandidates(context, "loops"), sources.proposals); },
      [&] { return ReadShownMap(context, sources.finished); },
      [&] { return Take(ReadAssociation(context, "associate"), sources.association); },
      [&] { return Take(ReadTrajectory(context), sources.trajectory); },
      [&] { return Take(ReadDetectedFrames(context), sources.detected); },
      read_room,
      [&] { return Take(ReadGround(context, "ground"), sources.ground); },
      [&] { return Take(ReadLoops(context), sources.loops); },
      [&] { return Take(ReadCorrections(context), sources.corrections); },
      [&] { return Take(context.Read("export", "scene.glb"), sources.scene_glb); },
      [&] { return Take(ReadVerdict(context), sources.verdict); }};
  if (Status status = RunSideBySide(readers); !status.ok()) return status.error();
  if (Status status =
          Take(ReadLayoutOf(context, sources.finished.map), sources.finished.layout_world);
      !status.ok())
    return status.error();
  return sources;
}

}  // namespace deepslam::stages

#include "deepslam/stages/stage_inputs.h"

#include <algorithm>
#include <memory>
#include <set>
#include <utility>

#include <fmt/format.h>

#include "deepslam/artifact/association_json.h"
#include "deepslam/artifact/coarse_surface_file.h"
#include "deepslam/artifact/ground_json.h"
#include "deepslam/artifact/layout_json.h"
#include "deepslam/artifact/loops_json.h"
#include "deepslam/artifact/objects_json.h"
#include "deepslam/artifact/overrides_yaml.h"
#include "deepslam/artifact/ply.h"
#include "deepslam/artifact/pose_graph_g2o.h"
#include "deepslam/artifact/proposals_json.h"
#include "deepslam/artifact/registrations_json.h"
#include "deepslam/artifact/segments_json.h"
#include "deepslam/artifact/trajectory_files.h"
#include "deepslam/core/parallel.h"
#include "deepslam/modelling/candidate_set.h"
#include "deepslam/shape/binvox.h"
#include "deepslam/stages/disk_edge_store.h"

namespace deepslam::stages {
namespace {

using pipeline::StageContext;

template <typename Decoder>
auto Decode(const StageContext& context,
            std::string_view stage,
            std::string_view file,
            const Decoder& decode) -> decltype(decode(std::declval<TextSource>(), file)) {
  Result<TextSource> text = context.Open(stage, file);
  if (!text.ok()) return text.error();
  return decode(std::move(text).value(), StageContext::DisplayName(stage, file));
}

Result<Trajectory> ReadTrajectoryOf(const StageContext& context, std::string_view stage) {
  Result<TextSource> frames = context.Open(stage, "frames.json");
  if (!frames.ok()) return frames.error();
  Result<TextSource> tum = context.Open(stage, "trajectory.tum");
  if (!tum.ok()) return tum.error();
  return artifact::DecodeTrajectory(std::move(frames).value(),
                                    std::move(tum).value(),
                                    StageContext::DisplayName(stage, "frames.json"));
}

}  // namespace

Result<Odometry> ReadOdometry(const StageContext& context) {
  const std::string frames_file = StageContext::DisplayName("track", "frames.json");
  const std::string edges_file = StageContext::DisplayName("track", "odometry.g2o");
  Result<TextSource> frames = context.Open("track", "frames.json");
  Result<TextSource> tum = context.Open("track", "trajectory.tum");
  Result<TextSource> edges = context.Open("track", "odometry.g2o");
  for (const Result<TextSource>* text : {&frames, &tum, &edges}) {
    if (!text->ok()) return text->error();
  }
  const auto edge_store = std::make_shared<DiskEdgeStore>(context.Scratch());
  Result<Trajectory> trajectory = artifact::DecodeOdometry(
      {*std::move(frames), *std::move(tum), *std::move(edges), frames_file, edges_file},
      [&](const RelativePose& edge) { return edge_store->Add(edge); });
  if (!trajectory.ok()) return trajectory.error();
  return Odometry{std::move(trajectory).value(), {}, edge_store};
}

Result<Trajectory> ReadTrajectory(const StageContext& context) {
  return ReadTrajectoryOf(context, "track");
}

Result<Ground> ReadGround(const StageContext& context, std::string_view stage) {
  return Decode(context, stage, "ground.json", artifact::DecodeGround);
}

Result<Layout> ReadLayout(const StageContext& context) {
  return Decode(context, "layout", "layout.json", artifact::DecodeLayout);
}

Result<CoarseSurface> ReadCoarseSurface(const StageContext& context) {
  const Result<std::string> mesh = context.Read("layout", "surface.ply");
  if (!mesh.ok()) return mesh.error();
  const Result<std::string> space = context.Read("layout", "space.bin");
  if (!space.ok()) return space.error();
  return artifact::DecodeCoarseSurface(*mesh,
                                       StageContext::DisplayName("layout", "surface.ply"),
                                       *space,
                                       StageContext::DisplayName("layout", "space.bin"));
}

Result<artifact::DetectionTable> ReadDetections(const StageContext& context) {
  return Decode(context, "detect", "detections.json", artifact::DecodeDetections);
}

Result<std::vector<Segment>> ReadSegments(const StageContext& context, std::string_view stage) {
  return Decode(context, stage, "segments.json", artifact::DecodeSegments);
}

Result<std::vector<Segment>> ReadSegmentsWithoutMasks(const StageContext& context) {
  return Decode(context, "associate", "segments.json", artifact::DecodeSegmentsWithoutMasks);
}

Result<std::vector<Segment>> ReadSegmentsOf(const StageContext& context,
                                            const std::set<DetectionId>& wanted) {
  return Decode(context, "associate", "segments.json", [&](TextSource text, std::string_view name) {
    return artifact::DecodeSegmentsOf(wanted, std::move(text), name);
  });
}

Result<Association> ReadAssociation(const StageContext& context, std::string_view stage) {
  return Decode(context, stage, "tracks.json", artifact::DecodeAssociation);
}

Result<Proposals> ReadProposals(const StageContext& context) {
  return Decode(context, "propose", "candidates.json", artifact::DecodeProposals);
}

Result<Proposals> ReadCandidates(const StageContext& context, std::string_view last_stage) {
  Result<Proposals> all = ReadProposals(context);
  if (!all.ok()) return all.error();
  for (const std::string_view stage : {"select", "loops"}) {
    Result<Proposals> added = Decode(context, stage, "candidates.json", artifact::DecodeProposals);
    if (!added.ok()) return added.error();
    modelling::Append(std::move(added).value(), *all);
    if (stage == last_stage) break;
  }
  return all;
}

std::string_view StageOfModel(CandidateSource source) {
  return TraitsOf(source).is_derived ? "select" : "propose";
}

Result<VoxelGrid> ReadModel(const StageContext& context,
                            std::string_view stage,
                            const std::string& key) {
  const std::string file = fmt::format("models/{}.binvox", key);
  const Result<std::string> bytes = context.Read(stage, file);
  if (!bytes.ok()) return bytes.error();
  Result<VoxelGrid> grid = shape::ReadBinvox(*bytes);
  if (!grid.ok()) return InvalidInput(fmt::format("{}/{}: {}", stage, file, grid.error().message));
  return grid;
}

Result<std::vector<CandidateRegistration>> ReadRegistrations(const StageContext& context) {
  return Decode(context, "register", "registrations.json", artifact::DecodeRegistrations);
}

Result<ObjectMap> ReadObjects(const StageContext& context, std::string_view stage) {
  return Decode(context, stage, "objects.json", artifact::DecodeObjectMap);
}

Result<Loops> ReadLoops(const StageContext& context) {
  return Decode(context, "loops", "loops.json", artifact::DecodeLoops);
}

Result<OptimizedMap> ReadOptimized(const StageContext& context) {
  Result<Trajectory> trajectory = ReadTrajectoryOf(context, "optimize");
  if (!trajectory.ok()) return trajectory.error();
  Result<artifact::OptimizationRecord> record =
      Decode(context, "optimize", "summary.json", artifact::DecodeOptimization);
  if (!record.ok()) return record.error();
  const Result<Ground> ground = ReadGround(context, "optimize");
  if (!ground.ok()) return ground.error();
  Result<ObjectMap> map = ReadObjects(context, "optimize");
  if (!map.ok()) return map.error();
  return OptimizedMap{std::move(trajectory->frames),
                      std::move(trajectory->keyframes),
                      record->ground_world,
                      record->has_ground,
                      std::move(map).value(),
                      record->summary,
                      ground->upright};
}

Result<TriangleMesh> ReadMesh(const StageContext& context,
                              std::string_view stage,
                              const std::string& file) {
  const Result<std::string> bytes = context.Read(stage, file);
  if (!bytes.ok()) return bytes.error();
  Result<artifact::PlyMesh> ply =
      artifact::DecodePly(*bytes, StageContext::DisplayName(stage, file));
  if (!ply.ok()) return ply.error();
  return std::move(ply->mesh);
}

Status WriteEncoded(StageContext& context, std::string_view file, const Result<std::string>& text) {
  if (!text.ok()) return text.error();
  return context.Write(file, *text);
}

Status WriteFiles(StageContext& context, const std::vector<EncodedFile>& files) {
  for (const EncodedFile& file : files) {
    if (Status status = WriteEncoded(context, file.name, file.encode()); !status.ok())
      return status;
  }
  return Ok();
}

Status WriteApplied(StageContext& context, const std::vector<std::string>& applied) {
  return WriteEncoded(
      context, "overrides.json", artifact::EncodeApplied(applied, "overrides.json"));
}

Result<std::vector<std::string>> ReadApplied(const StageContext& context, std::string_view stage) {
  return Decode(context, stage, "overrides.json", artifact::DecodeApplied);
}

Result<std::vector<std::string>> ReadDoubts(const StageContext& context) {
  return Decode(context, "detect", "doubts.json", artifact::DecodeDoubts);
}

Status WriteModels(StageContext& context, const std::map<std::string, VoxelGrid>& grids) {
  std::vector<const VoxelGrid*> in_order;
  for (const auto& [key, grid] : grids) in_order.push_back(&grid);
  std::vector<std::string> encoded(in_order.size());
  ParallelFor(encoded.size(),
              [&](std::size_t n) { encoded[n] = shape::WriteBinvox(*in_order[n]); });
  std::size_t n = 0;
  for (const auto& [key, grid] : grids) {
    Status status = context.Write(fmt::format("models/{}.binvox", key), encoded[n++]);
    if (!status.ok()) return status;
  }
  return Ok();
}

Status CopyChosenModels(StageContext& context,
                        const ObjectMap& map,
                        const std::map<std::string, VoxelGrid>& own) {
  std::map<std::string, std::string_view> stages;
  for (const MapObject& object : map.objects) {
    if (!object.model.empty() && !own.contains(object.model))
      stages.emplace(object.model, StageOfModel(object.source));
  }
  for (const auto& [key, stage] : stages) {
    const std::string file = fmt::format("models/{}.binvox", key);
    if (Status status = WriteEncoded(context, file, context.Read(stage, file)); !status.ok())
      return status;
  }
  return Ok();
}

Status CheckOfThisCapture(std::size_t num_frames,
                          std::span<const Segment> segments,
                          const FrameSource& frames) {
  const PinholeCamera& camera = frames.camera();
  const bool same_images = std::ranges::all_of(segments, [&](const Segment& segment) {
    return !segment.usable ||
           (segment.mask.width() == camera.width && segment.mask.height() == camera.height);
  });
  if (same_images && static_cast<int>(num_frames) == frames.num_frames()) return Ok();
  return InvalidInput(
      fmt::format("the workspace was made of another capture: {} frames there, {} of {} x {} px "
                  "here; name the capture it was made of",
                  num_frames,
                  frames.num_frames(),
                  camera.width,
                  camera.height));
}

}  // namespace deepslam::stages

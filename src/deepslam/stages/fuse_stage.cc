// fuse: the room's measured surface.
#include <utility>
#include <vector>

#include <fmt/format.h>

#include "deepslam/artifact/ply.h"
#include "deepslam/fuse/choose_frames.h"
#include "deepslam/fuse/fuse_frames.h"
#include "deepslam/fuse/object_masks.h"
#include "deepslam/stages/plan.h"
#include "deepslam/stages/stage_inputs.h"

namespace deepslam::stages {
namespace {

using fuse::ObjectMasks;
using pipeline::StageContext;
using pipeline::StageSummary;

// The pixels of objects that are in the map.
Result<ObjectMasks> ReadMasks(const StageContext& context, const OptimizedMap& map) {
  const Result<Association> association = ReadAssociation(context, "loops");
  if (!association.ok()) return association.error();
  const Result<std::vector<Segment>> segments =
      ReadSegmentsOf(context, fuse::DetectionsOfMap(map, *association));
  if (!segments.ok()) return segments.error();
  const Result<artifact::DetectionTable> detections = ReadDetections(context);
  if (!detections.ok()) return detections.error();
  std::vector<FrameIdx> looked_at;
  for (const artifact::DetectedImage& image : detections->images) looked_at.push_back(image.frame);
  return fuse::MasksByFrame(looked_at, map.keyframes, *segments);
}

StageSummary Summarise(std::size_t num_frames, const TriangleMesh& surface) {
  return {fmt::format("{} frames, {} vertices, {} faces",
                      num_frames,
                      surface.vertices.size(),
                      surface.faces.size()),
          {{"num_frames", static_cast<double>(num_frames)},
           {"num_vertices", static_cast<double>(surface.vertices.size())},
           {"num_faces", static_cast<double>(surface.faces.size())}}};
}

}  // namespace

Result<StageSummary> RunFuse(StageContext& context, const RunInputs& inputs) {
  const Config& config = inputs.config;
  const Result<OptimizedMap> map = ReadOptimized(context);
  if (!map.ok()) return map.error();
  const bool leave_out = config.fuse_stage.leave_objects_out;
  const Result<ObjectMasks> masks = leave_out ? ReadMasks(context, *map) : ObjectMasks();
  if (!masks.ok()) return masks.error();
  const std::vector<FrameIdx> wanted = leave_out
                                           ? fuse::FramesWithMasks(map->frames, *masks)
                                           : fuse::FramesToFuse(map->frames, fuse::FrameChoice());
  if (wanted.empty()) context.progress().Warn("no frame to fuse: the room stays empty");
  Result<TriangleMesh> surface = fuse::FuseFrames(
      {*inputs.capture->frames, map->frames, *masks}, wanted, config.fuse, context.progress());
  if (!surface.ok()) return surface.error();
  const StageSummary summary = Summarise(wanted.size(), *surface);
  const Result<std::string> ply =
      artifact::EncodePly({std::move(surface).value(), {}, {}}, "room.ply");
  if (Status status = WriteEncoded(context, "room.ply", ply); !status.ok()) return status.error();
  return summary;
}

}  // namespace deepslam::stages

// fuse: the room's measured surface.
#include <algorithm>
#include <map>
#include <set>
#include <utility>
#include <vector>

#include <fmt/format.h>

#include "deepslam/artifact/ply.h"
#include "deepslam/fuse/choose_frames.h"
#include "deepslam/fuse/tsdf.h"
#include "deepslam/stages/plan.h"
#include "deepslam/stages/stage_inputs.h"

namespace deepslam::stages {
namespace {

using pipeline::StageContext;
using pipeline::StageSummary;

// Per frame the pixels of objects that are in the map; empty when they are not to be left out.
using ObjectMasks = std::map<FrameIdx, std::vector<PixelMask>>;

void Cover(const Mask& part, Mask& whole) {
  if (whole.empty()) whole = Mask(part.width(), part.height());
  if (whole.width() != part.width() || whole.height() != part.height()) return;
  std::transform(
      whole.begin(), whole.end(), part.begin(), whole.begin(), [](std::uint8_t a, std::uint8_t b) {
        return static_cast<std::uint8_t>(a | b);
      });
}

// Empty where there are none.
Mask Union(const ObjectMasks& masks, FrameIdx frame) {
  Mask whole;
  if (const auto of_frame = masks.find(frame); of_frame != masks.end()) {
    for (const PixelMask& mask : of_frame->second) Cover(mask.Unpacked(), whole);
  }
  return whole;
}

Result<ObjectMasks> ReadMasks(const StageContext& context, const OptimizedMap& map) {
  const Result<Association> association = ReadAssociation(context, "loops");
  if (!association.ok()) return association.error();
  std::set<ObjectId> mapped;
  for (const MapObject& object : map.map.objects) mapped.insert(object.id);
  std::set<DetectionId> members;
  for (const ObjectTrack& track : association->tracks) {
    if (!mapped.contains(track.id)) continue;
    for (const TrackMember& member : track.members) members.insert(member.detection);
  }
  const Result<std::vector<Segment>> segments = ReadSegmentsOf(context, members);
  if (!segments.ok()) return segments.error();
  // Frames in which nothing was found have nothing to leave out.
  const Result<artifact::DetectionTable> detections = ReadDetections(context);
  if (!detections.ok()) return detections.error();
  ObjectMasks masks;
  for (const artifact::DetectedImage& image : detections->images) masks[image.frame];
  for (const Segment& segment : *segments) masks[segment.frame].push_back(segment.mask);
  return masks;
}

std::vector<FrameIdx> FramesToFuse(const OptimizedMap& map,
                                   const ObjectMasks& masks,
                                   const Config& config) {
  if (!config.fuse_stage.leave_objects_out)
    return fuse::FramesToFuse(map.frames, config.fuse_frames);
  std::vector<FrameIdx> wanted;
  for (const TrackedFrame& frame : map.frames) {
    if (IsAligned(frame) && masks.contains(frame.frame)) wanted.push_back(frame.frame);
  }
  return wanted;
}

}  // namespace

Result<StageSummary> RunFuse(StageContext& context, const RunInputs& inputs) {
  const Result<OptimizedMap> map = ReadOptimized(context);
  if (!map.ok()) return map.error();
  ObjectMasks masks;
  if (inputs.config.fuse_stage.leave_objects_out) {
    Result<ObjectMasks> read = ReadMasks(context, *map);
    if (!read.ok()) return read.error();
    masks = std::move(read).value();
  }
  const FrameSource& frames = *inputs.capture->frames;
  const std::vector<FrameIdx> wanted = FramesToFuse(*map, masks, inputs.config);
  if (wanted.empty()) context.progress().Warn("no frame to fuse: the room stays empty");
  fuse::TsdfFusion fusion(inputs.config.fuse);
  const auto integrate = [&](const Frame& frame) -> Status {
    const Mask objects = Union(masks, frame.idx);
    const Pose3& world_from_camera =
        map->frames[static_cast<std::size_t>(frame.idx.value)].world_from_camera;
    return fusion.Integrate(
        frame, frames.camera(), world_from_camera, objects.empty() ? nullptr : &objects);
  };
  if (Status status = ForFrames(context, frames, wanted, integrate); !status.ok())
    return status.error();
  TriangleMesh room = std::move(fusion).TakeMesh();
  const StageSummary summary{fmt::format("{} frames, {} vertices, {} faces",
                                         wanted.size(),
                                         room.vertices.size(),
                                         room.faces.size()),
                             {{"num_frames", static_cast<double>(wanted.size())},
                              {"num_vertices", static_cast<double>(room.vertices.size())},
                              {"num_faces", static_cast<double>(room.faces.size())}}};
  const Result<std::string> ply = artifact::EncodePly({std::move(room), {}, {}}, "room.ply");
  if (Status status = WriteEncoded(context, "room.ply", ply); !status.ok()) return status.error();
  return summary;
}

}  // namespace deepslam::stages

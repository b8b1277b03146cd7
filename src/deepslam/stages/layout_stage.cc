// layout: the room itself, and the coarse surface of the whole capture that it is read from.
#include <algorithm>
#include <cstddef>
#include <string>
#include <utility>
#include <vector>

#include <fmt/format.h>

#include "deepslam/artifact/coarse_surface_file.h"
#include "deepslam/artifact/layout_json.h"
#include "deepslam/frames/for_frames.h"
#include "deepslam/fuse/choose_frames.h"
#include "deepslam/fuse/coarse_fusion.h"
#include "deepslam/graph/gravity_world.h"
#include "deepslam/layout/estimate_layout.h"
#include "deepslam/stages/plan.h"
#include "deepslam/stages/stage_inputs.h"

namespace deepslam::stages {
namespace {

using pipeline::StageContext;
using pipeline::StageSummary;

// Those whose place in the world of the first keyframe was measured.
std::vector<FrameIdx> FramesOfOneWorld(const Trajectory& trajectory,
                                       const Ground& ground,
                                       const fuse::FrameChoice& choice) {
  std::vector<TrackedFrame> frames;
  for (const TrackedFrame& frame : trajectory.frames) {
    if (ApartAt(ground, frame.frame) == nullptr) frames.push_back(frame);
  }
  return fuse::FramesToFuse(frames, choice);
}

Result<CoarseSurface> FuseCoarse(const StageContext& context,
                                 const RunInputs& inputs,
                                 const Trajectory& trajectory,
                                 const Ground& ground) {
  const FrameSource& frames = *inputs.capture->frames;
  Pose3 level_from_tracking;
  if (!trajectory.frames.empty()) {
    level_from_tracking = graph::GravityFromTracking(trajectory.frames.front().world_from_camera,
                                                     ground.plane_world,
                                                     ground.upright.value_or(QuarterTurn::kNone));
  }
  fuse::CoarseFusion fusion(inputs.config.coarse);
  const auto integrate = [&](const Frame& frame) {
    return fusion.Integrate(
        frame, frames.camera(), level_from_tracking * trajectory.at(frame.idx).world_from_camera);
  };
  const std::vector<FrameIdx> wanted =
      FramesOfOneWorld(trajectory, ground, inputs.config.coarse_frames);
  if (Status status =
          ForFrames(frames, wanted, context.progress(), integrate, FrameContent::kDepth);
      !status.ok())
    return status.error();
  if (fusion.surface_full()) {
    context.progress().Warn(
        "the capture outgrows layout.surface.max_voxel_blocks: what lies beyond is left out of the "
        "layout");
  }
  CoarseSurface surface = std::move(fusion).Take();
  surface.level_from_tracking = level_from_tracking;
  surface.has_ground = ground.plane_world.has_value();
  return surface;
}

StageSummary Summarise(const CoarseSurface& surface, const Layout& layout) {
  StageSummary summary{fmt::format("{} rooms, {} walls, {} openings out of {} frames, {} vertices",
                                   layout.rooms.size(),
                                   layout.walls.size(),
                                   layout.openings.size(),
                                   surface.viewpoints.size(),
                                   surface.mesh.vertices.size()),
                       {{"num_rooms", static_cast<double>(layout.rooms.size())},
                        {"num_walls", static_cast<double>(layout.walls.size())},
                        {"num_openings", static_cast<double>(layout.openings.size())},
                        {"num_vertices", static_cast<double>(surface.mesh.vertices.size())}}};
  for (const std::string& note : layout.notes) summary.line += "; " + note;
  return summary;
}

}  // namespace

Result<StageSummary> RunLayout(StageContext& context, const RunInputs& inputs) {
  const Result<Trajectory> trajectory = ReadTrajectory(context);
  if (!trajectory.ok()) return trajectory.error();
  const Result<Ground> ground = ReadGround(context, "ground");
  if (!ground.ok()) return ground.error();
  const Result<CoarseSurface> surface = FuseCoarse(context, inputs, *trajectory, *ground);
  if (!surface.ok()) return surface.error();
  const Layout layout = layout::EstimateLayout(*surface, inputs.config.layout);
  const std::vector<EncodedFile> files = {
      {"layout.json", [&] { return artifact::EncodeLayout(layout, "layout.json"); }},
      {"surface.ply", [&] { return artifact::EncodeSurfaceMesh(*surface, "surface.ply"); }},
      {"space.bin", [&] { return Result<std::string>(artifact::EncodeSpace(*surface)); }}};
  if (Status status = WriteFiles(context, files); !status.ok()) return status.error();
  return Summarise(*surface, layout);
}

}  // namespace deepslam::stages

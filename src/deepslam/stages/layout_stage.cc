// layout: the room itself, and the coarse surface of the whole capture that it is read from.
#include <string>
#include <vector>

#include <fmt/format.h>

#include "deepslam/artifact/coarse_surface_file.h"
#include "deepslam/artifact/layout_json.h"
#include "deepslam/fuse/fuse_coarse.h"
#include "deepslam/graph/gravity_world.h"
#include "deepslam/layout/estimate_layout.h"
#include "deepslam/stages/plan.h"
#include "deepslam/stages/stage_inputs.h"

namespace deepslam::stages {
namespace {

using pipeline::StageContext;
using pipeline::StageSummary;

Pose3 LevelFromTracking(const Trajectory& trajectory, const Ground& ground) {
  if (trajectory.frames.empty()) return {};
  return graph::GravityFromTracking(trajectory.frames.front().world_from_camera,
                                    ground.plane_world,
                                    ground.upright.value_or(QuarterTurn::kNone));
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
  const std::vector<FrameIdx> wanted =
      fuse::CoarseFrames(trajectory->frames, *ground, fuse::CoarseFrameChoice());
  const Result<CoarseSurface> surface = fuse::FuseCoarse({*inputs.capture->frames,
                                                          trajectory->frames,
                                                          LevelFromTracking(*trajectory, *ground),
                                                          ground->plane_world.has_value()},
                                                         wanted,
                                                         inputs.config.coarse,
                                                         context.progress());
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

// ground: the floor, per keyframe and once for the world.
#include <fmt/format.h>

#include "deepslam/artifact/ground_json.h"
#include "deepslam/ground/ground_plane.h"
#include "deepslam/stages/apply_overrides.h"
#include "deepslam/stages/plan.h"
#include "deepslam/stages/stage_inputs.h"

namespace deepslam::stages {

using pipeline::StageContext;
using pipeline::StageSummary;

Result<StageSummary> RunGround(StageContext& context, const RunInputs& inputs) {
  const Result<Odometry> odometry = ReadOdometry(context);
  if (!odometry.ok()) return odometry.error();
  Result<Ground> ground = ground::EstimateGround(
      *inputs.capture->frames, *odometry, inputs.config.ground, context.progress());
  if (!ground.ok()) return ground.error();
  const std::vector<std::string> applied = ApplyToGround(inputs.overrides, *odometry, *ground);
  if (Status status = WriteApplied(context, applied); !status.ok()) return status.error();
  if (Status status =
          WriteEncoded(context, "ground.json", artifact::EncodeGround(*ground, "ground.json"));
      !status.ok()) {
    return status.error();
  }
  const double seen = static_cast<double>(ground->observations.size());
  if (!ground->plane_world) return StageSummary{"no ground found", {{"num_observations", seen}}};
  return StageSummary{fmt::format("seen in {} of {} keyframes, {:.3f} m below the first camera",
                                  ground->observations.size(),
                                  odometry->keyframes.size(),
                                  ground->plane_world->d_m),
                      {{"num_observations", seen}, {"first_height_m", ground->plane_world->d_m}}};
}

}  // namespace deepslam::stages

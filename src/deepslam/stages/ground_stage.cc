// ground: the floor, per keyframe and once for the world.
#include <algorithm>
#include <array>
#include <cstddef>
#include <string_view>
#include <vector>

#include <fmt/format.h>

#include "deepslam/artifact/ground_json.h"
#include "deepslam/ground/ground_plane.h"
#include "deepslam/overrides/apply_to_ground.h"
#include "deepslam/scene/upright_turns.h"
#include "deepslam/stages/plan.h"
#include "deepslam/stages/stage_inputs.h"

namespace deepslam::stages {

using pipeline::StageContext;
using pipeline::StageSummary;

namespace {

// The turn that most pictures need; empty where they stand.
std::string_view HowTurned(const Ground& ground, const Odometry& odometry) {
  constexpr std::array<std::string_view, 4> kHow = {
      "", "a quarter clockwise", "half round", "a quarter anticlockwise"};
  const std::vector<QuarterTurn> turns = UprightTurns(odometry.frames, ground);
  return kHow[static_cast<std::size_t>(MostCommon(turns))];
}

StageSummary Summarise(const Ground& ground, const Odometry& odometry) {
  const std::size_t num_keyframes = odometry.keyframes.size();
  const std::size_t seen = ground.observations.size();
  StageSummary summary{"no ground found", {{"num_observations", static_cast<double>(seen)}}};
  if (seen > 0) summary.line = fmt::format("seen in {} of {} keyframes", seen, num_keyframes);
  if (ground.plane_world) {
    summary.line += fmt::format(", {:.3f} m below the first camera", ground.plane_world->d_m);
    summary.figures["first_height_m"] = ground.plane_world->d_m;
  }
  if (const std::string_view how = HowTurned(ground, odometry); !how.empty())
    summary.line += fmt::format("; pictures stand when turned {}", how);
  if (!ground.apart.empty()) {
    const auto known = std::ranges::count_if(
        ground.apart, [](const GroundApart& apart) { return apart.plane_world.has_value(); });
    summary.line += fmt::format(
        "; {} sub-trajectories that tracking did not measure against the first, with a ground "
        "of their own in {}",
        ground.apart.size(),
        known);
  }
  return summary;
}

}  // namespace

Result<StageSummary> RunGround(StageContext& context, const RunInputs& inputs) {
  const Result<Odometry> odometry = ReadOdometry(context);
  if (!odometry.ok()) return odometry.error();
  Result<Ground> ground = ground::EstimateGround(
      *inputs.capture->frames, *odometry, inputs.config.ground, context.progress());
  if (!ground.ok()) return ground.error();
  const std::vector<std::string> applied =
      overrides::ApplyToGround(inputs.overrides, *odometry, *ground);
  if (Status status = WriteApplied(context, applied); !status.ok()) return status.error();
  if (Status status =
          WriteEncoded(context, "ground.json", artifact::EncodeGround(*ground, "ground.json"));
      !status.ok()) {
    return status.error();
  }
  return Summarise(*ground, *odometry);
}

}  // namespace deepslam::stages

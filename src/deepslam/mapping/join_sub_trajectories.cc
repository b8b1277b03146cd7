#include "deepslam/mapping/join_sub_trajectories.h"

#include <algorithm>
#include <cstddef>
#include <iterator>
#include <utility>
#include <vector>

#include "deepslam/scene/measured_parts.h"

namespace deepslam::mapping {
namespace {

// The edges between sub-trajectories. Those within one are the loops' business, which measure the
// whole path.
std::vector<RelativePose> Between(const std::vector<RelativePose>& edges,
                                  const std::vector<int>& part_of_frame) {
  const auto part = [&](FrameIdx frame) {
    return part_of_frame[static_cast<std::size_t>(frame.value)];
  };
  std::vector<RelativePose> between;
  std::ranges::copy_if(edges, std::back_inserter(between), [&](const RelativePose& edge) {
    return part(edge.i) != part(edge.j);
  });
  return between;
}

}  // namespace

void Describe(OptionsVisitor& visitor, JoiningOptions& options) {
  visitor.Field("enabled",
                options.enabled,
                "join what comes before and behind a loss where both show one place; not with "
                "poses of the capture");
}

int CountSubTrajectories(const Odometry& odometry) {
  int count = 0;
  for (const MeasuredSubTrajectory& sub_trajectory :
       MeasuredSubTrajectories(odometry.frames, odometry.keyframes, JoinsOf(odometry)))
    count = std::max(count, sub_trajectory.part + 1);
  return count;
}

Result<Odometry> JoinSubTrajectories(const FrameSource& frames,
                                     Odometry odometry,
                                     const AppearanceClosing& options,
                                     Progress& progress) {
  if (CountSubTrajectories(odometry) < 2) return odometry;
  const Result<ClosedTrajectory> closed =
      CloseByAppearance(frames, odometry, Ground(), options, progress);
  if (progress.StopRequested()) return Interrupted();
  if (!closed.ok()) {
    progress.Warn("sub-trajectories stay as tracked: " + closed.error().message);
    return odometry;
  }
  std::vector<RelativePose> joins =
      Between(closed->appearance.edges, PartsOfFrames(odometry, JoinsOf(odometry)));
  if (joins.empty()) return odometry;
  odometry.frames = closed->frames;
  std::ranges::move(joins, std::back_inserter(odometry.edges));
  return odometry;
}

}  // namespace deepslam::mapping

#include "deepslam/scene/measured_parts.h"

#include <algorithm>
#include <cstddef>
#include <iterator>
#include <map>
#include <numeric>
#include <utility>

namespace deepslam {
namespace {

class Parts {
 public:
  explicit Parts(std::size_t num_keyframes) : parent_(num_keyframes) {
    std::iota(parent_.begin(), parent_.end(), std::size_t{0});
  }

  [[nodiscard]] std::size_t RootOf(std::size_t k) const {
    while (parent_[k] != k) k = parent_[k];
    return k;
  }

  void Join(std::size_t a, std::size_t b) {
    const std::size_t root_a = RootOf(a);
    const std::size_t root_b = RootOf(b);
    parent_[std::max(root_a, root_b)] = std::min(root_a, root_b);
  }

 private:
  std::vector<std::size_t> parent_;  // never above its own position
};

// Positions in the list of keyframes, ascending; nothing of other frames.
class Positions {
 public:
  explicit Positions(std::span<const FrameIdx> keyframes) : keyframes_(keyframes) {}

  [[nodiscard]] bool Find(const KeyframeJoin& join, std::size_t& older, std::size_t& newer) const {
    const auto [low, high] = std::minmax(join.i, join.j);
    return Find(low, older) && Find(high, newer) && older != newer;
  }

 private:
  [[nodiscard]] bool Find(FrameIdx frame, std::size_t& position) const {
    const auto at = std::lower_bound(keyframes_.begin(), keyframes_.end(), frame);
    position = static_cast<std::size_t>(at - keyframes_.begin());
    return at != keyframes_.end() && *at == frame;
  }

  std::span<const FrameIdx> keyframes_;
};

// Per keyframe: its edge from the one before was not measured. A composed edge between frames that
// were tracked all the way is chained from measurements; beside a measured edge to an earlier
// keyframe it stands for a loss.
std::vector<bool> JoinedByGuess(std::span<const TrackedFrame> frames,
                                std::span<const FrameIdx> keyframes,
                                std::span<const KeyframeJoin> joins,
                                const Positions& positions) {
  std::vector<bool> composed(keyframes.size(), false);
  std::vector<bool> measured(keyframes.size(), false);
  std::size_t older = 0, newer = 0;
  for (const KeyframeJoin& join : joins) {
    if (!positions.Find(join, older, newer)) continue;
    if (!join.composed) measured[newer] = true;
    if (join.composed && newer == older + 1) composed[newer] = true;
  }
  std::vector<bool> guessed(keyframes.size(), false);
  for (std::size_t k = 0; k < keyframes.size(); ++k) {
    const TrackedFrame& frame = frames[static_cast<std::size_t>(keyframes[k].value)];
    guessed[k] = composed[k] && (frame.status == TrackingStatus::kLost || measured[k]);
  }
  return guessed;
}

}  // namespace

std::vector<KeyframeJoin> JoinsOf(const Odometry& odometry, std::span<const RelativePose> later) {
  std::vector<KeyframeJoin> joins;
  joins.reserve(odometry.num_edges() + later.size());
  const auto add = [&](const RelativePose& edge) {
    joins.push_back({edge.i, edge.j, edge.composed});
  };
  odometry.ForEachEdge(add);
  std::ranges::for_each(later, add);
  return joins;
}

std::vector<MeasuredSubTrajectory> MeasuredSubTrajectories(std::span<const TrackedFrame> frames,
                                                           std::span<const FrameIdx> keyframes,
                                                           std::span<const KeyframeJoin> joins) {
  const Positions positions(keyframes);
  Parts parts(keyframes.size());
  const std::vector<bool> guessed = JoinedByGuess(frames, keyframes, joins, positions);
  for (std::size_t k = 1; k < keyframes.size(); ++k) {
    if (!guessed[k]) parts.Join(k - 1, k);
  }
  std::size_t older = 0, newer = 0;
  for (const KeyframeJoin& join : joins) {
    if (!join.composed && positions.Find(join, older, newer)) parts.Join(older, newer);
  }
  std::map<std::size_t, int> number_of;  // by root; roots come first, so in order of appearance
  std::vector<MeasuredSubTrajectory> sub_trajectories;
  for (std::size_t k = 0; k < keyframes.size(); ++k) {
    const int part =
        number_of.emplace(parts.RootOf(k), static_cast<int>(number_of.size())).first->second;
    const int position = static_cast<int>(k);
    if (sub_trajectories.empty() || sub_trajectories.back().part != part)
      sub_trajectories.push_back({part, position, position});
    sub_trajectories.back().end_keyframe = position + 1;
  }
  return sub_trajectories;
}

std::vector<int> PartsOfFrames(const Trajectory& trajectory, std::span<const KeyframeJoin> joins) {
  std::vector<int> parts(trajectory.frames.size(), 0);
  std::vector<FrameIdx> keyframes;
  std::ranges::copy_if(trajectory.keyframes, std::back_inserter(keyframes), [&](FrameIdx keyframe) {
    return keyframe.valid() && static_cast<std::size_t>(keyframe.value) < parts.size();
  });
  for (const MeasuredSubTrajectory& sub_trajectory :
       MeasuredSubTrajectories(trajectory.frames, keyframes, joins)) {
    const FrameIdx first = keyframes[static_cast<std::size_t>(sub_trajectory.first_keyframe)];
    if (sub_trajectory.first_keyframe > 0)
      std::fill(parts.begin() + first.value, parts.end(), sub_trajectory.part);
  }
  return parts;
}

}  // namespace deepslam

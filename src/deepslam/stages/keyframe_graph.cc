#include "deepslam/stages/keyframe_graph.h"

#include <algorithm>
#include <cstddef>
#include <span>
#include <utility>
#include <vector>

#include "deepslam/core/check.h"
#include "deepslam/scene/loop.h"

namespace deepslam::stages {
namespace {

// Frames [first_frame, end_frame), numbered from 0.
struct Stretch {
  int first_frame = 0;
  Odometry odometry;
};

// Goes along shelved edges once, that ascend by j.
class ShelfWindow {
 public:
  explicit ShelfWindow(const ShelvedEdges* shelf) : shelf_(shelf) {}

  // All that join keyframes from `first` to `last`, and some more; both never go back.
  [[nodiscard]] const std::vector<RelativePose>& Around(FrameIdx first, FrameIdx last) {
    constexpr std::size_t kAtOnce = 256;
    std::erase_if(edges_, [&](const RelativePose& edge) { return edge.i < first; });
    while (shelf_ != nullptr && next_ < shelf_->size() &&
           (edges_.empty() || edges_.back().j <= last)) {
      const std::size_t count = std::min(kAtOnce, shelf_->size() - next_);
      edges_.resize(edges_.size() + count);
      shelf_->Read(next_, std::span(edges_).last(count));
      next_ += count;
    }
    return edges_;
  }

 private:
  const ShelvedEdges* shelf_;
  std::size_t next_ = 0;
  std::vector<RelativePose> edges_;
};

// Keyframes from `begin` to before `end`, the edges among them, and the frames up to the last of
// them; with all that is before the first keyframe and behind the last one of the path.
Stretch Cut(const Odometry& odometry, std::size_t begin, std::size_t end, ShelfWindow& shelf) {
  const std::vector<FrameIdx>& keyframes = odometry.keyframes;
  const FrameIdx last = keyframes[end - 1];
  const int first_frame = begin == 0 ? 0 : keyframes[begin].value;
  const int end_frame =
      end == keyframes.size() ? static_cast<int>(odometry.frames.size()) : last.value + 1;
  const auto renumbered = [&](FrameIdx frame) { return FrameIdx{frame.value - first_frame}; };
  Stretch stretch{first_frame, {}};
  for (int k = first_frame; k < end_frame; ++k) {
    TrackedFrame& frame =
        stretch.odometry.frames.emplace_back(odometry.frames[static_cast<std::size_t>(k)]);
    frame.frame = renumbered(frame.frame);
    if (frame.keyframe.valid()) frame.keyframe = renumbered(frame.keyframe);
  }
  for (std::size_t n = begin; n < end; ++n)
    stretch.odometry.keyframes.push_back(renumbered(keyframes[n]));
  const auto inside = [&](FrameIdx keyframe) {
    return keyframes[begin] <= keyframe && keyframe <= last;
  };
  const auto add = [&](RelativePose edge) {
    if (!inside(edge.i) || !inside(edge.j)) return;
    edge.i = renumbered(edge.i);
    edge.j = renumbered(edge.j);
    stretch.odometry.edges.push_back(edge);
  };
  std::ranges::for_each(odometry.edges, add);
  std::ranges::for_each(shelf.Around(keyframes[begin], last), add);
  return stretch;
}

// Everything from `seam` on goes to where the solved frames, of which the first is `first_frame`,
// lie about it.
void LayOn(FrameIdx seam,
           int first_frame,
           const std::vector<TrackedFrame>& solved,
           std::vector<TrackedFrame>& frames) {
  const auto before = static_cast<std::size_t>(first_frame);
  const auto at = static_cast<std::size_t>(seam.value) - before;
  const Pose3 moved =
      frames[before + at].world_from_camera * solved[at].world_from_camera.Inverse();
  for (std::size_t k = at; k < solved.size(); ++k)
    frames[before + k].world_from_camera = moved * solved[k].world_from_camera;
}

}  // namespace

Result<SolvedPath> SolvePath(const Odometry& odometry,
                             const Ground& ground,
                             const std::vector<RelativePose>& edges,
                             const graph::GraphOptions& options,
                             const ObjectMap& map) {
  Loops loops;
  loops.edges = edges;
  const Result<OptimizedMap> solved = graph::OptimizeGraph(odometry, ground, map, loops, options);
  if (!solved.ok()) return solved.error();
  const auto first = static_cast<std::size_t>(odometry.keyframes.front().value);
  const Pose3 tracking_from_level =
      odometry.frames[first].world_from_camera * solved->frames[first].world_from_camera.Inverse();
  SolvedPath path{odometry.frames, ground, {}};
  for (std::size_t k = 0; k < path.frames.size(); ++k) {
    path.frames[k].world_from_camera = tracking_from_level * solved->frames[k].world_from_camera;
  }
  if (solved->has_ground)
    path.ground.plane_world = Transformed(tracking_from_level, solved->ground_world);
  for (GroundApart& apart : path.ground.apart) {
    if (!apart.plane_world) continue;
    const auto own = static_cast<std::size_t>(apart.first.value);
    const Pose3 solved_from_tracked =
        path.frames[own].world_from_camera * odometry.frames[own].world_from_camera.Inverse();
    apart.plane_world = Transformed(solved_from_tracked, *apart.plane_world);
  }
  for (const MapObject& object : solved->map.objects)
    path.world_from_object.push_back(tracking_from_level * object.world_from_object);
  return path;
}

Result<std::vector<TrackedFrame>> SolveStretches(const Odometry& odometry,
                                                 const graph::GraphOptions& options,
                                                 const Stretches& stretches) {
  DEEPSLAM_CHECK(0 <= stretches.overlap && stretches.overlap < stretches.num_keyframes,
                 "stretches have to go on");
  const std::size_t num_keyframes = odometry.keyframes.size();
  const auto num_at_once = static_cast<std::size_t>(stretches.num_keyframes);
  const auto overlap = static_cast<std::size_t>(stretches.overlap);
  if (num_keyframes <= num_at_once) {
    Result<SolvedPath> whole = SolvePath(odometry, Ground{}, {}, options);
    if (!whole.ok()) return whole.error();
    return std::move(whole->frames);
  }
  std::vector<TrackedFrame> frames = odometry.frames;
  ShelfWindow shelf(odometry.more_edges.get());
  std::size_t begin = 0;
  for (std::size_t end = 0; end < num_keyframes; begin = end - overlap) {
    end = std::min(begin + num_at_once, num_keyframes);
    const Stretch stretch = Cut(odometry, begin, end, shelf);
    const Result<SolvedPath> solved = SolvePath(stretch.odometry, Ground{}, {}, options);
    if (!solved.ok()) return solved.error();
    const std::size_t seam = begin == 0 ? 0 : begin + overlap / 2;
    LayOn(odometry.keyframes[seam], stretch.first_frame, solved->frames, frames);
  }
  return frames;
}

}  // namespace deepslam::stages

#include "deepslam/mapping/sub_trajectories.h"

#include <algorithm>
#include <cstddef>
#include <span>
#include <utility>

#include "deepslam/core/check.h"
#include "deepslam/mapping/keyframe_graph.h"
#include "deepslam/scene/edge_store.h"

namespace deepslam::mapping {
namespace {

// Frames from `first_frame` on, numbered from 0.
struct SubTrajectory {
  int first_frame = 0;
  Odometry odometry;
};

// Goes once along edges that ascend by j.
class EdgeWindow {
 public:
  explicit EdgeWindow(const EdgeStore* store) : store_(store) {}

  // All that join keyframes from `first` to `last`, and some more; both never go back.
  [[nodiscard]] const std::vector<RelativePose>& Around(FrameIdx first, FrameIdx last) {
    constexpr std::size_t kEdgesAtOnce = 256;  // 64 KB
    std::erase_if(edges_, [&](const RelativePose& edge) { return edge.i < first; });
    while (store_ != nullptr && next_ < store_->size() &&
           (edges_.empty() || edges_.back().j <= last)) {
      const std::size_t count = std::min(kEdgesAtOnce, store_->size() - next_);
      edges_.resize(edges_.size() + count);
      store_->Read(next_, std::span(edges_).last(count));
      next_ += count;
    }
    return edges_;
  }

 private:
  const EdgeStore* store_;
  std::size_t next_ = 0;
  std::vector<RelativePose> edges_;
};

// Keyframes from `begin` to before `end`, the edges among them, and the frames up to the last of
// them; with all that is before the first keyframe and behind the last one of the path.
SubTrajectory Cut(const Odometry& odometry,
                  std::size_t begin,
                  std::size_t end,
                  EdgeWindow& out_of_core) {
  const std::vector<FrameIdx>& keyframes = odometry.keyframes;
  const FrameIdx last = keyframes[end - 1];
  const int first_frame = begin == 0 ? 0 : keyframes[begin].value;
  const int end_frame =
      end == keyframes.size() ? static_cast<int>(odometry.frames.size()) : last.value + 1;
  const auto renumbered = [&](FrameIdx frame) { return FrameIdx{frame.value - first_frame}; };
  SubTrajectory part{first_frame, {}};
  for (int k = first_frame; k < end_frame; ++k) {
    TrackedFrame& frame =
        part.odometry.frames.emplace_back(odometry.frames[static_cast<std::size_t>(k)]);
    frame.frame = renumbered(frame.frame);
    if (frame.keyframe.valid()) frame.keyframe = renumbered(frame.keyframe);
  }
  for (std::size_t n = begin; n < end; ++n)
    part.odometry.keyframes.push_back(renumbered(keyframes[n]));
  const auto inside = [&](FrameIdx keyframe) {
    return keyframes[begin] <= keyframe && keyframe <= last;
  };
  const auto add = [&](RelativePose edge) {
    if (!inside(edge.i) || !inside(edge.j)) return;
    edge.i = renumbered(edge.i);
    edge.j = renumbered(edge.j);
    part.odometry.edges.push_back(edge);
  };
  std::ranges::for_each(odometry.edges, add);
  std::ranges::for_each(out_of_core.Around(keyframes[begin], last), add);
  return part;
}

// Everything from `seam` on goes to where the solved frames, of which the first is `first_frame`,
// lie about it.
void LayOn(FrameIdx seam,
           int first_frame,
           const std::vector<TrackedFrame>& solved,
           std::vector<TrackedFrame>& frames) {
  const auto before = static_cast<std::size_t>(first_frame);
  const auto at = static_cast<std::size_t>(seam.value) - before;
  const Pose3 world_from_solved =
      frames[before + at].world_from_camera * solved[at].world_from_camera.Inverse();
  for (std::size_t k = at; k < solved.size(); ++k)
    frames[before + k].world_from_camera = world_from_solved * solved[k].world_from_camera;
}

}  // namespace

Result<std::vector<TrackedFrame>> SolveSubTrajectories(const Odometry& odometry,
                                                       const graph::GraphOptions& options,
                                                       const SubTrajectorySizes& sizes) {
  DEEPSLAM_CHECK(0 <= sizes.overlap && sizes.overlap < sizes.num_keyframes,
                 "sub-trajectories have to advance");
  const std::size_t num_keyframes = odometry.keyframes.size();
  const auto num_at_once = static_cast<std::size_t>(sizes.num_keyframes);
  const auto overlap = static_cast<std::size_t>(sizes.overlap);
  if (num_keyframes <= num_at_once) {
    Result<SolvedPath> whole = SolvePath(odometry, Ground{}, {}, options);
    if (!whole.ok()) return whole.error();
    return std::move(whole->frames);
  }
  std::vector<TrackedFrame> frames = odometry.frames;
  EdgeWindow out_of_core(odometry.more_edges.get());
  std::size_t begin = 0;
  for (std::size_t end = 0; end < num_keyframes; begin = end - overlap) {
    end = std::min(begin + num_at_once, num_keyframes);
    const SubTrajectory part = Cut(odometry, begin, end, out_of_core);
    const Result<SolvedPath> solved = SolvePath(part.odometry, Ground{}, {}, options);
    if (!solved.ok()) return solved.error();
    const std::size_t seam = begin == 0 ? 0 : begin + overlap / 2;
    LayOn(odometry.keyframes[seam], part.first_frame, solved->frames, frames);
  }
  return frames;
}

}  // namespace deepslam::mapping

#include "deepslam/loop/neighbours.h"

#include <algorithm>
#include <optional>
#include <set>
#include <utility>

#include "deepslam/core/parallel.h"
#include "deepslam/loop/corner_loop.h"
#include "deepslam/loop/feature_pose.h"
#include "deepslam/loop/keyframe_path.h"

namespace deepslam::loop {
namespace {

constexpr int kAcrossLoss = 3;  // keyframes on either side
constexpr int kTracked = 2;     // keyframes on that tracking itself joins
static_assert(kMostNeighbourGap == 2 * kAcrossLoss - 1 && kTracked <= kMostNeighbourGap);

using Pairs = std::set<NeighbourPair>;

void AddAcross(int before, int after, int num_keyframes, Pairs& pairs) {
  for (int i = std::max(0, before - kAcrossLoss + 1); i <= before; ++i) {
    for (int j = after; j < std::min(num_keyframes, after + kAcrossLoss); ++j) pairs.insert({i, j});
  }
}

}  // namespace

std::vector<NeighbourPair> PoorlyMeasured(const Odometry& odometry, bool depth_alone) {
  const KeyframePath path(odometry, 0);
  Pairs poor;
  odometry.ForEachEdge([&](const RelativePose& edge) {
    const int i = path.IndexOf(edge.i);
    const int j = path.IndexOf(edge.j);
    if (i < 0 || j <= i) return;
    if (edge.composed) AddAcross(j - 1, j, static_cast<int>(odometry.keyframes.size()), poor);
    if (depth_alone && j - i <= kTracked) poor.insert({i, j});
  });
  std::vector<NeighbourPair> pairs(poor.begin(), poor.end());
  std::ranges::stable_sort(pairs, {}, &NeighbourPair::newer);
  return pairs;
}

std::vector<AppearanceLoop> ProposeNeighbours(std::span<const NeighbourPair> pairs,
                                              std::span<const KeyframeFeatures> features,
                                              int first,
                                              const AppearanceOptions& options) {
  if (!options.enabled) return {};
  const int end = first + static_cast<int>(features.size());
  const auto at = [&](int position) -> const KeyframeFeatures& {
    return features[static_cast<std::size_t>(position - first)];
  };
  std::vector<std::optional<AppearanceLoop>> found(pairs.size());
  ParallelFor(pairs.size(), [&](std::size_t k) {
    if (pairs[k].older < first || pairs[k].newer >= end) return;
    const KeyframeFeatures& older = at(pairs[k].older);
    const KeyframeFeatures& newer = at(pairs[k].newer);
    const auto pose = PoseFromFeatures(older, newer, options.min_inliers);
    if (!pose || !BearsOut(*pose)) return;
    found[k] = {older.keyframe,
                newer.keyframe,
                pose->old_from_new,
                pose->num_inliers,
                0,
                0,
                false,
                "not registered"};
  });
  std::vector<AppearanceLoop> proposed;
  for (std::optional<AppearanceLoop>& pair : found) {
    if (pair) proposed.push_back(std::move(*pair));
  }
  return proposed;
}

std::vector<RelativePose> AcceptNeighbours(std::span<const AppearanceLoop> proposed,
                                           std::span<const KeyframeRegistration> registrations) {
  std::vector<RelativePose> edges;
  for (std::size_t k = 0; k < proposed.size(); ++k) {
    if (!Verdict(proposed[k], registrations[k]).empty()) continue;
    edges.push_back(
        {proposed[k].old_keyframe,
         proposed[k].new_keyframe,
         registrations[k].old_from_new,
         EdgeInformation(registrations[k].information, AppearanceOptions::kVarianceScale, 0, 0),
         false});
  }
  return edges;
}

}  // namespace deepslam::loop

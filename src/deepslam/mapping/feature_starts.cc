#include "deepslam/mapping/feature_starts.h"

#include <algorithm>

#include "deepslam/loop/corner_loop.h"
#include "deepslam/loop/feature_pose.h"

namespace deepslam::mapping {
namespace {

constexpr int kMostFeatures = 1000;  // of a frame

}  // namespace

std::optional<tracking::FeatureStart> FeaturePlaces::Find(FrameIdx reference, FrameIdx frame) {
  const loop::AppearanceOptions options;
  FeaturesAt(reference);  // the other may make room
  const loop::GradientFeatures& seen = FeaturesAt(frame);
  const auto pose = loop::PoseFromFeatures(FeaturesAt(reference), seen, options.min_inliers);
  if (!pose || !loop::BearsOut(*pose)) return std::nullopt;
  return tracking::FeatureStart{pose->old_from_new, pose->num_inliers};
}

const loop::GradientFeatures& FeaturePlaces::FeaturesAt(FrameIdx frame) {
  ++num_asked_;
  if (const auto known = entries_.find(frame); known != entries_.end()) {
    known->second.last_asked = num_asked_;
    return known->second.features;
  }
  if (entries_.size() >= most_)
    entries_.erase(std::ranges::min_element(
        entries_, {}, [](const auto& entry) { return entry.second.last_asked; }));
  const Result<Frame> read = frames_.Read(frame);
  Entry entry;
  entry.last_asked = num_asked_;
  if (read.ok())
    entry.features = loop::ExtractGradientFeatures(*read, frames_.camera(), kMostFeatures);
  return entries_.emplace(frame, std::move(entry)).first->second.features;
}

}  // namespace deepslam::mapping

// Where a frame that tracking has lost may be: what points of its image say that others show as
// well.
#pragma once

#include <cstddef>
#include <map>
#include <optional>

#include "deepslam/frames/frame_source.h"
#include "deepslam/loop/keyframe_features.h"
#include "deepslam/tracking/feature_starts.h"

namespace deepslam::mapping {

// Reads frames when it is asked about them, and keeps the points of the latest. Not thread-safe.
class FeaturePlaces {
 public:
  // Of at most `most` frames (0.2 MB each).
  FeaturePlaces(const FrameSource& frames, std::size_t most) : frames_(frames), most_(most) {}

  // Nothing where too few points agree, they lie on one small thing, another pose is nearly as
  // good, or a frame cannot be read.
  [[nodiscard]] std::optional<tracking::FeatureStart> Find(FrameIdx reference, FrameIdx frame);

 private:
  struct Entry {
    loop::GradientFeatures features;
    int last_asked = 0;
  };
  const loop::GradientFeatures& FeaturesAt(FrameIdx frame);

  const FrameSource& frames_;
  std::size_t most_;
  int num_asked_ = 0;
  std::map<FrameIdx, Entry> entries_;
};

}  // namespace deepslam::mapping

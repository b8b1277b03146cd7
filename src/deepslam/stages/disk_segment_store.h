// Segments whose masks, most of what they take, lie in a scratch file: for whoever looks at all
// segments and at the pixels of some of them, again and again.
#pragma once

#include <cstddef>
#include <cstdint>
#include <memory>
#include <set>
#include <span>
#include <vector>

#include "deepslam/core/result.h"
#include "deepslam/modelling/frame_views.h"
#include "deepslam/pipeline/stage.h"
#include "deepslam/scene/detection.h"
#include "deepslam/storage/scratch_file.h"

namespace deepslam::stages {

class DiskSegmentStore final : public modelling::SegmentStore {
 public:
  // Of stage `associate`, in its order.
  [[nodiscard]] static Result<std::shared_ptr<const DiskSegmentStore>> Read(
      const pipeline::StageContext& context);

  [[nodiscard]] std::span<const Segment> without_masks() const override { return segments_; }
  // Those of these detections with their masks, in their order.
  [[nodiscard]] Result<std::vector<Segment>> Of(const std::set<DetectionId>& wanted) const override;

 private:
  // Where a mask's run lengths lie.
  struct Place {
    std::uint64_t at = 0;
    std::size_t num_bytes = 0;
    int width = 0;
    int height = 0;
  };

  [[nodiscard]] Status Add(Segment segment);
  [[nodiscard]] Result<PixelMask> MaskAt(const Place& place) const;

  std::shared_ptr<storage::ScratchFile> file_;
  std::vector<Segment> segments_;
  std::vector<Place> masks_;
};

}  // namespace deepslam::stages

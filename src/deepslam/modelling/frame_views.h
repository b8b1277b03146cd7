// Views of objects cut out of the frames of a capture, batch by batch.
#pragma once

#include <cstddef>
#include <memory>
#include <set>
#include <span>
#include <vector>

#include "deepslam/core/ids.h"
#include "deepslam/core/progress.h"
#include "deepslam/core/result.h"
#include "deepslam/frames/frame_source.h"
#include "deepslam/modelling/view_source.h"
#include "deepslam/observe/object_views.h"
#include "deepslam/scene/detection.h"
#include "deepslam/scene/object_class.h"

namespace deepslam::modelling {

// Segments whose masks, most of what they take, may lie elsewhere than in memory.
class SegmentStore {
 public:
  virtual ~SegmentStore() = default;
  [[nodiscard]] virtual std::span<const Segment> without_masks() const = 0;
  // Those of these detections with their masks, in the order of without_masks().
  [[nodiscard]] virtual Result<std::vector<Segment>> Of(
      const std::set<DetectionId>& wanted) const = 0;
};

// Frames and classes outlive whoever looks; the segments are shared with others.
struct ViewInputs {
  const FrameSource& frames;
  std::shared_ptr<const SegmentStore> segments;
  const ClassTable& classes;  // what an object of a class rests on (observe/own_support.h)
};

class FrameViews final : public ViewSource {
 public:
  // 96 MiB of pixels, held while they are worked on.
  static constexpr std::size_t kBatchBytes = std::size_t{96} << 20;

  // A batch takes further tracks while its views take less than `batch_bytes`. `progress` outlives
  // the source.
  FrameViews(ViewInputs inputs,
             const observe::ViewOptions& options,
             Progress& progress,
             std::size_t batch_bytes = kBatchBytes);

  [[nodiscard]] Status ForBatches(const TrackedObjects& objects,
                                  observe::ViewContent content,
                                  const UseViews& use) const override;

 private:
  ViewInputs inputs_;
  observe::ViewOptions options_;
  Progress& progress_;
  std::size_t batch_bytes_;
};

}  // namespace deepslam::modelling

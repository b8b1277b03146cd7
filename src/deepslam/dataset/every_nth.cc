#include "deepslam/core/check.h"
#include "deepslam/dataset/stored_frames.h"

namespace deepslam::dataset {
namespace {

std::vector<StoredFrame> Taken(const std::vector<StoredFrame>& frames, std::size_t step) {
  std::vector<StoredFrame> taken;
  taken.reserve((frames.size() + step - 1) / step);
  for (std::size_t i = 0; i < frames.size(); i += step) taken.push_back(frames[i]);
  return taken;
}

class EveryNthFrame final : public StoredFrames {
 public:
  EveryNthFrame(std::shared_ptr<const StoredFrames> all, std::size_t step)
      : StoredFrames(all->cameras(), Taken(all->frames(), step)),
        all_(std::move(all)),
        step_(step) {}

  [[nodiscard]] Result<StoredColour> ReadColour(std::size_t i) const override {
    return all_->ReadColour(i * step_);
  }
  [[nodiscard]] Result<RawDepthImage> ReadDepth(std::size_t i) const override {
    return all_->ReadDepth(i * step_);
  }

 private:
  std::shared_ptr<const StoredFrames> all_;
  std::size_t step_;
};

}  // namespace

std::shared_ptr<const StoredFrames> EveryNth(std::shared_ptr<const StoredFrames> all,
                                             std::size_t step) {
  DEEPSLAM_CHECK(step > 0, "frames go on");
  return std::make_shared<EveryNthFrame>(std::move(all), step);
}

}  // namespace deepslam::dataset

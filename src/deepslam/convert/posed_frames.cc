#include "deepslam/convert/posed_frames.h"

#include <memory>
#include <utility>
#include <vector>

#include <fmt/format.h>

#include "deepslam/core/every_nth.h"
#include "deepslam/dataset/read_bytes.h"
#include "deepslam/formats/tum_lists.h"

namespace deepslam::convert {
namespace {

namespace fs = std::filesystem;

// Times are written with all their digits; some programs round them to microseconds.
constexpr double kSameTimeS = 1e-5;

class PosedFrames final : public dataset::StoredFrames {
 public:
  PosedFrames(std::shared_ptr<const dataset::StoredFrames> images,
              std::vector<dataset::StoredFrame> frames)
      : StoredFrames(images->cameras(), std::move(frames)), images_(std::move(images)) {}

  [[nodiscard]] Result<dataset::StoredColour> ReadColour(std::size_t i) const override {
    return images_->ReadColour(i);
  }
  [[nodiscard]] Result<RawDepthImage> ReadDepth(std::size_t i) const override {
    return images_->ReadDepth(i);
  }
  [[nodiscard]] bool colour_in_order() const override { return images_->colour_in_order(); }
  [[nodiscard]] std::shared_ptr<const StoredFrames> Every(std::size_t step) const override {
    return std::make_shared<PosedFrames>(images_->Every(step), EveryNth(frames(), step));
  }

 private:
  std::shared_ptr<const dataset::StoredFrames> images_;
};

Result<fs::path> FindTrajectory(const fs::path& trajectory) {
  std::error_code ignored;
  if (!fs::is_directory(trajectory, ignored)) return trajectory;
  for (const char* stage : {"optimize", "track"}) {
    const fs::path file = trajectory / stage / "trajectory.tum";
    if (fs::is_regular_file(file, ignored)) return file;
  }
  return InvalidInput(
      fmt::format("{}: holds neither optimize/trajectory.tum nor track/trajectory.tum; name the "
                  "folder of a run "
                  "or a file of poses",
                  trajectory.string()));
}

}  // namespace

Status TakePosesOf(const fs::path& trajectory, dataset::Capture& capture) {
  const Result<fs::path> file = FindTrajectory(trajectory);
  if (!file) return file.error();
  const Result<std::string> text = dataset::ReadTextFile(*file);
  if (!text) return text.error();
  const auto poses = formats::ParsePoses(*text, *file, capture.warnings);
  if (!poses) return poses.error();
  std::vector<dataset::StoredFrame> frames = capture.stored->frames();
  bool has_some = false;
  for (dataset::StoredFrame& frame : frames) {
    frame.world_from_colour = formats::PoseAt(*poses, frame.depth_time_s, kSameTimeS, 0);
    has_some = has_some || frame.world_from_colour.has_value();
  }
  if (!has_some) {
    return InvalidInput(fmt::format(
        "{}: has no pose at the time of any frame of {}", file->string(), capture.path.string()));
  }
  capture.stored = std::make_shared<PosedFrames>(capture.stored, std::move(frames));
  capture.has_poses = true;
  capture.poses_fault.clear();
  return Ok();
}

}  // namespace deepslam::convert

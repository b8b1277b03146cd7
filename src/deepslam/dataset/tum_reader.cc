#include "deepslam/dataset/tum_reader.h"

#include <limits>
#include <utility>

#include "deepslam/dataset/image_files.h"

namespace deepslam::dataset {
namespace {

class TumFrameSource final : public FrameSource {
 public:
  TumFrameSource(std::filesystem::path folder,
                 const CaptureSettings& settings,
                 std::vector<ImagePair> pairs,
                 std::vector<std::optional<Pose3>> world_from_camera)
      : folder_(std::move(folder)),
        camera_(settings.camera),
        metres_(std::numeric_limits<std::uint16_t>::max() + 1u, 0.0f),
        pairs_(std::move(pairs)),
        world_from_camera_(std::move(world_from_camera)) {
    DEEPSLAM_CHECK(world_from_camera_.size() == pairs_.size(), "one pose entry per frame");
    for (std::size_t raw = 1; raw + 1 < metres_.size(); ++raw) {
      const double depth_m = static_cast<double>(raw) / settings.depth_units_per_m;
      if (depth_m <= kMaxDepthM) metres_[raw] = static_cast<float>(depth_m);
    }
  }

  [[nodiscard]] int num_frames() const override { return static_cast<int>(pairs_.size()); }
  [[nodiscard]] const PinholeCamera& camera() const override { return camera_; }
  [[nodiscard]] double time_s(FrameIdx frame) const override { return At(frame).depth.time_s; }

  [[nodiscard]] Result<Frame> Read(FrameIdx frame) const override {
    Result<Frame> depth = ReadDepth(frame);
    if (!depth) return depth;
    Result<Frame> colour = ReadColour(frame);
    if (!colour) return colour;
    colour->depth_m = std::move(depth->depth_m);
    return colour;
  }

  [[nodiscard]] Result<Frame> ReadDepth(FrameIdx frame) const override {
    const ImagePair& pair = At(frame);
    const Result<RawDepthImage> raw =
        ReadDepthFile(folder_ / pair.depth.file, camera_.width, camera_.height);
    if (!raw) return raw.error();
    Frame read{frame, pair.depth.time_s, ColourImage(), DepthImage(camera_.width, camera_.height)};
    const std::uint16_t* value = raw->data();
    for (float& depth_m : read.depth_m) depth_m = metres_[*value++];
    return read;
  }

  [[nodiscard]] Result<Frame> ReadColour(FrameIdx frame) const override {
    const ImagePair& pair = At(frame);
    Result<ColourImage> colour =
        ReadColourFile(folder_ / pair.colour.file, camera_.width, camera_.height);
    if (!colour) return colour.error();
    return Frame{frame, pair.depth.time_s, *std::move(colour), DepthImage()};
  }

  [[nodiscard]] std::optional<Pose3> capture_world_from_camera(FrameIdx frame) const override {
    At(frame);
    return world_from_camera_[static_cast<std::size_t>(frame.value)];
  }

 private:
  const ImagePair& At(FrameIdx frame) const {
    DEEPSLAM_CHECK(frame.valid() && frame.value < num_frames(), "frame outside the capture");
    return pairs_[static_cast<std::size_t>(frame.value)];
  }

  std::filesystem::path folder_;
  PinholeCamera camera_;
  std::vector<float> metres_;  // by raw value; 0 = invalid
  std::vector<ImagePair> pairs_;
  std::vector<std::optional<Pose3>> world_from_camera_;
};

}  // namespace

std::unique_ptr<FrameSource> MakeTumFrameSource(
    const std::filesystem::path& folder,
    const CaptureSettings& settings,
    std::vector<ImagePair> pairs,
    std::vector<std::optional<Pose3>> world_from_camera) {
  return std::make_unique<TumFrameSource>(
      folder, settings, std::move(pairs), std::move(world_from_camera));
}

}  // namespace deepslam::dataset

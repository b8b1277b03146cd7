#include <utility>

#include <fmt/format.h>

#include "deepslam/convert/capture_writer.h"
#include "deepslam/dataset/capture_settings.h"
#include "deepslam/formats/pose_matrix.h"

namespace deepslam::convert {
namespace {

namespace fs = std::filesystem;

class WriterOfSevenScenes final : public CaptureWriter {
 public:
  WriterOfSevenScenes(fs::path folder, const WriteSettings& settings)
      : folder_(std::move(folder)), settings_(settings) {}

  [[nodiscard]] Status Add(const WriteFrame& frame) override {
    const std::string stem = fmt::format("frame-{:06d}", frame.number);
    const Result<std::string> bytes = ColourBytes(frame.colour);
    if (!bytes) return bytes.error();
    if (Status status = WriteWhole(folder_ / (stem + ".color.png"), *bytes); !status) return status;
    if (Status status = dataset::WriteDepthFile(folder_ / (stem + ".depth.png"), frame.depth);
        !status)
      return status;
    if (!frame.world_from_colour) return Ok();
    const dataset::CaptureCameras& cameras = settings_.cameras;
    const Pose3 world_from_depth = cameras.colour_from_depth == Pose3()
                                       ? *frame.world_from_colour
                                       : *frame.world_from_colour * cameras.colour_from_depth;
    return WriteWhole(folder_ / (stem + ".pose.txt"), formats::FormatMatrix(world_from_depth));
  }

  [[nodiscard]] Status Finish() override {
    const dataset::CaptureCameras& cameras = settings_.cameras;
    dataset::CaptureSettings settings;
    settings.format = "7-scenes";
    settings.camera = cameras.colour;
    settings.depth_units_per_m = cameras.depth_units_per_m;
    if (!cameras.registered()) {
      settings.depth_camera = cameras.depth;
      settings.colour_from_depth = cameras.colour_from_depth;
    }
    return WriteWhole(folder_ / "capture.yaml", dataset::FormatCaptureSettings(settings));
  }

 private:
  fs::path folder_;
  WriteSettings settings_;
};

}  // namespace

Result<std::unique_ptr<CaptureWriter>> CreateSevenScenes(const fs::path& path,
                                                         const WriteSettings& settings) {
  return std::unique_ptr<CaptureWriter>(std::make_unique<WriterOfSevenScenes>(path, settings));
}

}  // namespace deepslam::convert

// nerfstudio's transforms.json with depth: images/, depth/ in millimetres, one pinhole camera whose
// first pixel has its centre at (0.5, 0.5), transform_matrix as world from a camera with y up and z
// back.
#include <utility>

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include "deepslam/convert/capture_writer.h"

namespace deepslam::convert {
namespace {

namespace fs = std::filesystem;
using nlohmann::ordered_json;

// Nerfstudio: the top-left pixel's centre is (0.5, 0.5), here (0, 0).
constexpr double kPixelCentre = 0.5;

ordered_json MatrixOfOpenGl(const Pose3& world_from_camera) {
  // Half a turn about x.
  const Pose3 camera_from_open_gl{Eigen::Quaterniond(0, 1, 0, 0), Eigen::Vector3d::Zero()};
  const Eigen::Matrix4d matrix = (world_from_camera * camera_from_open_gl).Matrix();
  ordered_json rows = ordered_json::array();
  for (int row = 0; row < 4; ++row)
    rows.push_back({matrix(row, 0), matrix(row, 1), matrix(row, 2), matrix(row, 3)});
  return rows;
}

class WriterOfNerfstudio final : public CaptureWriter {
 public:
  WriterOfNerfstudio(fs::path folder, const WriteSettings& settings)
      : folder_(std::move(folder)), settings_(settings) {}

  [[nodiscard]] Status Add(const WriteFrame& frame) override {
    const std::string colour =
        fmt::format("images/frame_{:06d}{}", frame.number, ColourEnd(frame.colour));
    const std::string depth = fmt::format("depth/frame_{:06d}.png", frame.number);
    const Result<std::string> bytes = ColourBytes(frame.colour);
    if (!bytes) return bytes.error();
    if (Status status = WriteWhole(folder_ / colour, *bytes); !status) return status;
    if (Status status = dataset::WriteDepthFile(folder_ / depth, frame.depth); !status)
      return status;
    frames_.push_back({{"file_path", colour},
                       {"depth_file_path", depth},
                       {"transform_matrix", MatrixOfOpenGl(*frame.world_from_colour)}});
    return Ok();
  }

  [[nodiscard]] Status Finish() override {
    const PinholeCamera& c = settings_.cameras.colour;
    const ordered_json root = {{"camera_model", "OPENCV"},
                               {"w", c.width},
                               {"h", c.height},
                               {"fl_x", c.fx},
                               {"fl_y", c.fy},
                               {"cx", c.cx + kPixelCentre},
                               {"cy", c.cy + kPixelCentre},
                               {"k1", 0.0},
                               {"k2", 0.0},
                               {"p1", 0.0},
                               {"p2", 0.0},
                               {"frames", frames_}};
    return WriteWhole(folder_ / "transforms.json", root.dump(1) + "\n");
  }

 private:
  fs::path folder_;
  WriteSettings settings_;
  ordered_json frames_ = ordered_json::array();
};

}  // namespace

Result<std::unique_ptr<CaptureWriter>> CreateNerfstudio(const fs::path& path,
                                                        const WriteSettings& settings) {
  for (const char* name : {"images", "depth"}) {
    if (Status status = MakeFolder(path / name); !status) return status.error();
  }
  return std::unique_ptr<CaptureWriter>(std::make_unique<WriterOfNerfstudio>(path, settings));
}

}  // namespace deepslam::convert

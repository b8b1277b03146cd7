// COLMAP's text model: images/ and sparse/0/ with cameras.txt (one pinhole, the first pixel's
// centre at (0.5, 0.5)), images.txt (camera from world) and points3D.txt, a cloud of points out of
// the depth images that training may begin with. Depth images themselves have no place there.
#include <array>
#include <cmath>
#include <cstdint>
#include <unordered_set>
#include <utility>

#include <fmt/format.h>

#include "deepslam/convert/capture_writer.h"
#include "deepslam/frames/raw_depth.h"

namespace deepslam::convert {
namespace {

namespace fs = std::filesystem;

// COLMAP: the top-left pixel's centre is (0.5, 0.5), here (0, 0).
constexpr double kPixelCentre = 0.5;
// One point a cell, so that what was seen often does not outweigh the rest.
constexpr double kSparseCellM = 0.03;
// Pixels looked at, of each side; a frame gives at most a few hundred points.
constexpr int kSampledColumns = 40;
constexpr int kSampledRows = 30;  // with the columns, squares of a 4:3 image
// Bounds memory and file; sparse models hold no more.
constexpr std::size_t kMaxSparsePoints = 500'000;

// Of a cell of the grid; cells farther than a kilometre are one.
std::uint64_t KeyOf(const Eigen::Vector3d& p_m) {
  std::uint64_t key = 0;
  for (int axis = 0; axis < 3; ++axis) {
    const double cell = std::floor(std::clamp(p_m[axis], -1000.0, 1000.0) / kSparseCellM);
    key = key << 21U | (static_cast<std::uint64_t>(static_cast<std::int64_t>(cell) + (1 << 20)) &
                        ((std::uint64_t{1} << 21U) - 1));
  }
  return key;
}

class WriterOfColmap final : public CaptureWriter {
 public:
  WriterOfColmap(fs::path folder, const WriteSettings& settings)
      : folder_(std::move(folder)),
        settings_(settings),
        metres_(settings.cameras.depth_units_per_m) {}

  [[nodiscard]] Status Add(const WriteFrame& frame) override {
    const std::string name = fmt::format("frame_{:06d}{}", frame.number, ColourEnd(frame.colour));
    const Result<std::string> bytes = ColourBytes(frame.colour);
    if (!bytes) return bytes.error();
    if (Status status = WriteWhole(folder_ / "images" / name, *bytes); !status) return status;
    const Pose3 camera_from_world = frame.world_from_colour->Inverse();
    const Eigen::Quaterniond& q = camera_from_world.rotation;
    const Eigen::Vector3d& t = camera_from_world.translation_m;
    images_ += fmt::format("{} {} {} {} {} {} {} {} 1 {}\n\n",
                           ++num_images_,
                           q.w(),
                           q.x(),
                           q.y(),
                           q.z(),
                           t.x(),
                           t.y(),
                           t.z(),
                           name);
    const Result<ColourImage> pixels =
        dataset::DecodeStored(frame.colour, settings_.cameras.colour);
    if (!pixels) return pixels.error();
    AddPoints(frame, *pixels);
    return Ok();
  }

  [[nodiscard]] Status Finish() override {
    const PinholeCamera& c = settings_.cameras.colour;
    const std::string cameras =
        fmt::format("# CAMERA_ID MODEL WIDTH HEIGHT fx fy cx cy\n1 PINHOLE {} {} {} {} {} {}\n",
                    c.width,
                    c.height,
                    c.fx,
                    c.fy,
                    c.cx + kPixelCentre,
                    c.cy + kPixelCentre);
    const fs::path model = folder_ / "sparse" / "0";
    using File = std::pair<const char*, const std::string*>;
    for (const auto& [name, text] : {File("cameras.txt", &cameras),
                                     File("images.txt", &images_),
                                     File("points3D.txt", &points_)}) {
      if (Status status = WriteWhole(model / name, *text); !status) return status;
    }
    return Ok();
  }

 private:
  void AddPoints(const WriteFrame& frame, const ColourImage& pixels) {
    const PinholeCamera& camera = settings_.cameras.colour;
    for (int row = 0; row < kSampledRows; ++row) {
      const int v = (2 * row + 1) * camera.height / (2 * kSampledRows);
      for (int column = 0; column < kSampledColumns; ++column) {
        const int u = (2 * column + 1) * camera.width / (2 * kSampledColumns);
        const auto depth_m = static_cast<double>(metres_[frame.depth(u, v)]);
        if (!(depth_m > 0) || filled_.size() >= kMaxSparsePoints) continue;
        const Eigen::Vector3d p_m = *frame.world_from_colour * camera.Unproject(u, v, depth_m);
        if (!filled_.insert(KeyOf(p_m)).second) continue;
        const Rgb8 colour = pixels(u, v);
        points_ += fmt::format("{} {:.4f} {:.4f} {:.4f} {} {} {} 0\n",
                               filled_.size(),
                               p_m.x(),
                               p_m.y(),
                               p_m.z(),
                               colour.r,
                               colour.g,
                               colour.b);
      }
    }
  }

  fs::path folder_;
  WriteSettings settings_;
  MetresOfRaw metres_;
  std::string images_ = "# IMAGE_ID qw qx qy qz tx ty tz CAMERA_ID NAME, then its 2D points\n";
  std::string points_ = "# POINT3D_ID x y z r g b error, then its track\n";
  std::unordered_set<std::uint64_t> filled_;  // cells that have a point
  int num_images_ = 0;
};

}  // namespace

Result<std::unique_ptr<CaptureWriter>> CreateColmap(const fs::path& path,
                                                    const WriteSettings& settings) {
  for (const char* name : {"images", "sparse/0"}) {
    if (Status status = MakeFolder(path / name); !status) return status.error();
  }
  return std::unique_ptr<CaptureWriter>(std::make_unique<WriterOfColmap>(path, settings));
}

}  // namespace deepslam::convert

#include "deepslam/fuse/tsdf.h"

#include <open3d/camera/PinholeCameraIntrinsic.h>
#include <open3d/geometry/Image.h>
#include <open3d/geometry/RGBDImage.h>
#include <open3d/geometry/TriangleMesh.h>
#include <open3d/pipelines/integration/ScalableTSDFVolume.h>

#include <cmath>
#include <cstddef>
#include <cstring>
#include <exception>
#include <set>
#include <string>
#include <vector>

#include <Eigen/Geometry>
#include <omp.h>

#include "deepslam/fuse/canonical_mesh.h"

namespace deepslam::fuse {
namespace {

constexpr int kBlockSide = 16;   // voxels
constexpr int kDepthStride = 4;  // px between the pixels that open blocks; Open3D's own default

// Open3D's inner OpenMP loops are short, and their threads spin for each other on a busy machine (5
// ms a frame become 800). They ask for a number of threads of their own, so only forbidding
// parallel regions altogether keeps them to one.
class SingleThread {
 public:
  SingleThread() : before_(omp_get_max_active_levels()) { omp_set_max_active_levels(0); }
  ~SingleThread() { omp_set_max_active_levels(before_); }
  SingleThread(const SingleThread&) = delete;
  SingleThread& operator=(const SingleThread&) = delete;

 private:
  int before_;
};

Status CheckInputs(const Frame& frame,
                   const PinholeCamera& camera,
                   const Pose3& pose,
                   const Mask* mask) {
  const std::string name = "frame " + std::to_string(frame.idx.value);
  const int width = frame.depth_m.width();
  const int height = frame.depth_m.height();
  if (frame.depth_m.empty() || width != camera.width || height != camera.height) {
    return InvalidInput(name + ": depth is " + std::to_string(width) + " x " +
                        std::to_string(height) + ", the camera " + std::to_string(camera.width) +
                        " x " + std::to_string(camera.height));
  }
  if (frame.colour.width() != width || frame.colour.height() != height) {
    return InvalidInput(name + ": colour and depth differ in size");
  }
  if (mask != nullptr && (mask->width() != width || mask->height() != height)) {
    return InvalidInput(name + ": the mask to leave out differs from the image in size");
  }
  if (!(camera.fx > 0) || !(camera.fy > 0) || !std::isfinite(camera.fx + camera.fy) ||
      !std::isfinite(camera.cx) || !std::isfinite(camera.cy)) {
    return InvalidInput(name + ": focal length or principal point is not usable");
  }
  // Open3D counts blocks in 32-bit integers: a pose far off would overflow them.
  constexpr double kMaxPlace = 1e5;
  if (!pose.Matrix().allFinite() || pose.translation_m.cwiseAbs().maxCoeff() > kMaxPlace) {
    return InvalidInput(name + ": pose is not finite or absurdly far");
  }
  return Ok();
}

// Images as Open3D wants them: depth as float metres, colour as bytes.
open3d::geometry::RGBDImage MakeImage(const Frame& frame,
                                      const Mask* leave_out,
                                      double max_depth_m) {
  open3d::geometry::RGBDImage image;
  const int width = frame.depth_m.width();
  const int height = frame.depth_m.height();
  image.depth_.Prepare(width, height, 1, 4);
  image.color_.Prepare(width, height, 3, 1);
  static_assert(sizeof(Rgb8) == 3);
  std::memcpy(image.color_.data_.data(), frame.colour.data(), 3 * frame.colour.size());
  for (int v = 0; v < height; ++v) {
    for (int u = 0; u < width; ++u) {
      float depth = frame.depth_m(u, v);
      const bool usable = depth > 0 && static_cast<double>(depth) <= max_depth_m &&
                          (leave_out == nullptr || (*leave_out)(u, v) == 0);
      *image.depth_.PointerAt<float>(u, v) = usable ? depth : 0.0F;
    }
  }
  return image;
}

TriangleMesh FromOpen3d(const open3d::geometry::TriangleMesh& mesh) {
  TriangleMesh result;
  result.vertices.reserve(mesh.vertices_.size());
  for (const Eigen::Vector3d& p : mesh.vertices_) result.vertices.push_back(p.cast<float>());
  for (const Eigen::Vector3d& c : mesh.vertex_colors_) {
    const auto byte = [](double x) {
      return static_cast<std::uint8_t>(std::lround(255.0 * std::min(1.0, std::max(0.0, x))));
    };
    result.colours.push_back({byte(c.x()), byte(c.y()), byte(c.z())});
  }
  for (const Eigen::Vector3i& t : mesh.triangles_) {
    result.faces.push_back({static_cast<std::uint32_t>(t.x()),
                            static_cast<std::uint32_t>(t.y()),
                            static_cast<std::uint32_t>(t.z())});
  }
  return result;
}

open3d::geometry::TriangleMesh ToOpen3d(const TriangleMesh& mesh) {
  open3d::geometry::TriangleMesh result;
  for (const Eigen::Vector3f& p : mesh.vertices) result.vertices_.push_back(p.cast<double>());
  for (const Rgb8 c : mesh.colours) {
    result.vertex_colors_.emplace_back(c.r / 255.0, c.g / 255.0, c.b / 255.0);
  }
  for (const auto& face : mesh.faces) {
    result.triangles_.push_back(Eigen::Vector3i(
        static_cast<int>(face[0]), static_cast<int>(face[1]), static_cast<int>(face[2])));
  }
  return result;
}

}  // namespace

struct TsdfFusion::Impl {
  explicit Impl(const FuseOptions& o)
      : options(o),
        volume(o.voxel_m,
               o.truncation_m,
               open3d::pipelines::integration::TSDFVolumeColorType::RGB8,
               kBlockSide,
               kDepthStride) {}

  // Blocks that a frame's truncation band can open beyond those that are there; stops counting at
  // the bound.
  [[nodiscard]] bool Outgrown(const open3d::geometry::Image& depth,
                              const PinholeCamera& camera,
                              const Pose3& world_from_camera) const;

  FuseOptions options;
  open3d::pipelines::integration::ScalableTSDFVolume volume;
};

bool TsdfFusion::Impl::Outgrown(const open3d::geometry::Image& depth,
                                const PinholeCamera& camera,
                                const Pose3& world_from_camera) const {
  const double side_m = options.voxel_m * kBlockSide;
  const auto block = [&](const Eigen::Vector3d& p) {
    return Eigen::Vector3i((p / side_m).array().floor().cast<int>());
  };
  const auto less = [](const Eigen::Vector3i& a, const Eigen::Vector3i& b) {
    return std::lexicographical_compare(a.data(), a.data() + 3, b.data(), b.data() + 3);
  };
  std::set<Eigen::Vector3i, decltype(less)> fresh(less);
  for (int v = 0; v < camera.height; v += kDepthStride) {
    for (int u = 0; u < camera.width; u += kDepthStride) {
      const float depth_m = *depth.PointerAt<float>(u, v);
      if (depth_m <= 0) continue;
      const Eigen::Vector3d p =
          world_from_camera * camera.Unproject(u, v, static_cast<double>(depth_m));
      const Eigen::Vector3i low = block(p.array() - options.truncation_m);
      const Eigen::Vector3i high = block(p.array() + options.truncation_m);
      for (int x = low.x(); x <= high.x(); ++x) {
        for (int y = low.y(); y <= high.y(); ++y) {
          for (int z = low.z(); z <= high.z(); ++z) {
            const Eigen::Vector3i index(x, y, z);
            if (volume.volume_units_.count(index) == 0) fresh.insert(index);
          }
        }
      }
    }
  }
  return volume.volume_units_.size() + fresh.size() >
         static_cast<std::size_t>(options.max_voxel_blocks);
}

TsdfFusion::TsdfFusion(const FuseOptions& options) : impl_(std::make_unique<Impl>(options)) {}
TsdfFusion::~TsdfFusion() = default;
TsdfFusion::TsdfFusion(TsdfFusion&&) noexcept = default;
TsdfFusion& TsdfFusion::operator=(TsdfFusion&&) noexcept = default;

Status TsdfFusion::Integrate(const Frame& frame,
                             const PinholeCamera& camera,
                             const Pose3& world_from_camera,
                             const Mask* leave_out) {
  const Status usable = CheckInputs(frame, camera, world_from_camera, leave_out);
  if (!usable) return usable;
  const SingleThread single_thread;
  try {
    const open3d::geometry::RGBDImage image =
        MakeImage(frame, leave_out, impl_->options.max_depth_m);
    if (impl_->Outgrown(image.depth_, camera, world_from_camera)) {
      return InvalidInput("frame " + std::to_string(frame.idx.value) +
                          ": the room outgrows fuse.max_voxel_blocks = " +
                          std::to_string(impl_->options.max_voxel_blocks) +
                          "; raise it, or fuse.voxel_m");
    }
    const open3d::camera::PinholeCameraIntrinsic intrinsic(
        camera.width, camera.height, camera.fx, camera.fy, camera.cx, camera.cy);
    impl_->volume.Integrate(image, intrinsic, world_from_camera.Inverse().Matrix());
  } catch (const std::exception& e) {
    return Failed("frame " + std::to_string(frame.idx.value) + ": fusion: " + e.what());
  }
  return Ok();
}

Result<TriangleMesh> TsdfFusion::ExtractMesh() const {
  const SingleThread single_thread;
  try {
    const auto extracted = impl_->volume.ExtractTriangleMesh();
    // Open3D walks its blocks in the order of a hash table.
    TriangleMesh mesh = CanonicalMesh(
        WithoutSmallComponents(FromOpen3d(*extracted), impl_->options.min_component_faces));
    if (mesh.faces.size() > static_cast<std::size_t>(impl_->options.max_faces)) {
      const auto simplified =
          ToOpen3d(mesh).SimplifyQuadricDecimation(impl_->options.max_faces, 1e300, 1.0);
      mesh = CanonicalMesh(FromOpen3d(*simplified));
    }
    return mesh;
  } catch (const std::exception& e) {
    return Failed(std::string("extracting the fused surface: ") + e.what());
  }
}

std::int64_t TsdfFusion::CountSurfacePoints() const {
  const SingleThread single_thread;
  return static_cast<std::int64_t>(impl_->volume.ExtractTriangleMesh()->vertices_.size());
}

std::int64_t ExpectedSurfacePoints(const TriangleMesh& surface, double voxel_m) {
  double crossings_m2 = 0;
  for (const auto& face : surface.faces) {
    const Eigen::Vector3d a = surface.vertices[face[0]].cast<double>();
    const Eigen::Vector3d b = surface.vertices[face[1]].cast<double>();
    const Eigen::Vector3d c = surface.vertices[face[2]].cast<double>();
    crossings_m2 += 0.5 * (b - a).cross(c - a).cwiseAbs().sum();
  }
  return std::llround(crossings_m2 / (voxel_m * voxel_m));
}

void Describe(OptionsVisitor& visitor, FuseOptions& options) {
  visitor.Field("voxel_m", options.voxel_m, {0.002, 0.2}, "m", "edge of a voxel of the fused room");
  visitor.Field("truncation_m",
                options.truncation_m,
                {0.004, 1},
                "m",
                "the distance field is kept this far from the surface; 2-3 voxels");
  visitor.Field("max_depth_m", options.max_depth_m, {0.1, 50}, "m", "depth beyond is not fused");
  visitor.Field("max_faces",
                options.max_faces,
                {100, 50'000'000},
                "1",
                "a larger room mesh is decimated to this number of faces");
  visitor.Field("min_component_faces",
                options.min_component_faces,
                {0, 1'000'000},
                "1",
                "smaller pieces of the room's surface are dropped as noise");
  visitor.Field("max_voxel_blocks",
                options.max_voxel_blocks,
                {1, 10'000'000},
                "1",
                "most blocks of 16^3 voxels (about 130 KB each) before fusion stops");
}

}  // namespace deepslam::fuse

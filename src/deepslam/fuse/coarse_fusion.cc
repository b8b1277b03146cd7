#include "deepslam/fuse/coarse_fusion.h"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <optional>
#include <span>
#include <string>
#include <utility>
#include <vector>

#include <Eigen/Geometry>

#include "deepslam/frames/noise_scale.h"
#include "deepslam/fuse/block_surface.h"
#include "deepslam/fuse/canonical_mesh.h"
#include "deepslam/fuse/frame_check.h"
#include "deepslam/fuse/incidence.h"
#include "deepslam/fuse/space_carving.h"
#include "deepslam/fuse/voxel_blocks.h"

namespace deepslam::fuse {
namespace {

DepthImage Near(const DepthImage& depth_m, double max_depth_m) {
  DepthImage near = depth_m;
  for (float& depth : near) {
    if (!(depth > 0) || static_cast<double>(depth) > max_depth_m) depth = 0;
  }
  return near;
}

// The frame's own noise where it is surely more than a Kinect's. Matching shares noise between
// nearer pixels than the lag.
DepthNoise NoiseOf(const DepthImage& depth_m) {
  constexpr int kLag = 5;  // px
  const std::span<const float> readings(depth_m.begin(), depth_m.end());
  const double scale = NoiseScaleOf(readings, depth_m.width(), kLag, DepthNoise{});
  return DepthNoise{}.Scaled(scale > kSureNoiseScale ? scale : 1.0);
}

// Area-weighted means of the faces around; up where they cancel.
std::vector<Eigen::Vector3f> VertexNormals(const TriangleMesh& mesh) {
  std::vector<Eigen::Vector3f> normals(mesh.vertices.size(), Eigen::Vector3f::Zero());
  for (const auto& face : mesh.faces) {
    const Eigen::Vector3f& a = mesh.vertices[face[0]];
    const Eigen::Vector3f doubled_area =
        (mesh.vertices[face[1]] - a).cross(mesh.vertices[face[2]] - a);
    for (const std::uint32_t v : face) normals[v] += doubled_area;
  }
  for (Eigen::Vector3f& normal : normals) {
    const float norm = normal.norm();
    normal = norm > 0 ? Eigen::Vector3f(normal / norm) : Eigen::Vector3f::UnitZ();
  }
  return normals;
}

// Of the voxel that holds the vertex: one of the two that it lies between.
std::int32_t FramesAt(const VoxelBlocks& blocks, const Eigen::Vector3f& vertex) {
  const Eigen::Array3i voxel =
      (vertex.cast<double>().array() / blocks.voxel_m()).floor().cast<int>();
  static_assert(VoxelBlock::kSide == 16);
  const auto number = blocks.Find({voxel.x() >> 4, voxel.y() >> 4, voxel.z() >> 4});
  if (!number) return 1;
  const auto inside = [&](int axis) { return static_cast<std::size_t>(voxel[axis] & 15); };
  const std::size_t at =
      (inside(0) * VoxelBlock::kSide + inside(1)) * VoxelBlock::kSide + inside(2);
  return blocks.at(*number).weight[at];
}

SpaceOptions SpaceOf(const CoarseOptions& options) {
  SpaceOptions space;
  space.voxel_m = options.voxel_m;
  space.range_m = CoarseOptions::kSpaceRange_m;
  // A wall nearer than what is fused would have been measured.
  space.blind_range_m = CoarseOptions::kMaxDepth_m;
  return space;
}

}  // namespace

FrameChoice CoarseFrameChoice() { return {0.15, 9, 45}; }

struct CoarseFusion::Impl {
  explicit Impl(const CoarseOptions& o)
      : options(o), blocks(o.voxel_m, CoarseOptions::kTruncation_m), space(SpaceOf(o)) {}

  CoarseOptions options;
  VoxelBlocks blocks;
  SpaceCarving space;
  std::vector<Eigen::Vector3f> viewpoints;
  ColourImage grey;  // in place of colour that is missing
  bool coloured = true;
  bool full = false;
};

CoarseFusion::CoarseFusion(const CoarseOptions& options) : impl_(std::make_unique<Impl>(options)) {}
CoarseFusion::~CoarseFusion() = default;
CoarseFusion::CoarseFusion(CoarseFusion&&) noexcept = default;
CoarseFusion& CoarseFusion::operator=(CoarseFusion&&) noexcept = default;

Status CoarseFusion::Integrate(const Frame& frame,
                               const PinholeCamera& camera,
                               const Pose3& level_from_camera) {
  if (Status usable = CheckFrame(frame, camera, level_from_camera); !usable) return usable;
  Impl& impl = *impl_;
  const bool coloured = !frame.colour.empty();
  if (!coloured && impl.grey.empty()) impl.grey = ColourImage(camera.width, camera.height, {});
  impl.coloured = impl.coloured && coloured;
  const DepthNoise noise = NoiseOf(frame.depth_m);
  const double reach_m =
      std::min(CoarseOptions::kMaxDepth_m, noise.ReachM(CoarseOptions::kTruncation_m));
  const DepthImage near_m = Near(frame.depth_m, reach_m);
  const Image<float> cosines = IncidenceCosines(near_m, camera);
  const bool added = impl.blocks.Integrate(near_m,
                                           coloured ? frame.colour : impl.grey,
                                           camera,
                                           level_from_camera,
                                           static_cast<std::size_t>(impl.options.max_voxel_blocks),
                                           &cosines);
  impl.full = impl.full || !added;
  impl.space.Carve(frame.depth_m, camera, level_from_camera, noise);
  impl.viewpoints.push_back(level_from_camera.translation_m.cast<float>());
  return Ok();
}

bool CoarseFusion::surface_full() const { return impl_->full; }

CoarseSurface CoarseFusion::Take() && {
  CoarseSurface surface;
  surface.voxel_m = impl_->options.voxel_m;
  TriangleMesh mesh = SurfaceOf(impl_->blocks);
  if (!impl_->coloured) mesh.colours.clear();
  surface.mesh = CanonicalMesh(WithoutSmallComponents(mesh, CoarseOptions::kMinComponentFaces));
  surface.normals = VertexNormals(surface.mesh);
  for (const Eigen::Vector3f& vertex : surface.mesh.vertices)
    surface.num_frames.push_back(FramesAt(impl_->blocks, vertex));
  surface.space = std::move(impl_->space).Take();
  surface.viewpoints = std::move(impl_->viewpoints);
  impl_.reset();
  return surface;
}

void Describe(OptionsVisitor& visitor, CoarseOptions& options) {
  visitor.Field("voxel_m",
                options.voxel_m,
                {0.01, 0.2},
                "m",
                "edge of a voxel of the coarse surface that walls and things are read from");
  visitor.Field("max_voxel_blocks",
                options.max_voxel_blocks,
                {1, 1'000'000},
                "1",
                "most blocks of 16^3 voxels (48 KB each) of the coarse surface");
}

}  // namespace deepslam::fuse

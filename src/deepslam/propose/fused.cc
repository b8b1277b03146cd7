#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <cstdio>
#include <numbers>
#include <utility>
#include <vector>

#include "deepslam/core/parallel.h"
#include "deepslam/core/wide_vectors.h"
#include "deepslam/geometry/point_columns.h"
#include "deepslam/propose/candidate_size.h"
#include "deepslam/propose/depth_evidence.h"
#include "deepslam/propose/front_of_box.h"
#include "deepslam/propose/level_box.h"
#include "deepslam/propose/level_cloud.h"
#include "deepslam/propose/proposer.h"
#include "deepslam/shape/depth_view.h"
#include "deepslam/shape/front.h"
#include "deepslam/shape/small_components.h"
#include "deepslam/shape/stand.h"
#include "deepslam/shape/stretch.h"

namespace deepslam::propose {
namespace {

// Views that are fused, best supported and spread first: as many as an object has by default
// (observe/object_views.h).
constexpr int kMaxViews = 24;
// The candidate's size range, measured size +- this share, as of designs (proposer.h).
constexpr double kSizeMargin = 0.25;

// The grid laid over the object: voxel (i, j, k) -> level frame.
class Raster {
 public:
  Raster(const LevelBox& box, double voxel_m)
      : box_(box), voxel_m_(voxel_m), c_(std::cos(box.yaw_rad)), s_(std::sin(box.yaw_rad)) {}

  [[nodiscard]] double voxel_m() const { return voxel_m_; }

  [[nodiscard]] Eigen::Vector3f Center(int i, int j, int k) const {
    const Eigen::Vector3d local = VoxelGrid::Center(i, j, k) * (voxel_m_ / kVoxelSize);
    return Eigen::Vector3d(box_.center_m.x() + c_ * local.x() - s_ * local.y(),
                           box_.center_m.y() + s_ * local.x() + c_ * local.y(),
                           0.5 * box_.size_m.z() + local.z())
        .cast<float>();
  }
  [[nodiscard]] Similarity3 LevelFromRaster() const {
    return {voxel_m_ / kVoxelSize,
            Eigen::Quaterniond(Eigen::AngleAxisd(box_.yaw_rad, Eigen::Vector3d::UnitZ())),
            {box_.center_m.x(), box_.center_m.y(), 0.5 * box_.size_m.z()}};
  }
  // Whether the voxel lies in the measured box.
  [[nodiscard]] bool Inside(int i, int j, int k) const {
    const Eigen::Vector3d local = VoxelGrid::Center(i, j, k) * (voxel_m_ / kVoxelSize);
    return (local.cwiseAbs().array() <= 0.5 * box_.size_m.array() + 0.5 * voxel_m_).all();
  }

 private:
  LevelBox box_;
  double voxel_m_;
  double c_, s_;  // of the yaw
};

// What the views say of places side by side, each a column of a raster's voxels.
struct Tally {
  std::array<std::int32_t, kPointBatch> free = {};
  std::array<std::int32_t, kPointBatch> surface = {};
  std::array<std::int32_t, kPointBatch> behind = {};  // 0 or 1
  std::array<std::int32_t, kPointBatch> shell = {};   // likewise

  // Whether what is left of the views may still make something solid.
  [[nodiscard]] bool IsOpen(std::size_t size, std::int32_t left) const {
    std::int32_t open = 0;
    for (std::size_t n = 0; n < size; ++n) open |= free[n] <= surface[n] + left ? 1 : 0;
    return open != 0;
  }
  [[nodiscard]] bool IsSolid(std::size_t n, bool fill_unseen) const {
    if (surface[n] > 0) return surface[n] >= free[n];
    return free[n] == 0 && (shell[n] != 0 || (behind[n] != 0 && fill_unseen));
  }
};

// Voxels end at the measured surface, as those of completed shapes do (refine/evidence.h).
void Add(const shape::DepthView::ReadingColumns& readings,
         std::size_t size,
         float voxel_m,
         Tally& tally) {
  // Behind a measured surface this much is taken for solid even in open furniture: boards and legs.
  constexpr float kShell_m = 0.03F;
#pragma GCC ivdep
  for (std::size_t n = 0; n < size; ++n) {
    const float depth_m = readings.depth_m[n];
    const float cosine = readings.cosine[n];
    const float beyond_m = readings.z_m[n] - depth_m;  // along the ray
    const bool is_known = depth_m > 0;
    const bool is_object = readings.is_object[n] != 0;
    const bool is_free = is_known & (-beyond_m * cosine > shape::kGrazedVoxels * voxel_m);
    const bool is_behind =
        is_known & (beyond_m > DepthTolerance_m(depth_m) + 0.5F * voxel_m / cosine);
    const bool is_in_shell = beyond_m * cosine < kShell_m + 0.5F * voxel_m;
    tally.free[n] += is_free ? 1 : 0;
    tally.surface[n] += (is_known & is_object & !is_free & !is_behind) ? 1 : 0;
    tally.behind[n] |= (is_behind & is_object) ? 1 : 0;
    tally.shell[n] |= (is_behind & is_object & is_in_shell) ? 1 : 0;
  }
}

Tally TallyOf(std::span<const shape::DepthView> views,
              const VectorColumns& points_level,
              std::size_t size,
              float voxel_m) {
  Tally tally;
  shape::DepthView::ReadingColumns readings;
  auto left = static_cast<std::int32_t>(views.size());
  for (const shape::DepthView& view : views) {
    if (!tally.IsOpen(size, left)) break;
    --left;
    view.At(points_level, size, readings);
    Add(readings, size, voxel_m, tally);
  }
  return tally;
}

// The voxels (i, 0, 0) to (i, 63, 63).
DEEPSLAM_WIDE_VECTORS void CarveSlice(const Raster& raster,
                                      std::span<const shape::DepthView> views,
                                      bool fill_unseen,
                                      int i,
                                      VoxelGrid& grid) {
  static_assert(kGridSize <= kPointBatch && kGridSize % kPointLanes == 0);
  const auto voxel_m = static_cast<float>(raster.voxel_m());
  for (int j = 0; j < kGridSize; ++j) {
    int first = 0;
    while (first < kGridSize && !raster.Inside(i, j, first)) ++first;
    int last = first;
    while (last < kGridSize && raster.Inside(i, j, last)) ++last;
    if (first == last) continue;
    VectorColumns points;
    const auto size = static_cast<std::size_t>(last - first);
    const std::size_t whole = WholeLanes(size);
    for (std::size_t n = 0; n < whole; ++n) {
      const Eigen::Vector3f p =
          raster.Center(i, j, std::min(first + static_cast<int>(n), last - 1));
      points.Set(n, p.x(), p.y(), p.z());
    }
    const Tally tally = TallyOf(views, points, whole, voxel_m);
    std::uint8_t* const column = grid.occupied.data() + VoxelGrid::Index(i, j, first);
    for (std::size_t n = 0; n < size; ++n) column[n] = tally.IsSolid(n, fill_unseen) ? 1 : 0;
  }
}

VoxelGrid Carve(const Raster& raster, std::span<const shape::DepthView> views, bool fill_unseen) {
  VoxelGrid grid;
  ParallelFor(kGridSize, [&](std::size_t slice) {
    CarveSlice(raster, views, fill_unseen, static_cast<int>(slice), grid);
  });
  return grid;
}

// What shape::TurnGrid does, undone.
Similarity3 CentredFromTurned(int quarter_turns) {
  const Eigen::AngleAxisd back(-0.5 * std::numbers::pi * quarter_turns, Eigen::Vector3d::UnitZ());
  return {1.0, Eigen::Quaterniond(back), Eigen::Vector3d::Zero()};
}

class FusedProposer final : public Proposer {
 public:
  explicit FusedProposer(ClassTable classes) : classes_(std::move(classes)) {}

  [[nodiscard]] std::string name() const override { return "fused"; }
  [[nodiscard]] Result<Proposals> Propose(const ObjectObservations& object) const override;

 private:
  ClassTable classes_;
};

Result<Proposals> FusedProposer::Propose(const ObjectObservations& object) const {
  Proposals proposals;
  const std::string subject =
      "object " + std::to_string(object.id.value) + " (" + object.class_name + "): ";
  const LevelCloud cloud = CloudOf(object);
  if (cloud.points.empty()) {
    proposals.notes.push_back(subject + "too few depth points to fuse");
    return proposals;
  }
  const LevelBox box = MeasureBox(object, cloud);
  const Raster raster(box, box.size_m.maxCoeff() / (kModelExtent * kGridSize));
  const Eigen::Vector3d center_level(box.center_m.x(), box.center_m.y(), 0.5 * box.size_m.z());
  const std::vector<shape::DepthView> views = LevelViews(
      object.views,
      ChooseViews(object.views, cloud.level_from_world.Inverse() * center_level, kMaxViews),
      cloud.level_from_world);
  // Stray depth. Parts of an object may well hang unconnected where thin links between them were
  // not measured.
  constexpr double kFusedSmallShare = 0.05;
  VoxelGrid grid = shape::WithoutSmallComponents(
      Carve(raster, views, classes_.TraitsOf(object.class_name).solid_inside), 1, kFusedSmallShare);
  if (cloud.has_ground) {
    const double ground = 0.5 * kGridSize - 0.5 * box.size_m.z() / raster.voxel_m();
    shape::StandOnGround(static_cast<int>(std::lround(ground)),
                         static_cast<int>(shape::kMaxFeetGapM / raster.voxel_m()),
                         grid);
  }
  const auto count = std::count(grid.occupied.begin(), grid.occupied.end(), std::uint8_t{1});
  constexpr int kMinVoxels = 50;  // fewer are stray depth, of which no shape can be told
  if (count < kMinVoxels) {
    proposals.notes.push_back(subject + "its fused depth holds no solid");
    return proposals;
  }
  const Similarity3 raster_from_centred = shape::GridFromCentred(*OccupiedBox(grid));
  grid = shape::StretchGrid(grid, Eigen::Vector3d::Ones());
  const FrontEvidence evidence = {
      object.views, object.layout, shape::QuarterTurnsFromHighBack(grid)};
  const int turns = QuarterTurnsToFront(box, cloud.level_from_world, evidence);
  grid = shape::TurnGrid(grid, turns);
  std::array<char, 32> key{};
  std::snprintf(key.data(), key.size(), "fused_%03d", object.id.value);
  ShapeCandidate candidate;
  candidate.object = object.id;
  candidate.source = CandidateSource::kFused;
  candidate.model = key.data();
  // Its own measurement always agrees with itself: no opinion.
  candidate.proposal_score = 0.5;
  candidate.world_from_object = cloud.level_from_world.Inverse() * raster.LevelFromRaster() *
                                raster_from_centred * CentredFromTurned(turns);
  SetSize(candidate.world_from_object->scale * kModelExtent,
          kSizeMargin,
          classes_.Find(object.class_name),
          candidate);
  proposals.models.emplace(candidate.model, std::move(grid));
  proposals.candidates.push_back(std::move(candidate));
  return proposals;
}

}  // namespace

std::unique_ptr<Proposer> MakeFusedProposer(const ClassTable& classes) {
  return std::make_unique<FusedProposer>(classes);
}

}  // namespace deepslam::propose

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <cstdio>
#include <utility>
#include <vector>

#include "deepslam/core/parallel.h"
#include "deepslam/propose/candidate_size.h"
#include "deepslam/propose/depth_evidence.h"
#include "deepslam/propose/level_cloud.h"
#include "deepslam/propose/proposer.h"
#include "deepslam/shape/crumbs.h"
#include "deepslam/shape/depth_view.h"
#include "deepslam/shape/front.h"
#include "deepslam/shape/stand.h"
#include "deepslam/shape/stretch.h"

namespace deepslam::propose {
namespace {

// The grid laid over the object: voxel (i, j, k) -> level frame.
struct Raster {
  LevelBox box;
  double voxel_m = 0;

  [[nodiscard]] Eigen::Vector3f Center(int i, int j, int k) const {
    const Eigen::Vector3d local = VoxelGrid::Center(i, j, k) * (voxel_m / kVoxelSize);
    const double c = std::cos(box.yaw_rad);
    const double s = std::sin(box.yaw_rad);
    return Eigen::Vector3d(box.center_m.x() + c * local.x() - s * local.y(),
                           box.center_m.y() + s * local.x() + c * local.y(),
                           0.5 * box.size_m.z() + local.z())
        .cast<float>();
  }
  // Whether the voxel lies in the measured box.
  [[nodiscard]] bool Inside(int i, int j, int k) const {
    const Eigen::Vector3d local = VoxelGrid::Center(i, j, k) * (voxel_m / kVoxelSize);
    return (local.cwiseAbs().array() <= 0.5 * box.size_m.array() + 0.5 * voxel_m).all();
  }
};

// Whether the views together make a place solid.
bool IsSolid(const Eigen::Vector3f& p_level,
             std::span<const shape::DepthView> views,
             float slack_m,
             bool fill_unseen) {
  // Behind a measured surface this much is taken for solid even in open furniture: boards and legs.
  constexpr float kShell_m = 0.03F;
  int free = 0;
  int surface = 0;
  bool behind = false;
  bool shell = false;
  int left = static_cast<int>(views.size());
  for (const shape::DepthView& view : views) {
    if (free > surface + left) return false;  // whatever the others say
    --left;
    const EvidenceReading reading = EvidenceAt(view, p_level, slack_m);
    free += reading.evidence == Evidence::kFree ? 1 : 0;
    surface += reading.evidence == Evidence::kSurface ? 1 : 0;
    if (reading.evidence != Evidence::kBehind || reading.behind_m <= 0) continue;
    behind = true;
    shell = shell || reading.behind_m < kShell_m + slack_m;
  }
  if (surface > 0) return surface >= free;
  return free == 0 && (shell || (behind && fill_unseen));
}

VoxelGrid Carve(const Raster& raster, std::span<const shape::DepthView> views, bool fill_unseen) {
  VoxelGrid grid;
  const auto slack_m = static_cast<float>(0.5 * raster.voxel_m);
  ParallelFor(kGridSize, [&](std::size_t slice) {
    const int i = static_cast<int>(slice);
    for (int j = 0; j < kGridSize; ++j) {
      for (int k = 0; k < kGridSize; ++k) {
        if (!raster.Inside(i, j, k)) continue;
        const bool solid = IsSolid(raster.Center(i, j, k), views, slack_m, fill_unseen);
        grid.occupied[VoxelGrid::Index(i, j, k)] = solid ? 1 : 0;
      }
    }
  });
  return grid;
}

bool Listed(std::string_view list, std::string_view word) {
  while (!list.empty()) {
    const std::size_t end = std::min(list.find(' '), list.size());
    if (list.substr(0, end) == word) return true;
    list.remove_prefix(std::min(end + 1, list.size()));
  }
  return false;
}

class FusedProposer final : public Proposer {
 public:
  FusedProposer(ClassTable classes, FusedOptions options)
      : classes_(std::move(classes)), options_(std::move(options)) {}

  [[nodiscard]] std::string name() const override { return "fused"; }
  [[nodiscard]] Result<Proposals> Propose(const ObjectObservations& object) const override;

 private:
  ClassTable classes_;
  FusedOptions options_;
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
  Raster raster;
  raster.box = MeasureBox(cloud.points);
  raster.voxel_m = raster.box.size_m.maxCoeff() / (kModelExtent * kGridSize);
  const Eigen::Vector3d center_level(
      raster.box.center_m.x(), raster.box.center_m.y(), 0.5 * raster.box.size_m.z());
  std::vector<shape::DepthView> views;
  for (const std::size_t n : ChooseViews(
           object.views, cloud.level_from_world.Inverse() * center_level, options_.max_views)) {
    views.push_back(LevelView(object.views[n], cloud.level_from_world));
  }
  // Stray depth. Parts of an object may well hang unconnected where thin links between them were
  // not measured.
  constexpr double kCrumb = 0.05;
  VoxelGrid grid = shape::WithoutCrumbs(
      Carve(raster, views, Listed(options_.solid_classes, object.class_name)), 1, kCrumb);
  if (cloud.has_ground) {
    const double ground = 0.5 * kGridSize - 0.5 * raster.box.size_m.z() / raster.voxel_m;
    shape::StandOnGround(static_cast<int>(std::lround(ground)),
                         static_cast<int>(shape::kMaxFeetGapM / raster.voxel_m),
                         grid);
  }
  const auto count = std::count(grid.occupied.begin(), grid.occupied.end(), std::uint8_t{1});
  constexpr int kMinVoxels = 50;
  if (count < kMinVoxels) {
    proposals.notes.push_back(subject + "its fused depth holds no solid");
    return proposals;
  }
  const double size_m = OccupiedBox(grid)->sides().maxCoeff() * raster.voxel_m;
  grid = shape::StretchGrid(grid, Eigen::Vector3d::Ones());
  grid = shape::TurnGrid(grid, shape::QuarterTurnsToFront(grid));
  std::array<char, 32> key{};
  std::snprintf(key.data(), key.size(), "fused_%03d", object.id.value);
  ShapeCandidate candidate;
  candidate.object = object.id;
  candidate.source = CandidateSource::kFused;
  candidate.model = key.data();
  // Its own measurement always agrees with itself: no opinion.
  candidate.proposal_score = 0.5;
  SetSize(size_m, options_.size_margin, classes_.Find(object.class_name), candidate);
  proposals.models.emplace(candidate.model, std::move(grid));
  proposals.candidates.push_back(std::move(candidate));
  return proposals;
}

}  // namespace

void Describe(OptionsVisitor& visitor, FusedOptions& options) {
  visitor.Field(
      "max_views", options.max_views, {1, 1000}, "1", "views of an object that are fused");
  visitor.Field("size_margin",
                options.size_margin,
                {0.01, 0.9},
                "1",
                "share by which the candidate's real size may differ from the measured one");
  visitor.Field("solid_classes",
                options.solid_classes,
                "classes whose unseen inside is solid, separated by blanks");
}

std::unique_ptr<Proposer> MakeFusedProposer(const ClassTable& classes,
                                            const FusedOptions& options) {
  return std::make_unique<FusedProposer>(classes, options);
}

}  // namespace deepslam::propose

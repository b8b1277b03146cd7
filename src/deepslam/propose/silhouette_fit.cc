#include "deepslam/propose/silhouette_fit.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <numbers>

#include <Eigen/Cholesky>

namespace deepslam::propose {
namespace {

constexpr float kNear_m = 0.1F;   // nearer points are not projected: no furniture stands there
constexpr int kRasterCells = 32;  // along the silhouette's longer side; a coarse model has as many

struct MaskRaster {
  int width = 0;
  int height = 0;
  std::vector<std::uint8_t> cells;
  [[nodiscard]] bool At(int u, int v) const {
    return u >= 0 && v >= 0 && u < width && v < height &&
           cells[static_cast<std::size_t>(v * width + u)] != 0;
  }
};

// Cells of which `share` lies in the mask.
MaskRaster Reduce(const Mask& mask, int cell_px) {
  constexpr double kFilledShare = 0.35;  // less than half, so that legs thinner than a cell stay
  MaskRaster raster;
  raster.width = (mask.width() + cell_px - 1) / cell_px;
  raster.height = (mask.height() + cell_px - 1) / cell_px;
  std::vector<int> count(static_cast<std::size_t>(raster.width * raster.height), 0);
  for (int v = 0; v < mask.height(); ++v) {
    for (int u = 0; u < mask.width(); ++u) {
      if (mask(u, v) != 0)
        ++count[static_cast<std::size_t>((v / cell_px) * raster.width + u / cell_px)];
    }
  }
  for (const int n : count) raster.cells.push_back(n >= kFilledShare * cell_px * cell_px ? 1 : 0);
  return raster;
}

// Cells of which any (grow) or all (shrink) of the 3 x 3 neighbours are set; outside counts for
// neither.
MaskRaster Filtered(const MaskRaster& raster, bool grow) {
  MaskRaster result = raster;
  for (int v = 0; v < raster.height; ++v) {
    for (int u = 0; u < raster.width; ++u) {
      bool value = !grow;
      for (int n = 0; n < 9; ++n) {
        const int x = u + n % 3 - 1;
        const int y = v + n / 3 - 1;
        if (x < 0 || y < 0 || x >= raster.width || y >= raster.height) continue;
        value = grow ? value || raster.At(x, y) : value && raster.At(x, y);
      }
      result.cells[static_cast<std::size_t>(v * raster.width + u)] = value ? 1 : 0;
    }
  }
  return result;
}

int LongerSide(const Mask& mask) {
  int u_min = mask.width();
  int u_max = -1;
  int v_min = mask.height();
  int v_max = -1;
  for (int v = 0; v < mask.height(); ++v) {
    for (int u = 0; u < mask.width(); ++u) {
      if (mask(u, v) == 0) continue;
      u_min = std::min(u_min, u);
      u_max = std::max(u_max, u);
      v_min = std::min(v_min, v);
      v_max = std::max(v_max, v);
    }
  }
  return std::max(u_max - u_min, v_max - v_min) + 1;
}

Eigen::Vector3f ToLevel(const Placement& placement, const Eigen::Vector3f& p_box) {
  const auto c = static_cast<float>(std::cos(placement.yaw_rad));
  const auto s = static_cast<float>(std::sin(placement.yaw_rad));
  return {static_cast<float>(placement.center_m.x()) + c * p_box.x() - s * p_box.y(),
          static_cast<float>(placement.center_m.y()) + s * p_box.x() + c * p_box.y(),
          static_cast<float>(placement.bottom_m + 0.5 * placement.size_m.z()) + p_box.z()};
}

std::vector<Eigen::Vector3f> PlacedSolid(const CoarseShape& shape, const Placement& placement) {
  const Eigen::Vector3f metres = placement.size_m.cast<float>().cwiseQuotient(shape.extent());
  std::vector<Eigen::Vector3f> points;
  points.reserve(shape.solid().size());
  for (const Eigen::Vector3f& p_object : shape.solid())
    points.push_back(ToLevel(placement, p_object.cwiseProduct(metres)));
  return points;
}

// The point nearest to the views' rays, held weakly to a plausible distance and, where the ground
// is known, firmly to the height `z_m`.
Eigen::Vector3d MeetRays(std::span<const SilhouetteView> views,
                         const std::vector<Eigen::Vector2d>& offsets,
                         bool has_ground,
                         double z_m) {
  constexpr double kUsualDistance_m = 2.5;  // at which furniture is usually filmed
  // Against 1 of a ray: decides only where rays are parallel, as a single one is.
  constexpr double kWeak = 1e-3;
  Eigen::Matrix3d h = Eigen::Matrix3d::Zero();
  Eigen::Vector3d g = Eigen::Vector3d::Zero();
  for (std::size_t n = 0; n < views.size(); ++n) {
    const Eigen::Vector3d ray = views[n].RayToMiddle(offsets[n]);
    const Eigen::Matrix3d across = Eigen::Matrix3d::Identity() - ray * ray.transpose();
    const Eigen::Vector3d eye = views[n].camera_level();
    h += across + kWeak * Eigen::Matrix3d::Identity();
    g += across * eye + kWeak * (eye + kUsualDistance_m * ray);
  }
  if (has_ground) {
    const auto weight = static_cast<double>(views.size());
    h(2, 2) += weight;
    g.z() += weight * z_m;
  }
  return h.ldlt().solve(g);
}

// Where the middle of the drawn model's box lies in each view, less where the model's own middle
// does; cells.
std::vector<Eigen::Vector2d> MiddleOffsets(const CoarseShape& shape,
                                           const Placement& placement,
                                           std::span<const SilhouetteView> views) {
  const std::vector<Eigen::Vector3f> points = PlacedSolid(shape, placement);
  const Eigen::Vector3f center = ToLevel(placement, Eigen::Vector3f::Zero());
  std::vector<Eigen::Vector2d> offsets;
  for (const SilhouetteView& view : views) {
    Eigen::Array2f low = Eigen::Array2f::Constant(1e9F);
    Eigen::Array2f high = -low;
    for (const Eigen::Vector3f& p_level : points) {
      const Eigen::Vector3f at = view.Project(p_level);
      if (!(at.z() > kNear_m)) continue;
      low = low.min(at.head<2>().array());
      high = high.max(at.head<2>().array());
    }
    const Eigen::Vector3f middle = view.Project(center);
    if (!(middle.z() > kNear_m) || low.x() > high.x()) {
      offsets.emplace_back(Eigen::Vector2d::Zero());
    } else {
      offsets.emplace_back(
          (0.5F * (low + high).matrix() - middle.head<2>()).cast<double>());
    }
  }
  return offsets;
}

Placement PlaceByRays(const CoarseShape& shape,
                      const Eigen::Vector3d& size_m,
                      double yaw_rad,
                      std::span<const SilhouetteView> views,
                      bool has_ground) {
  constexpr int kRounds = 2;  // of moving rays from the outlines' middles to the object's
  Placement placement;
  placement.size_m = size_m;
  placement.yaw_rad = yaw_rad;
  std::vector<Eigen::Vector2d> offsets(views.size(), Eigen::Vector2d::Zero());
  for (int round = 0; round <= kRounds; ++round) {
    const Eigen::Vector3d p = MeetRays(views, offsets, has_ground, 0.5 * size_m.z());
    placement.center_m = p.head<2>();
    placement.bottom_m = has_ground ? 0.0 : p.z() - 0.5 * size_m.z();
    if (round < kRounds) offsets = MiddleOffsets(shape, placement, views);
  }
  return placement;
}

// Moves of the search: x, y, yaw, all sides, each side, and the height where no ground holds it.
constexpr int kNumMoves = 8;
constexpr int kHeightMove = 7;  // the last of kNumMoves

Placement Moved(const Placement& from, int move, double step) {
  constexpr double kMove_m = 0.08;    // the first; halved down to kSmallestStep
  constexpr double kMove_rad = 0.26;  // 15 degrees; starts are up to 11 off (kNumYaws)
  constexpr double kMoveLog = 0.1;    // 10 % of a size
  Placement to = from;
  if (move < 2) {
    to.center_m[move] += step * kMove_m;
  } else if (move == 2) {
    to.yaw_rad += step * kMove_rad;
  } else if (move == 3) {
    to.size_m *= std::exp(step * kMoveLog);
  } else if (move < kHeightMove) {
    to.size_m[move - 4] *= std::exp(step * kMoveLog);
  } else {
    to.bottom_m += step * kMove_m;
  }
  return to;
}

bool SizeAllowed(const Placement& placement,
                 const Eigen::Vector3d& real_size_m,
                 const SilhouetteFitOptions& options) {
  const Eigen::Array3d stretch = placement.size_m.array() / real_size_m.array();
  return stretch.minCoeff() >= options.stretch_min && stretch.maxCoeff() <= options.stretch_max;
}

SilhouetteFit Climb(const CoarseShape& shape,
                    const Eigen::Vector3d& real_size_m,
                    std::span<const SilhouetteView> views,
                    const SilhouetteFitOptions& options,
                    SilhouetteFit best) {
  constexpr double kSmallestStep = 0.25;  // of the first: 2 cm, 4 degrees, 2.5 % of a size
  constexpr int kMaxSweeps = 4;  // per step length
  for (double step = 1.0; step >= kSmallestStep; step *= 0.5) {
    for (int sweep = 0; sweep < kMaxSweeps; ++sweep) {
      bool better = false;
      for (int n = 0; n < 2 * kNumMoves; ++n) {
        if (n / 2 == kHeightMove && options.has_ground) continue;
        const Placement moved = Moved(best.placement, n / 2, n % 2 == 0 ? step : -step);
        if (!SizeAllowed(moved, real_size_m, options)) continue;
        const double score = ScoreSilhouettes(shape, moved, real_size_m, views);
        if (score <= best.score) continue;
        best = {moved, score};
        better = true;
      }
      if (!better) break;
    }
  }
  return best;
}

}  // namespace

SilhouetteView::SilhouetteView(const ObjectView& view, const Pose3& level_from_world) {
  const Pose3 camera_from_level = (level_from_world * view.world_from_camera).Inverse();
  rotation_ = camera_from_level.rotation.toRotationMatrix().cast<float>();
  translation_ = camera_from_level.translation_m.cast<float>();
  const int cell_px = std::max(1, (LongerSide(view.mask_crop) + kRasterCells - 1) / kRasterCells);
  const PinholeCamera camera = view.camera.Reduced(cell_px);
  fx_ = static_cast<float>(camera.fx);
  fy_ = static_cast<float>(camera.fy);
  cx_ = static_cast<float>(camera.cx);
  cy_ = static_cast<float>(camera.cy);
  const MaskRaster raster = Filtered(Filtered(Reduce(view.mask_crop, cell_px), true), false);
  width_ = raster.width;
  height_ = raster.height;
  inside_ = raster.cells;
  Eigen::Array2d low = Eigen::Array2d::Constant(1e9);
  Eigen::Array2d high = -low;
  for (int v = 0; v < height_; ++v) {
    for (int u = 0; u < width_; ++u) {
      if (!raster.At(u, v)) continue;
      ++num_inside_;
      low = low.min(Eigen::Array2d(u, v));
      high = high.max(Eigen::Array2d(u, v));
    }
  }
  if (num_inside_ > 0) middle_ = 0.5 * (low + high).matrix();
}

Eigen::Vector3d SilhouetteView::camera_level() const {
  return -(rotation_.transpose() * translation_).cast<double>();
}

Eigen::Vector3d SilhouetteView::RayToMiddle(const Eigen::Vector2d& offset) const {
  const Eigen::Vector2f at = (middle_ - offset).cast<float>();
  const Eigen::Vector3f ray((at.x() - cx_) / fx_, (at.y() - cy_) / fy_, 1.0F);
  return (rotation_.transpose() * ray).cast<double>().normalized();
}

Eigen::Vector3f SilhouetteView::Project(const Eigen::Vector3f& p_level) const {
  const Eigen::Vector3f p = rotation_ * p_level + translation_;
  if (!(p.z() > kNear_m)) return {0, 0, 0};
  return {fx_ * p.x() / p.z() + cx_, fy_ * p.y() / p.z() + cy_, p.z()};
}

double SilhouetteView::Overlap(std::span<const Eigen::Vector3f> points_level,
                               float side_m,
                               std::vector<std::uint8_t>& drawn) const {
  drawn.assign(inside_.size(), 0);
  for (const Eigen::Vector3f& p_level : points_level) {
    const Eigen::Vector3f at = Project(p_level);
    if (!(at.z() > kNear_m)) continue;
    // Cells whose middle the point's square covers; at least the nearest one.
    const float reach = 0.5F * side_m * fx_ / at.z();
    if (!(at.x() > -reach - 1 && at.y() > -reach - 1 &&
          at.x() < static_cast<float>(width_) + reach &&
          at.y() < static_cast<float>(height_) + reach))
      continue;
    const auto nearest_u = static_cast<int>(std::lround(at.x()));
    const auto nearest_v = static_cast<int>(std::lround(at.y()));
    const int u_min = std::min(nearest_u, static_cast<int>(std::ceil(at.x() - reach)));
    const int u_max = std::max(nearest_u, static_cast<int>(std::floor(at.x() + reach)));
    const int v_min = std::min(nearest_v, static_cast<int>(std::ceil(at.y() - reach)));
    const int v_max = std::max(nearest_v, static_cast<int>(std::floor(at.y() + reach)));
    for (int v = std::max(0, v_min); v <= std::min(height_ - 1, v_max); ++v) {
      for (int u = std::max(0, u_min); u <= std::min(width_ - 1, u_max); ++u)
        drawn[static_cast<std::size_t>(v * width_ + u)] = 1;
    }
  }
  int both = 0;
  int either = 0;
  for (std::size_t n = 0; n < drawn.size(); ++n) {
    both += drawn[n] & inside_[n];
    either += drawn[n] | inside_[n];
  }
  return either > 0 ? static_cast<double>(both) / either : 0.0;
}

double ScoreSilhouettes(const CoarseShape& shape,
                        const Placement& placement,
                        const Eigen::Vector3d& real_size_m,
                        std::span<const SilhouetteView> views) {
  // One standard deviation of the sizes a design comes in (FitTerms::catalogue_sigma) costs as much
  // as this overlap.
  constexpr double kStretchCost = 0.01;
  constexpr double kStretchSigma = 0.15;  // as FitTerms::catalogue_sigma
  if (views.empty() || shape.empty()) return 0;
  const std::vector<Eigen::Vector3f> points = PlacedSolid(shape, placement);
  const Eigen::Vector3f metres = placement.size_m.cast<float>().cwiseQuotient(shape.extent());
  const float side_m = metres.mean() * CoarseShape::kCellSide;
  std::vector<std::uint8_t> drawn;
  double sum = 0;
  for (const SilhouetteView& view : views) sum += view.Overlap(points, side_m, drawn);
  const Eigen::Array3d stretch = (placement.size_m.array() / real_size_m.array()).log();
  const double cost = kStretchCost * (stretch / kStretchSigma).square().sum();
  return std::max(0.0, sum / static_cast<double>(views.size()) - cost);
}

SilhouetteFit FitSilhouettes(const CoarseShape& shape,
                             const Eigen::Vector3d& real_size_m,
                             std::span<const SilhouetteView> views,
                             const SilhouetteFitOptions& options) {
  constexpr int kNumYaws = 16;         // 22.5 degrees apart
  constexpr std::size_t kClimbed = 2;  // of the best starts: front and back often score alike
  std::vector<SilhouetteFit> starts;
  for (int n = 0; n < kNumYaws; ++n) {
    SilhouetteFit start;
    start.placement = PlaceByRays(
        shape, real_size_m, 2.0 * std::numbers::pi * n / kNumYaws, views, options.has_ground);
    start.score = ScoreSilhouettes(shape, start.placement, real_size_m, views);
    starts.push_back(start);
  }
  std::stable_sort(starts.begin(), starts.end(), [](const auto& a, const auto& b) {
    return a.score > b.score;
  });
  SilhouetteFit best;
  for (std::size_t n = 0; n < kClimbed; ++n) {
    const SilhouetteFit fit = Climb(shape, real_size_m, views, options, starts[n]);
    if (n == 0 || fit.score > best.score) best = fit;
  }
  return best;
}

}  // namespace deepslam::propose

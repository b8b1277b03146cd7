#include "deepslam/instances/view_votes.h"

#include <algorithm>
#include <cmath>
#include <numeric>
#include <optional>

#include "deepslam/core/check.h"

namespace deepslam::instances {
namespace {

constexpr double kMinDepthM = 0.2;  // depth cameras for rooms measure nothing nearer
// Fewer visible elements say nothing about a superpoint, however small it is.
constexpr int kMinVisible = 4;
// Boxes end where the network thinks the thing ends, give or take a pixel or two.
constexpr double kBoxSlackPx = 2;
// Of a class that is guessed by size, against one that a network or a person has recognised.
constexpr double kTrustInSize = 0.1;

// The image of one detection: its mask, or its box.
class Region {
 public:
  explicit Region(const Detection& detection) : box_px_(detection.box_px) {
    if (!detection.mask.empty()) mask_ = detection.mask.Unpacked();
    box_px_.u_min -= kBoxSlackPx;
    box_px_.v_min -= kBoxSlackPx;
    box_px_.u_max += kBoxSlackPx;
    box_px_.v_max += kBoxSlackPx;
  }
  [[nodiscard]] bool Contains(const Eigen::Vector2i& pixel) const {
    if (mask_.width() == 0) return box_px_.Contains(pixel.x(), pixel.y());
    return pixel.x() < mask_.width() && pixel.y() < mask_.height() &&
           mask_(pixel.x(), pixel.y()) != 0;
  }

 private:
  Box2 box_px_;
  Mask mask_;
};

// The smallest first: it claims what larger ones hold as well.
std::vector<std::size_t> BySize(std::span<const Detection> detections) {
  std::vector<std::size_t> order(detections.size());
  std::iota(order.begin(), order.end(), std::size_t{0});
  std::ranges::stable_sort(
      order, {}, [&](std::size_t n) { return detections[n].box_px.area_px(); });
  return order;
}

std::vector<int> CountBySuperpoint(const Superpoints& superpoints,
                                   const VisibleElements& visible,
                                   const Region* region) {
  std::vector<int> counts(static_cast<std::size_t>(superpoints.count()), 0);
  for (std::size_t n = 0; n < visible.elements.size(); ++n) {
    const int superpoint = superpoints.of_element[static_cast<std::size_t>(visible.elements[n])];
    if (superpoint < 0) continue;
    if (region == nullptr || region->Contains(visible.pixels[n]))
      ++counts[static_cast<std::size_t>(superpoint)];
  }
  return counts;
}

}  // namespace

void Describe(OptionsVisitor& visitor, VoteOptions& options) {
  visitor.Field("min_visible_share",
                options.min_visible_share,
                {0, 1},
                "1",
                "share of a superpoint that a frame must see to vote about it");
  visitor.Field(
      "min_mask_share",
      options.min_mask_share,
      {0, 1},
      "1",
      "share of what is seen of a superpoint that an instance mask must hold to claim it");
  visitor.Field(
      "min_box_share", options.min_box_share, {0, 1}, "1", "the same for a box without a mask");
  visitor.Field("depth_noise_m",
                options.depth_noise_m,
                {0.001, 1},
                "m",
                "the surface is visible where the depth is at most this far off ...");
  visitor.Field(
      "depth_noise_per_m", options.depth_noise_per_m, {0, 1}, "1", "... plus this times the depth");
}

VisibleElements FindVisible(const SurfaceElements& elements,
                            const VotingView& view,
                            const VoteOptions& options) {
  DEEPSLAM_CHECK(view.depth_m != nullptr, "a view has depth");
  const DepthImage& depth_m = *view.depth_m;
  VisibleElements visible;
  for (std::size_t i = 0; i < elements.size(); ++i) {
    const Eigen::Vector3d p_camera = view.camera_from_level * elements.points()[i].cast<double>();
    if (p_camera.z() < kMinDepthM) continue;
    const std::optional<Eigen::Vector2d> projected = view.camera.Project(p_camera);
    if (!projected) continue;
    const Eigen::Vector2d& pixel = *projected;
    if (!(pixel.x() > -0.5 && pixel.y() > -0.5 && pixel.x() < depth_m.width() - 0.5 &&
          pixel.y() < depth_m.height() - 0.5))
      continue;
    const Eigen::Vector2i nearest = pixel.array().round().cast<int>();
    const double measured_m = depth_m(nearest.x(), nearest.y());
    const double tolerance_m = options.depth_noise_m + options.depth_noise_per_m * p_camera.z();
    if (measured_m <= 0 || std::abs(measured_m - p_camera.z()) > tolerance_m) continue;
    visible.elements.push_back(static_cast<int>(i));
    visible.pixels.push_back(nearest);
  }
  return visible;
}

FrameClaims ClaimSuperpoints(const Superpoints& superpoints,
                             const VisibleElements& visible,
                             std::span<const Detection> detections,
                             const VoteOptions& options) {
  const std::vector<int> num_visible = CountBySuperpoint(superpoints, visible, nullptr);
  FrameClaims claims;
  std::vector<int> place(num_visible.size(), -1);
  for (std::size_t s = 0; s < num_visible.size(); ++s) {
    const double least = options.min_visible_share * superpoints.num_elements[s];
    if (num_visible[s] < kMinVisible || num_visible[s] < least) continue;
    place[s] = static_cast<int>(claims.superpoints.size());
    claims.superpoints.push_back(static_cast<int>(s));
  }
  claims.claimed_by.assign(claims.superpoints.size(), -1);
  for (const std::size_t n : BySize(detections)) {
    const Region region(detections[n]);
    const double min_share =
        detections[n].mask.empty() ? options.min_box_share : options.min_mask_share;
    const std::vector<int> num_inside = CountBySuperpoint(superpoints, visible, &region);
    for (std::size_t k = 0; k < claims.superpoints.size(); ++k) {
      const auto s = static_cast<std::size_t>(claims.superpoints[k]);
      if (claims.claimed_by[k] < 0 && num_inside[s] > min_share * num_visible[s])
        claims.claimed_by[k] = static_cast<int>(n);
    }
  }
  return claims;
}

void AddVotes(const FrameClaims& claims,
              std::span<const Detection> detections,
              int num_superpoints,
              ViewVotes& votes) {
  votes.classes.resize(static_cast<std::size_t>(num_superpoints));
  votes.num_views.resize(static_cast<std::size_t>(num_superpoints), 0);
  for (std::size_t k = 0; k < claims.superpoints.size(); ++k) {
    const auto s = static_cast<std::size_t>(claims.superpoints[k]);
    const int claimed_by = claims.claimed_by[k];
    ++votes.num_views[s];
    if (claimed_by >= 0) {
      const Detection& detection = detections[static_cast<std::size_t>(claimed_by)];
      const double trust = detection.source == DetectionSource::kCluster ? kTrustInSize : 1;
      votes.classes[s][detection.class_name] += trust * detection.score;
    }
    for (std::size_t l = k + 1; l < claims.superpoints.size(); ++l) {
      if (claimed_by < 0 && claims.claimed_by[l] < 0) continue;
      PairVotes& pair = votes.pairs[{claims.superpoints[k], claims.superpoints[l]}];
      (claimed_by == claims.claimed_by[l] ? pair.same : pair.different) += 1;
    }
  }
}

}  // namespace deepslam::instances
